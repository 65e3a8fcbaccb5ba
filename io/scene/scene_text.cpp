// SPDX-License-Identifier: MPL-2.0
#include "batten/io/scene/scene_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "batten/core/errors.h"
#include "batten/io/scene/deform_scene.h"
#include "batten/io/scene/scene_parsing.h"

namespace batten {
namespace {

bool is_header(const toml::node& node, const std::string& text, size_t at) {
  return node.is_table() && !node.as_table()->is_inline() && at < text.size() && text[at] == '[';
}

/// Throws InputError unless `key = value` is exactly one TOML assignment.
void require_one(const std::string& key, const std::string& value,
                 const std::filesystem::path& file) {
  const toml::table one = parse_toml(key + " = " + value, file, "a value");
  if (one.size() != 1 || !one.contains(key))
    throw InputError("found " + quoted_excerpt(key + " = " + value) +
                     ", expected one key and its value");
}

/// Length in bytes of a UTF-8 character, from its first byte.
size_t bytes_of_character(unsigned char first) {
  return first < 0x80 ? 1 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
}

}  // namespace

/// A byte range of the text.
struct SceneText::Span {
  size_t from = 0, to = 0;
};

/// The parsed text with source positions.
struct SceneText::Parsed {
  Parsed(const std::string& scene_text, const std::filesystem::path& file)
      : text(scene_text), root(parse_toml(text, file, "a scene")) {
    lines.push_back(text.starts_with("\xEF\xBB\xBF") ? 3 : 0);
    for (size_t i = 0; i < text.size(); ++i)
      if (text[i] == '\n') lines.push_back(i + 1);
    for (const auto& [key, node] : root) {
      const std::string kind(key.str());
      if (const toml::array* list = tables_in(node)) {
        int count = 0;
        for (const toml::node& one : *list) add(kind, "#" + std::to_string(++count), one);
      } else if (node.is_table()) {
        add(kind, "", node);
      }
    }
    std::stable_sort(tables.begin(), tables.end(),
                     [](const Table& a, const Table& b) { return a.span.from < b.span.from; });
  }

  struct Table {
    SceneTable name;
    const toml::table* node;
    Span span;      // of its header, or of a whole inline table
    bool header{};  // true: [KIND] or [[KIND]]
  };

  static const toml::array* tables_in(const toml::node& node) {
    const toml::array* list = node.as_array();
    return list && !list->empty() && list->is_homogeneous(toml::node_type::table) ? list : nullptr;
  }

  /// Adds a table. `number` replaces a missing name; it is empty for tables that occur once. Nested
  /// tables such as [[edit.handle]] follow, with `outer` as a prefix.
  void add(const std::string& kind, const std::string& number, const toml::node& node,
           const std::string& outer = "") {
    const toml::table& table = *node.as_table();
    const std::string stated = table["name"].value_or(std::string());
    const std::string own = number.empty() ? "" : stated.empty() ? number : stated;
    const Span span = span_of(node);
    tables.push_back({{kind, outer + own}, &table, span, is_header(node, text, span.from)});
    if (number.empty()) return;
    for (const auto& [key, inner] : table) {
      const toml::array* list = tables_in(inner);
      for (size_t i = 0; list && i < list->size(); ++i)
        add(kind + "." + std::string(key.str()), "#" + std::to_string(i + 1), *list->get(i),
            outer + own + ".");
    }
  }

  size_t offset(const toml::source_position& at) const {
    size_t i = lines.at(std::min<size_t>(at.line, lines.size()) - 1);
    for (unsigned column = 1; column < at.column && i < text.size(); ++column)
      i += bytes_of_character(static_cast<unsigned char>(text[i]));
    return std::min(i, text.size());
  }
  Span span_of(const toml::node& node) const {
    return {offset(node.source().begin), offset(node.source().end)};
  }
  Span span_of(const toml::key& key) const {
    return {offset(key.source().begin), offset(key.source().end)};
  }
  size_t line_start(size_t at) const {
    const size_t end = text.rfind('\n', at == 0 ? 0 : at - 1);
    return at == 0 || end == std::string::npos ? 0 : end + 1;
  }
  /// Offset after the end of the line.
  size_t line_end(size_t at) const {
    const size_t end = text.find('\n', at);
    return end == std::string::npos ? text.size() : end + 1;
  }
  std::string end_of_line() const {
    const size_t end = text.find('\n');
    return end != std::string::npos && end > 0 && text[end - 1] == '\r' ? "\r\n" : "\n";
  }

