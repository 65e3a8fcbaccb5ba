// Small things that all readers of text need.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace batten {

/// A blank other than a line end.
inline bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v';
}
/// Without blanks at both ends.
std::string_view trimmed(std::string_view text);
/// ASCII letters only.
std::string lower_case(std::string text);
/// ".obj" for "a.OBJ".
std::string lower_extension(const std::filesystem::path& path);
/// "1 point", "2 points"; "3 tori" with `many`.
std::string format_count(long count, const std::string& noun, const std::string& many = "");

}  // namespace batten
