// SPDX-License-Identifier: MPL-2.0
// Typed access to TOML tables. Error messages contain the location and the permitted values:
//
//     scene.toml:7:1: found key 'edge_lenght' in [skin], expected one of: …; did you mean
//     'edge_length'?
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/errors.h"

namespace toml {
inline namespace v3 {
class node;
class table;
}  // namespace v3
}  // namespace toml

namespace batten {

/// A location in a text file: 1-based line and column. Line 0 means that the location is unknown.
struct SourceLocation {
  int line = 0, column = 0;
};
/// The location as the prefix of a message: "FILE:LINE:COLUMN: ". For an unknown location the
/// prefix is "FILE: ", or "" if `file` is empty.
std::string format_location(const std::string& file, const SourceLocation& location);

/// An excerpt of a file, quoted for messages: at most 32 characters, with '?' in place of
/// unprintable characters.
std::string quoted_excerpt(std::string_view found);
/// Joins strings with commas: "a, b, c".
std::string comma_separated(const std::vector<std::string>& strings);
/// The text "one of: a, b, c; did you mean 'b'?" for messages. `found`: the invalid value.
/// `choices`: the permitted values, from which the most similar one is suggested.
std::string expected_one_of(const std::string& found, const std::vector<std::string>& choices);

/// A string read from a file, with its location in the file for messages of later checks.
struct LocatedString {
  std::string text;
  SourceLocation location;
};

/// A TOML table with a fixed set of permitted keys. The member functions read the value of a key.
/// They throw InputError, with the location, the value found and the value expected, if the value
/// has the wrong type. If the key is missing, they return `fallback`, or throw InputError if they
/// have no such parameter.
class TomlTable {
 public:
  /// Creates a view of `table`, which must outlive it. `file`, `what`: names of the file and of the
  /// table (such as "[skin]") in messages. `keys`: the permitted keys. Throws InputError if the
  /// table contains a key that is not in `keys`.
  TomlTable(std::string file, const toml::table& table, std::string what,
            std::vector<std::string> keys);

  bool has(const std::string& key) const;
  /// The location of the table; with `key`, that of the key, or of the table if the key is missing.
  SourceLocation location() const;
  SourceLocation location(const std::string& key) const;
  const std::string& what() const { return what_; }

  /// The value of a key that must be a non-empty string.
  std::string text(const std::string& key) const;
  std::string text(const std::string& key, const std::string& fallback) const;
  /// The value of a key that must be a finite number.
  double number(const std::string& key) const;
  double number(const std::string& key, double fallback) const;
  /// The value of a key that must be a finite number above 0.
  double positive(const std::string& key) const;
  double positive(const std::string& key, double fallback) const;
  bool boolean(const std::string& key, bool fallback) const;
  /// The value of a key that must be an integer from `least` to 1,000,000; default: `fallback`.
  int integer(const std::string& key, int least, int fallback) const;
  /// The value of a key that must be a list of finite numbers. `shape`: names of the numbers ("x,
  /// y, z"), which also determine the length of the list.
  VecX numbers(const std::string& key, const std::string& shape) const;
  Vec3 vector(const std::string& key) const;
  /// The value of a key that must be a non-zero vector; the result has length 1.
  Vec3 direction(const std::string& key) const;
  bool is_array(const std::string& key) const;
  bool is_text(const std::string& key) const;
  /// The values of a key that must be a list of numbers and texts in quotes, with at least one text,
  /// as texts; empty if the key is missing or a list without a text. `shape`: as of numbers().
  std::vector<std::string> mixed_texts(const std::string& key, const std::string& shape) const;
  std::vector<Vec3> points(const std::string& key) const;
  /// The value of a key that must be a list of lists of finite numbers. `shape`: names of the
  /// numbers in each inner list ("t, value"), which also determine the length of the inner lists.
  std::vector<VecX> rows(const std::string& key, const std::string& shape) const;
  /// The value of a key that must be a non-empty list of finite numbers.
  std::vector<double> list(const std::string& key) const;
  /// The value of a key that must be a non-empty list of strings; empty if the key is missing.
  std::vector<LocatedString> strings(const std::string& key) const;
  /// The value of a key that must be a non-empty list of non-empty lists of names.
  std::vector<std::vector<LocatedString>> string_lists(const std::string& key) const;
  /// The value of a key that must be a non-empty list of non-empty lists of integers from 0.
  std::vector<std::vector<int>> index_lists(const std::string& key) const;
  /// The value of a key that must be a name or a list of names; empty if the key is missing.
  std::vector<LocatedString> names(const std::string& key) const;

  /// The value that `choices` associates with the string under `key`. Throws InputError if this
  /// string is not one of the choices.
  template <class Value>
  Value choice(const std::string& key,
               std::initializer_list<std::pair<const char*, Value>> choices) const {
    std::vector<std::string> names;
    for (const auto& c : choices) names.emplace_back(c.first);
    const std::string found = text(key);
    for (const auto& c : choices)
      if (found == c.first) return c.second;
    fail_choice(key, found, names);
  }
  template <class Value>
  Value choice(const std::string& key, Value fallback,
               std::initializer_list<std::pair<const char*, Value>> choices) const {
    return has(key) ? choice(key, choices) : fallback;
  }

  /// The subtables under `key`, in which only `keys` are permitted. table() reads a single table,
  /// [key] or {…}; its result has one element. tables() reads a list of tables, [[key]] or [{…},
  /// {…}]. The result is empty if `key` is missing.
  std::vector<TomlTable> table(const std::string& key, std::vector<std::string> keys) const;
  std::vector<TomlTable> tables(const std::string& key, std::vector<std::string> keys) const;
  /// The items of a list of tables and names, such as ["left", {curve = "top"}].
  struct TableOrName;
  std::vector<TableOrName> tables_or_names(const std::string& key,
                                           const std::vector<std::string>& keys) const;

  /// Throws InputError "FILE:LINE:COLUMN: found …, expected …" with the location of `key`.
  [[noreturn]] void fail(const std::string& key, const std::string& found,
                         const std::string& expected) const;
  /// The location of a key as the prefix of a message: "FILE:LINE:COLUMN: ".
  std::string at(const std::string& key) const { return format_location(file_, location(key)); }

 private:
  const toml::node& node(const std::string& key, const std::string& expected) const;
  [[noreturn]] void fail_node(const toml::node& node, const std::string& found,
                              const std::string& expected) const;
  [[noreturn]] void fail_choice(const std::string& key, const std::string& found,
                                const std::vector<std::string>& names) const;
  double finite(const toml::node& node, const std::string& expected) const;

  std::string file_;
  const toml::table* table_;
  std::string what_;
};

/// An item of TomlTable::tables_or_names().
struct TomlTable::TableOrName {
  std::optional<TomlTable> table;  ///< nullopt: `name` is set
  LocatedString name;
};

}  // namespace batten