  const Table* find(const SceneTable& name) const {
    for (const Table& table : tables)
      if (table.name == name) return &table;
    return nullptr;
  }
  const toml::table& node_of(const SceneTable& name) const {
    if (name == SceneTable{}) return root;
    if (const Table* table = find(name)) return *table->node;
    std::vector<std::string> names;
    for (const Table& table : tables)
      if (table.name.kind == name.kind) names.push_back(table.name.name);
    throw InputError(
        "found no " +
        (name.name.empty() ? "[" + name.kind + "]" : "[[" + name.kind + "]] '" + name.name + "'") +
        ", expected " +
        (names.empty() ? "a table of the scene" : expected_one_of(name.name, names)));
  }

  bool starts_with_header(const toml::array& list) const {
    return is_header(*list.get(0), text, span_of(*list.get(0)).from);
  }

  /// End of a table's content: after its last value and those of nested tables.
  size_t content_end(const toml::table& table, size_t at) const {
    for (const auto& [key, node] : table) {
      at = std::max(at, span_of(node).to);
      if (const toml::table* inner = node.as_table()) at = content_end(*inner, at);
      if (const toml::array* list = tables_in(node))
        for (const toml::node& one : *list)
          at = std::max(at, content_end(*one.as_table(), span_of(one).to));
    }
    return at;
  }
  /// Offset after the last value of the table itself; `at` if there is none.
  size_t own_end(const toml::table& table, size_t at) const {
    for (const auto& [key, node] : table) {
      const Span span = span_of(node);
      const toml::array* list = tables_in(node);
      const bool elsewhere =
          is_header(node, text, span.from) || (list && starts_with_header(*list));
      if (!elsewhere) at = std::max(at, span.to);
    }
    return at;
  }
  /// Spans of a key and of its value.
  std::optional<std::pair<Span, Span>> entry(const toml::table& table,
                                             const std::string& key) const {
    const auto found = table.find(key);
    if (found == table.end()) return std::nullopt;
    return std::pair(span_of(found->first), span_of(found->second));
  }

  std::vector<Value> values_of(const SceneTable& table) const;

