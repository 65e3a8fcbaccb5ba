// SPDX-License-Identifier: MPL-2.0
#include "batten/io/meshes/mesh_source_text.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"

namespace batten {
namespace fs = std::filesystem;

std::string upper(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return result;
}

std::string_view next_token(std::string_view& rest) {
  size_t i = 0;
  while (i < rest.size() && is_blank(rest[i])) ++i;
  const size_t start = i;
  while (i < rest.size() && !is_blank(rest[i])) ++i;
  const std::string_view token = rest.substr(start, i - start);
  rest.remove_prefix(i);
  return token;
}

bool parse_real(std::string_view field, double& value) {
  // std::from_chars rejects a leading plus.
  if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
  const char *first = field.data(), *last = first + field.size();
  const auto [end, error] = std::from_chars(first, last, value);
  if (error != std::errc()) return false;
  if (end == last) return true;
  std::string_view mantissa(first, static_cast<size_t>(end - first)), exponent = field;
  exponent.remove_prefix(mantissa.size());
  const bool letter = exponent[0] == 'd' || exponent[0] == 'D';
  if (!letter && exponent[0] != '+' && exponent[0] != '-') return false;
  if (mantissa.find_first_not_of("0123456789.-") != std::string_view::npos) return false;
  if (letter) exponent.remove_prefix(1);
  if (exponent.starts_with('+')) exponent.remove_prefix(1);
  const std::string text = std::string(mantissa) + "e" + std::string(exponent);
  const auto whole = std::from_chars(text.data(), text.data() + text.size(), value);
  return whole.ec == std::errc() && whole.ptr == text.data() + text.size();
}

bool parse_integer(std::string_view field, long& value) {
  if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
  const char* last = field.data() + field.size();
  const auto [end, error] = std::from_chars(field.data(), last, value);
  return error == std::errc() && end == last;
}

namespace {

fs::path true_path(const fs::path& file) {
  std::error_code error;
  const fs::path result = fs::weakly_canonical(file, error);
  return error ? file.lexically_normal() : result;
}

}  // namespace

MeshSourceText::MeshSourceText(const fs::path& path, bool binary)
    : MeshSourceText(path, read_input_file(path, "a mesh"), binary) {}

MeshSourceText::MeshSourceText(const fs::path& path, std::string content, bool binary) {
  open({path, true_path(path), std::move(content), 0, std::string::npos, path.filename()}, binary);
  const std::string& text = this->text();
  different_bytes_ = text.size();
  if (std::all_of(text.begin(), text.end(), [](char c) { return is_blank(c) || c == '\n'; }))
    fail(size_t{0}, "found an empty file, expected a mesh");
}

void MeshSourceText::open(Source source, bool binary) {
  if (!binary) source.ends_with_carriage_returns = replace_carriage_returns(source.text);
  if (!sources_.empty()) source.base = sources_.back()->base + sources_.back()->text.size() + 1;
  sources_.push_back(std::make_shared<const Source>(std::move(source)));
  current_ = sources_.size() - 1;
  at_ = 0;
  if (binary) return;
  const std::string& text = current().text;
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
    fail(current().base, "found UTF-16 text, expected UTF-8 or ASCII");
  if (const auto zero = text.find('\0'); zero != text.npos)
    fail(current().base + zero, "found a zero byte, expected text");
  if (text.starts_with("\xEF\xBB\xBF")) at_ = 3;
}

bool MeshSourceText::next(std::string_view& line) {
  while (!next_in_file(line))
    if (!leave_file()) return false;
  return true;
}

bool MeshSourceText::next_in_file(std::string_view& line) {
  const std::string& text = current().text;
  if (at_ >= text.size()) return false;
  const char* begin = text.data() + at_;
  const void* end = std::memchr(begin, '\n', text.size() - at_);
  const size_t length =
      end ? static_cast<size_t>(static_cast<const char*>(end) - begin) : text.size() - at_;
  at_ += length + (end != nullptr);
  line = {begin, length};
  if (line.ends_with('\r')) line.remove_suffix(1);
  return true;
}

bool MeshSourceText::leave_file() {
  if (open_.empty()) return false;
  current_ = open_.back().source;
  at_ = open_.back().at;
  open_.pop_back();
  return true;
}

size_t MeshSourceText::offset(std::string_view part) const {
  const std::less_equal<const char*> before;
  const auto in = [&](const Source& source) {
    const char* begin = source.text.data();
    return before(begin, part.data()) && before(part.data(), begin + source.text.size());
  };
  const auto of = [&](const Source& source) {
    return source.base + static_cast<size_t>(part.data() - source.text.data());
  };
  if (in(current())) return of(current());
  for (const auto& source : sources_)
    if (in(*source)) return of(*source);
  return 0;
}

size_t MeshSourceText::source_index(size_t offset) const {
  const auto behind =
      std::upper_bound(sources_.begin() + 1, sources_.end(), offset,
                       [](size_t at, const auto& source) { return at < source->base; });
  return static_cast<size_t>(behind - sources_.begin()) - 1;
}

std::string_view MeshSourceText::part(size_t offset, size_t length) const {
  const Source& source = source_of(offset);
  return std::string_view(source.text).substr(offset - source.base, length);
}

namespace {

long line_in(const MeshSourceText::Source& source, size_t offset) {
  const char* begin = source.text.data();
  return 1 + std::count(begin, begin + (offset - source.base), '\n');
}

}  // namespace

std::string MeshSourceText::line_name(size_t offset, size_t seen_from) const {
  const Source& source = source_of(offset);
  const std::string line = "line " + std::to_string(line_in(source, offset));
  return &source == &source_of(seen_from) ? line : line + " of " + source.path.string();
}

void MeshSourceText::fail(size_t offset, const std::string& message) const {
  const Source& source = source_of(offset);
  const size_t at = offset - source.base;
  const size_t line_end = at == 0 ? source.text.npos : source.text.rfind('\n', at - 1);
  const size_t column = line_end == source.text.npos ? at : at - line_end - 1;
  throw InputError(source.path.string() + ":" + std::to_string(line_in(source, offset)) + ":" +
                   std::to_string(column + 1) + ": " + message);
}

double MeshSourceText::real(std::string_view field, bool blank_is_zero) const {
  double value = 0;
  if (blank_is_zero && field.empty()) return 0;
  if (!parse_real(field, value)) {
    const bool digits =
        !field.empty() && field.find_first_not_of("0123456789.-+eEdD") == field.npos;
    fail(field, "found " + (field.empty() ? "nothing" : quoted_excerpt(field)) +
                    ", expected a number" + (digits ? " between 1e-307 and 1e308" : ""));
  }
  if (!std::isfinite(value))
    fail(field, "found " + quoted_excerpt(field) + ", expected a finite number");
  return value;
}

long MeshSourceText::integer(std::string_view field, const std::string& expected) const {
  long value = 0;
  if (!parse_integer(field, value))
    fail(field,
         "found " + (field.empty() ? "nothing" : quoted_excerpt(field)) + ", expected " + expected);
  return value;
}

// Formatting of coordinates in the fields of a file.

namespace {

/// Significant digits without trailing zeros, and the decimal exponent of the first digit.
struct Decimal {
  std::string digits;
  int exponent;
};

/// The fewest digits that reproduce the double, limited to `most` digits; |value| > 0.
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

/// Formats digits · 10^exponent / 10^power with a decimal point.
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
    // The decimal point takes one character, and so does each zero between it and the digits.
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
  // For values from 0.1 up to those whose digits fill the field, an exponent would only cost
  // digits.
  if (!best.empty() && e >= -1 && e < room - 2) return best;
  // A shifted decimal point can shorten the exponent: 1.234+10 is 12.345+9, 1.234-10 is .12345-9.
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
    case FieldKind::Dyna10:
    case FieldKind::DynaFree10:
      return 10;
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
  return kind == FieldKind::Nastran8 || kind == FieldKind::Nastran16 || kind == FieldKind::Dyna10 ||
         kind == FieldKind::Dyna16 || kind == FieldKind::Dyna20;
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
  // A field at the end of a line needs no padding; one that contains a tab needs full padding.
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

// Included files.

namespace {

// Limits the total number of files: nested files that are each included several times grow
// exponentially.
constexpr size_t kMostFiles = 10000;
constexpr int kDeepestInclude = 64;
// Limits the text of files that are included many times: each has its own copy.
constexpr size_t kMostRepeated = 16;
constexpr size_t kAlwaysAllowed = 1 << 24;  // bytes

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

/// Decks from other systems may use backslashes as separators.
std::string with_slashes(std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  return name;
}

}  // namespace

std::string MeshSourceText::include_trace(size_t offset) const {
  std::string text;
  for (size_t at = offset; at != std::string::npos; at = source_of(at).included_at) {
    const std::string line = line_name(at, at);
    text = source_of(at).path.string() + ":" + line.substr(line.find(' ') + 1) + ": " + text;
  }
  return text;
}

void MeshSourceText::include(const std::string& name, std::string_view where,
                             const std::vector<std::string>& folders) {
  const size_t line = offset(where);
  if (name.empty()) fail(line, "found no name of a file, expected one");
  const fs::path root = folder_of(path()), here = folder_of(source_of(line).path);
  fs::path found;
  bool elsewhere = false;
  for (const fs::path& named : {fs::path(name), fs::path(with_slashes(name))}) {
    std::vector<std::pair<fs::path, bool>> tries{{here / named, false}, {root / named, false}};
    for (const std::string& folder : folders)
      tries.push_back({root / folder / named, fs::path(folder).is_absolute()});
    for (const auto& [file, absolute] : tries) {
      std::error_code error;
      if (!found.empty() || !fs::exists(file, error)) continue;
      found = file;
      elsewhere = absolute || named.is_absolute();
    }
  }
  if (found.empty()) found = here / with_slashes(name);
  // Normalises the path: "parts/a.bdf" instead of "parts/../parts/a.bdf".
  found = found.lexically_normal();
  const fs::path canonical = true_path(found);
  for (size_t at = line; at != std::string::npos; at = source_of(at).included_at)
    if (source_of(at).canonical == canonical)
      throw InputError(include_trace(line) + "found " + found.string() +
                       ", which includes itself, expected includes without a cycle");
  if (depth() >= kDeepestInclude || sources_.size() >= kMostFiles)
    throw InputError(include_trace(line) + "found more files than are followed (" +
                     std::to_string(kMostFiles) + ", " + std::to_string(kDeepestInclude) +
                     " deep)");
  Source source{found, canonical, read_input_file(found, "an included file", include_trace(line)),
                0,     line,      {}};
  const Source& last = *sources_.back();
  const size_t all = last.base + last.text.size() + source.text.size();
  if (included_.insert(canonical).second) different_bytes_ += source.text.size();
  const size_t most =
      std::min<size_t>(kMaxInputFileSize, kAlwaysAllowed + kMostRepeated * different_bytes_);
  if (all > most)
    throw InputError(include_trace(line) + "found " + std::to_string(all >> 20) +
                     " MB of included files, expected " + std::to_string(most >> 20) +
                     " MB at most, or files that are included fewer times");
  if (!elsewhere) source.beside = true_path(found).lexically_relative(true_path(root));
  open_.push_back({current_, at_});
  open(std::move(source), false);
}

}  // namespace batten
