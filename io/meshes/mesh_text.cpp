#include "batten/io/meshes/mesh_text.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>

#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"

namespace batten {
namespace fs = std::filesystem;

std::string upper(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return result;
}

std::string_view next_word(std::string_view& rest) {
  size_t i = 0;
  while (i < rest.size() && blank(rest[i])) ++i;
  const size_t start = i;
  while (i < rest.size() && !blank(rest[i])) ++i;
  const std::string_view word = rest.substr(start, i - start);
  rest.remove_prefix(i);
  return word;
}

bool parse_real(std::string_view field, double& value) {
  // from_chars knows no leading plus.
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

MeshText::MeshText(const fs::path& path, bool binary) : path_(path) {
  text_ = input_bytes(path, "a mesh");
  if (std::all_of(text_.begin(), text_.end(), [](char c) { return blank(c) || c == '\n'; }))
    fail(size_t{0}, "found an empty file, expected a mesh");
  if (binary) return;
  if (text_.starts_with("\xFF\xFE") || text_.starts_with("\xFE\xFF"))
    fail(size_t{0}, "found UTF-16 text, expected UTF-8 or ASCII");
  if (const void* zero = std::memchr(text_.data(), 0, text_.size()))
    fail(static_cast<size_t>(static_cast<const char*>(zero) - text_.data()),
         "found a zero byte, expected text");
  if (text_.starts_with("\xEF\xBB\xBF")) at_ = 3;
}

bool MeshText::next(std::string_view& line) {
  if (at_ >= text_.size()) return false;
  const char* begin = text_.data() + at_;
  const void* end = std::memchr(begin, '\n', text_.size() - at_);
  const size_t length =
      end ? static_cast<size_t>(static_cast<const char*>(end) - begin) : text_.size() - at_;
  at_ += length + (end != nullptr);
  line = {begin, length};
  if (line.ends_with('\r')) line.remove_suffix(1);
  return true;
}

long MeshText::line_of(size_t offset) const {
  return 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(offset), '\n');
}

void MeshText::fail(size_t offset, const std::string& message) const {
  const size_t line_end = offset == 0 ? text_.npos : text_.rfind('\n', offset - 1);
  const size_t column = line_end == text_.npos ? offset : offset - line_end - 1;
  throw InputError(path_.string() + ":" + std::to_string(line_of(offset)) + ":" +
                   std::to_string(column + 1) + ": " + message);
}

double MeshText::real(std::string_view field, bool blank_is_zero) const {
  double value = 0;
  if (blank_is_zero && field.empty()) return 0;
  if (!parse_real(field, value)) {
    const bool digits =
        !field.empty() && field.find_first_not_of("0123456789.-+eEdD") == field.npos;
    fail(field, "found " + (field.empty() ? "nothing" : in_quotes(field)) + ", expected a number" +
                    (digits ? " between 1e-307 and 1e308" : ""));
  }
  if (!std::isfinite(value))
    fail(field, "found " + in_quotes(field) + ", expected a finite number");
  return value;
}

long MeshText::integer(std::string_view field, const std::string& expected) const {
  long value = 0;
  if (!parse_integer(field, value))
    fail(field,
         "found " + (field.empty() ? "nothing" : in_quotes(field)) + ", expected " + expected);
  return value;
}

}  // namespace batten
