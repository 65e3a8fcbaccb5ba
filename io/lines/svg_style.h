// SPDX-License-Identifier: MPL-2.0
// Style sheets (CSS) of SVG files, as far as they decide whether elements are drawn.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace batten {

/// What selectors of style sheets refer to: element name without namespace, id and classes.
struct SvgElementKey {
  std::string kind, id;
  std::vector<std::string> classes;
};

/// The value of a property in declarations "name: value; name: value" (a `style` attribute), without
/// "!important"; empty: not declared. If it is declared several times, the last one counts.
/// `important`: whether it is; null: not needed.
std::string css_declaration(std::string_view declarations, std::string_view property,
                            bool* important = nullptr);

/// The rules of the `style` elements of a file.
///
/// Selectors consist of element names, "*", ".class" and "#id", their combinations such as "g.off",
/// and the descendant (" ") and child (">") combinators. Rules with other selectors (attributes,
/// pseudo-classes) and at-rules, such as @media, are ignored.
class SvgStyleSheet {
 public:
  /// Adds the rules in the text of a `style` element that declare `display` or `visibility`.
  /// Incorrect rules are ignored. Throws InputError for more than 1,000 rules.
  void add(std::string_view text);
  bool empty() const { return rules_.empty(); }

  /// The value of one of these properties for an element, by the rule of highest specificity; of
  /// equal ones, by the last. Declarations with "!important" precede others. `path`: the element,
  /// preceded by its ancestors. Empty: no rule declares the property.
  std::string value(const std::vector<SvgElementKey>& path, std::string_view property) const;

 private:
  struct Compound {
    SvgElementKey key;      // empty kind: any
    bool child_of = false;  // combined with the previous one by ">"
  };
  struct Rule {
    std::vector<Compound> selector;
    int specificity = 0;
    std::string declarations;
  };
  static bool parse_selector(std::string_view text, Rule& rule);
  static bool matches(const Rule& rule, const std::vector<SvgElementKey>& path);

  std::vector<Rule> rules_;
};

}  // namespace batten