  const std::string& text;
  toml::table root;
  std::vector<size_t> lines;  // offsets of the lines
  std::vector<Table> tables;
};

SceneText::SceneText(std::string text, std::filesystem::path file)
    : file_(std::move(file)), text_(std::move(text)) {
  read();
}

void SceneText::read() {
  const Parsed parsed(text_, file_);
  names_.clear();
  for (const Parsed::Table& table : parsed.tables) names_.push_back(table.name);
}

void SceneText::splice(size_t from, size_t to, const std::string& with) {
  SceneText changed = *this;
  changed.text_.replace(from, to - from, with);
  changed.read();
  *this = std::move(changed);
}

bool SceneText::has(const SceneTable& table) const {
  return table == SceneTable{} || std::find(names_.begin(), names_.end(), table) != names_.end();
}

std::vector<SceneText::Value> SceneText::Parsed::values_of(const SceneTable& table) const {
  std::vector<std::pair<size_t, Value>> found;
  for (const auto& [key, node] : node_of(table)) {
    const Span span = span_of(node);
    const toml::array* list = tables_in(node);
    const bool comma_separated = list && (table == SceneTable{} || starts_with_header(*list));
    if (!is_header(node, text, span.from) && !comma_separated)
      found.emplace_back(span_of(key).from,
                         Value(key.str(), text.substr(span.from, span.to - span.from)));
  }
  std::sort(found.begin(), found.end());
  std::vector<Value> values;
  for (auto& [at, value] : found) values.push_back(std::move(value));
  return values;
}

std::vector<SceneText::Value> SceneText::values(const SceneTable& table) const {
  return Parsed(text_, file_).values_of(table);
}

std::vector<std::pair<SceneTable, std::vector<SceneText::Value>>> SceneText::all_values() const {
  const Parsed parsed(text_, file_);
  std::vector<std::pair<SceneTable, std::vector<Value>>> all;
  all.emplace_back(SceneTable{}, parsed.values_of({}));
  for (const SceneTable& table : names_) all.emplace_back(table, parsed.values_of(table));
  return all;
}

std::string SceneText::value(const SceneTable& table, const std::string& key) const {
  const Parsed parsed(text_, file_);
  const auto entry = parsed.entry(parsed.node_of(table), key);
  return entry ? text_.substr(entry->second.from, entry->second.to - entry->second.from) : "";
}

std::vector<std::string> SceneText::strings(const SceneTable& table, const std::string& key) const {
  const Parsed parsed(text_, file_);
  const auto value = parsed.node_of(table)[key];
  std::vector<std::string> strings;
  if (const auto one = value.value<std::string>()) strings.push_back(*one);
  if (const toml::array* list = value.as_array())
    for (const toml::node& item : *list)
      if (const auto element = item.value<std::string>()) strings.push_back(*element);
  return strings;
}

void SceneText::set(const SceneTable& table, const std::string& key, const std::string& value) {
  require_one(key, value, file_);
  const Parsed parsed(text_, file_);
  const std::string eol = parsed.end_of_line();
  const std::string line = key + " = " + value;
  if (!parsed.find(table) && table.name.empty() && !table.kind.empty()) {
    const std::string gap = text_.ends_with('\n') ? eol : eol + eol;
    return splice(text_.size(), text_.size(), gap + "[" + table.kind + "]" + eol + line + eol);
  }
  const toml::table& node = parsed.node_of(table);
  if (const auto entry = parsed.entry(node, key))
    return splice(entry->second.from, entry->second.to, value);
  if (table == SceneTable{}) {
    const size_t last = parsed.own_end(node, 0);
    const size_t at = last == 0 ? parsed.lines.front() : parsed.line_end(last);
    return splice(at, at, (at > 0 && text_[at - 1] != '\n' ? eol : "") + line + eol);
  }
  const Parsed::Table& found = *parsed.find(table);
  const size_t last = parsed.own_end(node, node.is_inline() ? found.span.from : found.span.to);
  if (node.is_inline()) {
    const size_t brace = found.span.to - 1;
    if (node.empty()) return splice(brace, brace, " " + line + " ");
    return splice(last, last, ", " + line);
  }
  if (!found.header)
    throw InputError("found '" + table.kind + "' in keys with dots, expected a table [" +
                     table.kind + "] to add '" + key + "' to");
  const size_t at = parsed.line_end(last);
  splice(at, at, (text_[at - 1] != '\n' ? eol : "") + line + eol);
}

void SceneText::set_item(const SceneTable& table, const std::string& key, int item,
                         const std::string& value) {
  require_one(key, value, file_);
  const Parsed parsed(text_, file_);
  const toml::array* list = parsed.node_of(table)[key].as_array();
  if (!list || item < 0 || static_cast<size_t>(item) >= list->size())
    throw InputError("found no value " + std::to_string(item + 1) + " of '" + key +
                     "', expected a list that has it");
  const Span span = parsed.span_of(*list->get(static_cast<size_t>(item)));
  splice(span.from, span.to, value);
}

void SceneText::erase(const SceneTable& table, const std::string& key) {
  const Parsed parsed(text_, file_);
  const toml::table& node = parsed.node_of(table);
  const auto entry = parsed.entry(node, key);
  if (!entry) throw InputError("found no key '" + key + "', expected one that is there");
  size_t from = entry->first.from, to = entry->second.to;
  if (node.is_inline()) {
    const auto behind_blanks = [&](size_t at) {
      while (at < text_.size() && (text_[at] == ' ' || text_[at] == '\t')) ++at;
      return at;
    };
    const size_t comma = text_.find_last_not_of(" \t", from - 1);
    if (const size_t next = behind_blanks(to); text_[next] == ',')
      to = behind_blanks(next + 1);
    else if (text_[comma] == ',')  // last element
      from = comma;
    return splice(from, to, "");
  }
  splice(parsed.line_start(from), parsed.line_end(to), "");
}

SceneTable SceneText::add(const std::string& kind, const std::string& table) {
  const std::string inline_text = "t = " + table;
  const Parsed inner(inline_text, file_);
  const Parsed::Table* given = inner.tables.empty() ? nullptr : &inner.tables.front();
  if (inner.root.size() != 1 || inner.tables.size() != 1 || given->name.kind != "t" ||
      !given->node->is_inline())
    throw InputError("found '" + table.substr(0, 32) + "' for [[" + kind +
                     "]], expected a table in braces: { name = \"…\", … }");
  const Parsed parsed(text_, file_);
  const std::string eol = parsed.end_of_line();
  std::vector<std::pair<size_t, std::string>> lines;
  for (const auto& [key, node] : *given->node) {
    const Span span = inner.span_of(node);
    lines.emplace_back(span.from, std::string(key.str()) + " = " +
                                      inline_text.substr(span.from, span.to - span.from) + eol);
  }
  std::sort(lines.begin(), lines.end());
  const bool single = kind.starts_with('[') && kind.ends_with(']');
  const SceneTable alone{single ? kind.substr(1, kind.size() - 2) : "", ""};
  if (single && has(alone)) throw InputError("found " + kind + " already, expected one");
  std::string block = (single ? kind : "[[" + kind + "]]") + eol;
  for (const auto& [at, line] : lines) block += line;

  size_t at = text_.size();
  const std::string outer = kind.substr(0, std::min(kind.size(), kind.rfind('.')));
  for (const Parsed::Table& other : parsed.tables)
    if ((other.name.kind == kind || other.name.kind == outer) && other.header)
      at = parsed.line_end(parsed.content_end(*other.node, other.span.to));
  const bool broken = at > 0 && text_[at - 1] != '\n';
  splice(at, at, (broken ? eol + eol : eol) + block);
  SceneTable added = alone;
  for (const SceneTable& name : names_)
    if (name.kind == kind) added = name;
  return added;
}

void SceneText::remove(const SceneTable& table) {
  const Parsed parsed(text_, file_);
  const toml::table& node = parsed.node_of(table);
  const Parsed::Table* found = parsed.find(table);
  if (!found || !found->header)
    throw InputError("found '" + table.kind + "' in braces, expected [[" + table.kind +
                     "]] to remove");
  size_t from = parsed.line_start(found->span.from);
  while (from > parsed.lines.front() && text_[parsed.line_start(from - 1)] == '#')
    from = parsed.line_start(from - 1);
  size_t to = parsed.line_end(parsed.content_end(node, found->span.to));
  while (to < text_.size() && text_.find_first_not_of(" \t\r", to) != std::string::npos &&
         text_[text_.find_first_not_of(" \t\r", to)] == '\n')
    to = parsed.line_end(to);
  if (to == text_.size())  // last table: no blank lines at the end
    while (from > 0 && parsed.line_start(from - 1) == from - 1) --from;
  splice(from, to, "");
}

void SceneText::set_rotation(const SceneTable& handle, const std::string& number, double value) {
  const std::string rotate = this->value(handle, "rotate");
  const toml::table stated = parse_toml("rotate = " + (rotate.empty() ? "{}" : rotate), file_, "");
  Vec3 axis = Vec3::UnitZ();
  for (int i = 0; i < 3; ++i)
    axis[i] = stated["rotate"]["axis"][static_cast<size_t>(i)].value_or(axis[i]);
  double degrees = stated["rotate"]["angle"].value_or(0.0);
  axis.normalize();
  if (number == "angle")
    degrees = value;
  else
    set_rotation_component(number.back() - 'x', value, axis, degrees);
  if (rotate.empty() && degrees == 0) return;
  set(handle, "rotate",
      "{ axis = [" + toml_value(axis.x()) + ", " + toml_value(axis.y()) + ", " +
          toml_value(axis.z()) + "], angle = " + toml_value(degrees) + " }");
}

// A handle's motion is stored in a list and an inline table; both may be missing.
bool SceneText::set_of_handle(const std::string& handle, const std::string& number, double value) {
  for (const SceneTable& name : names_) {
    const SceneTable table = name;                     // a copy: names_ changes with the text
    const bool unnamed = table.name.starts_with('#');  // an unnamed handle is called edit-1
    if (table.kind != "edit.handle" ||
        (unnamed ? "edit-" + table.name.substr(1) : table.name) != handle)
      continue;
    // Default values are not written.
    if (number == "scale") {
      if (value != 1 || !this->value(table, number).empty()) set(table, number, toml_value(value));
    } else if (number.size() == 1) {
      const bool stated = !this->value(table, "translate").empty();
      if (!stated && value == 0) return true;
      if (!stated) set(table, "translate", "[0, 0, 0]");
      set_item(table, "translate", number[0] - 'x', toml_value(value));
    } else {
      set_rotation(table, number, value);
    }
    return true;
  }
  return false;
}

void SceneText::set_parameter(const std::string& parameter, double value) {
  for (const SceneTable& table : names_)
    if (table.name == parameter && (table.kind == "load" || table.kind == "stiffness" ||
                                    table.kind == "offset" || table.kind == "parameter"))
      return set(table, "value", toml_value(value));
  const size_t dot = parameter.rfind('.');
  const size_t rotation = parameter.rfind(".rotation.");
  const size_t name_end = rotation == std::string::npos ? dot : rotation;
  if (dot != std::string::npos &&
      set_of_handle(parameter.substr(0, name_end), parameter.substr(name_end + 1), value))
    return;
  for (const SceneTable& table : names_) {
    if (dot == std::string::npos || table.name != parameter.substr(0, dot)) continue;
    const std::string last = parameter.substr(dot + 1);
    if (table.kind == "fair") return set(table, last, toml_value(value));
    if (table.kind == "constraint")
      return set_item(table, this->value(table, "to").empty() ? "direction" : "to", last[0] - 'x',
                      toml_value(value));
  }
  constexpr const char* three[] = {"_uu", "_uv", "_vv"};
  for (const std::string key : {"alpha", "beta"}) {
    if (parameter == key) return set({"skin", ""}, key, toml_value(value));
    for (int i = 0; i < 3; ++i)
      if (parameter == key + three[i]) return set_item({"skin", ""}, key, i, toml_value(value));
  }
  throw InputError("found no parameter '" + parameter + "' in the scene");
}

std::string SceneText::toml_value(double value) {
  if (!std::isfinite(value))
    throw InputError("found " + batten::format_number(value) + ", expected a finite number");
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  return std::string(digits, end);
}

std::string SceneText::toml_value(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (c == '\n')
      quoted += "\\n";
    else if (static_cast<unsigned char>(c) >= 32)
      quoted += c;
  }
  return quoted + "\"";
}

