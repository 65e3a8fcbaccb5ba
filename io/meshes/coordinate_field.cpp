// The characters that stand for a coordinate in a field of a file.
#include "batten/io/meshes/coordinate_field.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "batten/core/isize.h"

namespace batten {
namespace {

/// Significant digits without zeros at the end, and the decimal exponent of the first one.
struct Decimal {
  std::string digits;
  int exponent;
};

/// As few digits as give the double back, `most` at most; |value| > 0.
Decimal decimal(double value, int most) {
  char text[64];
  auto end =
      std::to_chars(text, text + sizeof text, std::abs(value), std::chars_format::scientific);
  const auto split = [&] {
    const std::string_view all(text, static_cast<size_t>(end.ptr - text));
    const size_t e = all.find('e');
    Decimal result{std::string(1, text[0]), std::atoi(std::string(all.substr(e + 1)).c_str())};
    if (e > 2) result.digits += all.substr(2, e - 2);
    while (result.digits.size() > 1 && result.digits.back() == '0') result.digits.pop_back();
    return result;
  };
  Decimal shortest = split();
  if (isize(shortest.digits) <= most) return shortest;
  end = std::to_chars(text, text + sizeof text, std::abs(value), std::chars_format::scientific,
                      most - 1);
  return split();
}

/// digits · 10^exponent / 10^power with its point.
std::string plain(const Decimal& d, int power) {
  const int before = d.exponent - power + 1, count = isize(d.digits);
  if (before <= 0) return "." + std::string(static_cast<size_t>(-before), '0') + d.digits;
  if (before >= count)
    return d.digits + std::string(static_cast<size_t>(before - count), '0') + ".";
  return d.digits.substr(0, static_cast<size_t>(before)) + "." +
         d.digits.substr(static_cast<size_t>(before));
}

}  // namespace

std::string fixed_real(double value, int width, bool nastran) {
  if (value == 0) return "0.";
  const std::string sign = value < 0 ? "-" : "";
  const int room = width - isize(sign);
  const int e = decimal(value, 17).exponent;
  std::string best;
  double best_error = std::numeric_limits<double>::infinity();
  const auto attempt = [&](int power, const std::string& exponent) {
    // The point takes one character, and so do zeros between it and the digits.
    const int most = room - isize(exponent) - 1 + std::min(0, e - power + 1);
    if (most < 1) return;
    const std::string text = sign + plain(decimal(value, most), power) + exponent;
    double written = 0;
    if (isize(text) > width || !parse_real(text, written)) return;
    const double error = std::abs(written - value);
    if (error < best_error || (error == best_error && text.size() < best.size())) {
      best = text;
      best_error = error;
    }
  };
  attempt(0, "");
  // Between 0.1 and where the digits fill the field, an exponent can only cost digits.
  if (!best.empty() && e >= -1 && e < room - 2) return best;
  // Moving the point can shorten the exponent: 1.234+10 is 12.345+9, 1.234-10 is .12345-9.
  for (const int power : {e, e + 1, 9, 99, -9, -99}) {
    const std::string digits = std::to_string(power);
    attempt(power, nastran ? (power < 0 ? "" : "+") + digits : "e" + digits);
  }
  return best;
}

int width_of(FieldKind kind) {
  switch (kind) {
    case FieldKind::Nastran8:
      return 8;
    case FieldKind::Nastran16:
    case FieldKind::NastranFree:
    case FieldKind::Dyna16:
    case FieldKind::DynaFree16:
      return 16;
    case FieldKind::Abaqus:
    case FieldKind::Dyna20:
    case FieldKind::DynaFree20:
      return 20;
    default:
      return 0;
  }
}

bool is_fixed_width(FieldKind kind) {
  return kind == FieldKind::Nastran8 || kind == FieldKind::Nastran16 || kind == FieldKind::Dyna16 ||
         kind == FieldKind::Dyna20;
}

namespace {

bool nastran(FieldKind kind) {
  return kind == FieldKind::Nastran8 || kind == FieldKind::Nastran16 ||
         kind == FieldKind::NastranFree;
}

template <class Real>
std::string bytes_of(double value, bool swapped, double& written) {
  const Real real = static_cast<Real>(value);
  written = static_cast<double>(real);
  std::string bytes(sizeof real, '\0');
  std::memcpy(bytes.data(), &real, sizeof real);
  if (swapped != (std::endian::native == std::endian::big))
    std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

}  // namespace

std::string format_field(double value, FieldKind kind, double& written) {
  switch (kind) {
    case FieldKind::Float32:
      return bytes_of<float>(value, false, written);
    case FieldKind::Float64:
      return bytes_of<double>(value, false, written);
    case FieldKind::Float32Swapped:
      return bytes_of<float>(value, true, written);
    case FieldKind::Float64Swapped:
      return bytes_of<double>(value, true, written);
    case FieldKind::Free: {
      char text[32];
      written = value;
      return {text, std::to_chars(text, text + sizeof text, value).ptr};
    }
    default:
      break;
  }
  const std::string text = fixed_real(value, width_of(kind), nastran(kind));
  parse_real(text, written);
  return text;
}

std::string aligned(const std::string& text, const Field& field, std::string_view old) {
  if (!is_fixed_width(field.kind)) return text;
  const auto width = static_cast<size_t>(width_of(field.kind));
  const bool left = !old.empty() && !is_blank(old.front());
  if (!left) return std::string(width - text.size(), ' ') + text;
  // A field that ends with the line needs no blanks behind it, one with a tab in it needs all.
  const bool tab = old.find('\t') != old.npos;
  const size_t to = field.open || tab ? width : std::min(width, old.size());
  return text + std::string(to > text.size() ? to - text.size() : 0, ' ');
}

std::string large_field_grid(std::string_view line, const std::array<std::string, 3>& coordinates,
                             const std::string& line_end) {
  const std::string_view data = line.substr(0, line.find('$'));
  const auto field = [&](size_t number) {
    const size_t begin = 8 * number;
    std::string text(begin < data.size() ? trimmed(data.substr(begin, 8)) : "");
    return std::string(16 - text.size(), ' ') + text;
  };
  const auto right = [](const std::string& text) {
    return std::string(16 - text.size(), ' ') + text;
  };
  std::string second = "*       " + right(coordinates[2]) + field(6) + field(7) + field(8);
  second.resize(trimmed(second).size());
  if (data.size() < line.size()) second += " " + std::string(line.substr(data.size()));
  return "GRID*   " + field(1) + field(2) + right(coordinates[0]) + right(coordinates[1]) +
         line_end + second;
}

}  // namespace batten
