// How deep the lists and tables of a text lie in each other.
#pragma once

#include <string>
#include <string_view>

namespace batten {

/// Lists, tables and the parts of a dotted key may lie in each other so deep.
inline constexpr int kMaxNestingDepth = 64;

/// Throws InputError with the place in `file` at which a TOML or JSON text goes deeper than
/// kMaxNestingDepth. Parsers, and destructors of what they made, call themselves at each level: text
/// of some thousand brackets would take the whole stack. What stands in quotes or comments does not
/// count. O(length).
void check_nesting_depth(std::string_view text, const std::string& file);

/// The same of the elements of an XML text. What stands in comments and quotes does not count.
void check_xml_nesting_depth(std::string_view text, const std::string& file);

}  // namespace batten