std::string SceneText::toml_value(const Vec3& p) {
  return list({toml_value(p.x()), toml_value(p.y()), toml_value(p.z())});
}

std::string SceneText::inline_table(const std::vector<Value>& values) {
  std::string table;
  for (const auto& [key, value] : values)
    table += (table.empty() ? " " : ", ") + key + " = " + value;
  return "{" + table + (table.empty() ? "}" : " }");
}

std::string SceneText::list(const std::vector<std::string>& values) {
  std::string list;
  for (const std::string& value : values) list += (list.empty() ? "" : ", ") + value;
  return "[" + list + "]";
}

std::string SceneText::toml_string_list(const std::vector<std::string>& texts) {
  std::vector<std::string> values;
  for (const std::string& text : texts) values.push_back(toml_value(text));
  return list(values);
}

namespace {

constexpr const char* kActing[] = {"load", "stiffness", "offset", "constraint", "parameter"};
/// Tables that use the shape without changing it.
constexpr const char* kMadeOf[] = {"motion", "picture", "sweep", "output",
                                   "stress", "compare", "name"};

void erase_number(toml::table& table, const char* key) {
  if (table.contains(key) && table.get(key)->is_number()) table.erase(key);
}

}  // namespace

SceneDependencies scene_dependencies(const SceneText& scene) {
  SceneDependencies parts;
  toml::table root = parse_toml(scene.text(), {}, "a scene");
  for (const char* kind : kActing) {
    int number = 0;
    if (toml::array* list = root[kind].as_array())
      for (toml::node& node : *list) {
        toml::table* table = node.as_table();
        if (!table) continue;
        ++number;
        const std::string name =
            (*table)["name"].value_or(std::string("#") + std::to_string(number));
        erase_number(*table, "value");
        table->erase("to");
        parts.session_parts[std::string(kind) + " " + name] = to_toml(*table);
      }
    root.erase(kind);
  }
  for (const char* kind : kMadeOf) root.erase(kind);
  if (toml::table* skin = root["skin"].as_table()) {
    for (const char* key : {"alpha", "beta"}) erase_number(*skin, key);
    if (const auto boundary = (*skin)["boundary"].value<std::string>())
      parts.session_parts["skin boundary"] = *boundary;  // affects the session only
  }
  parts.model = to_toml(root);
  for (const char* kind : {"skin", "mesh"}) root.erase(kind);
  parts.lines = to_toml(root);
  return parts;
}

}  // namespace batten
