#include "batten/io/meshes/mesh_source_text.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <functional>

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
  while (i < rest.size() && is_blank(rest[i])) ++i;
  const size_t start = i;
  while (i < rest.size() && !is_blank(rest[i])) ++i;
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

MeshSourceText::MeshSourceText(const fs::path& path, bool binary) {
  open({path, read_input_file(path, "a mesh"), 0, std::string::npos, path.filename()}, binary);
  const std::string& text = this->text();
  if (std::all_of(text.begin(), text.end(), [](char c) { return is_blank(c) || c == '\n'; }))
    fail(size_t{0}, "found an empty file, expected a mesh");
}

void MeshSourceText::open(Source source, bool binary) {
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

}  // namespace batten
