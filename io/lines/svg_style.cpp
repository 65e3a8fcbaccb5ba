// SPDX-License-Identifier: MPL-2.0
#include "batten/io/lines/svg_style.h"

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/io/files/text.h"

namespace batten {
namespace {

constexpr size_t kMaxRules = 1000;  // each is compared with each element

std::string_view trimmed_rows(std::string_view text) {
  constexpr std::string_view kWhite = " \t\r\n\f";
  const size_t begin = text.find_first_not_of(kWhite);
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(kWhite) + 1 - begin);
}

std::string without_comments(std::string_view text) {
  std::string clean;
  for (size_t at = 0; at < text.size();) {
    const size_t open = std::min(text.find("/*", at), text.size());
    clean += text.substr(at, open - at);
    if (open == text.size()) break;
    const size_t close = text.find("*/", open + 2);
    at = close == text.npos ? text.size() : close + 2;
  }
  return clean;
}

// The position behind the block that begins with '{' at `open`, which may contain blocks.
size_t behind_block(std::string_view text, size_t open) {
  int depth = 0;
  for (size_t i = open; i < text.size(); ++i) {
    if (text[i] == '{') ++depth;
    if (text[i] == '}' && --depth == 0) return i + 1;
  }
  return text.size();
}

bool is_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
         c == '_' || (static_cast<unsigned char>(c) & 0x80) != 0;
}

bool key_fits(const SvgElementKey& wanted, const SvgElementKey& element) {
  if (!wanted.kind.empty() && wanted.kind != element.kind) return false;
  if (!wanted.id.empty() && wanted.id != element.id) return false;
  return std::all_of(wanted.classes.begin(), wanted.classes.end(), [&](const std::string& one) {
    return std::find(element.classes.begin(), element.classes.end(), one) != element.classes.end();
  });
}

}  // namespace

std::string css_declaration(std::string_view declarations, std::string_view property,
                            bool* important) {
  std::string value;
  for (size_t at = 0; at < declarations.size();) {
    const size_t end = std::min(declarations.find(';', at), declarations.size());
    const std::string_view one = declarations.substr(at, end - at);
    at = end + 1;
    const size_t colon = one.find(':');
    if (colon == one.npos || trimmed_rows(one.substr(0, colon)) != property) continue;
    std::string_view found = trimmed_rows(one.substr(colon + 1));
    const size_t mark = found.find('!');
    if (important) *important = mark != found.npos;
    found = trimmed_rows(found.substr(0, mark));
    value = found;
  }
  return value;
}

// Reads a selector without commas; false if it is not supported.
bool SvgStyleSheet::parse_selector(std::string_view text, Rule& rule) {
  constexpr int kOfId = 10000, kOfClass = 100;
  bool child = false, joined = false;  // joined: to the previous part of the same compound
  for (size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (is_blank(c) || c == '\n' || c == '>') {
      child = child || c == '>';
      joined = false;
      ++i;
      continue;
    }
    const bool marked = c == '.' || c == '#' || c == '*';
    if (!marked && !is_name(c)) return false;
    if (!joined) {
      rule.selector.push_back({{}, child && !rule.selector.empty()});
      child = false;
    }
    joined = true;
    size_t end = i + marked;
    while (c != '*' && end < text.size() && is_name(text[end])) ++end;
    const std::string name(text.substr(i + marked, end - i - marked));
    if (name.empty() && c != '*') return false;
    SvgElementKey& key = rule.selector.back().key;
    if (c == '.') {
      key.classes.push_back(name);
      rule.specificity += kOfClass;
    } else if (c == '#') {
      key.id = name;
      rule.specificity += kOfId;
    } else if (c != '*') {
      key.kind = name;
      ++rule.specificity;
    }
    i = end;
  }
  return !rule.selector.empty() && !child;
}

void SvgStyleSheet::add(std::string_view sheet) {
  const std::string text = without_comments(sheet);
  for (size_t at = 0;;) {
    at = text.find_first_not_of(" \t\r\n\f", at);
    if (at == text.npos) return;
    const size_t open = text.find('{', at), semicolon = text.find(';', at);
    if (text[at] == '@') {  // "@import …;" or "@media … { … }"
      at = semicolon < open ? semicolon + 1 : behind_block(text, std::min(open, text.size()));
      continue;
    }
    if (open == text.npos) return;
    const size_t end = behind_block(text, open);
    const std::string_view body = std::string_view(text).substr(open + 1, end - open - 1),
                           declarations = body.substr(0, body.find('}'));
    for (size_t begin = at; begin <= open;) {
      const size_t comma = std::min(text.find(',', begin), open);
      Rule rule;
      rule.declarations = declarations;
      const bool decides = !css_declaration(declarations, "display").empty() ||
                           !css_declaration(declarations, "visibility").empty();
      if (decides && parse_selector(std::string_view(text).substr(begin, comma - begin), rule))
        rules_.push_back(std::move(rule));
      begin = comma + 1;
    }
    at = end;
    if (rules_.size() > kMaxRules)
      throw InputError("found more than " + std::to_string(kMaxRules) +
                       " style rules with 'display' or 'visibility', expected fewer");
  }
}

bool SvgStyleSheet::matches(const Rule& rule, const std::vector<SvgElementKey>& path) {
  // reached[i]: the compounds up to the current one match elements of the path, the last one path[i].
  std::vector<char> reached(path.size(), 1);
  for (size_t part = 0; part < rule.selector.size(); ++part) {
    const Compound& compound = rule.selector[part];
    bool any_above = false;
    for (size_t i = 0; i < path.size(); ++i) {
      const bool here = reached[i] != 0, above = part == 0 || any_above;
      any_above = compound.child_of ? here : any_above || here;
      reached[i] = above && key_fits(compound.key, path[i]);
    }
  }
  return reached.back() != 0;
}

std::string SvgStyleSheet::value(const std::vector<SvgElementKey>& path,
                                 std::string_view property) const {
  std::string value;
  int specificity = -1;
  for (const Rule& rule : rules_) {
    bool important = false;
    const std::string declared = css_declaration(rule.declarations, property, &important);
    constexpr int kOfImportant = 1000000;
    const int own = rule.specificity + (important ? kOfImportant : 0);
    if (own < specificity) continue;
    if (declared.empty() || !matches(rule, path)) continue;
    value = declared;
    specificity = own;
  }
  return value;
}

}  // namespace batten
