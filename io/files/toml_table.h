// Typed access to TOML tables. Error messages contain the location and the permitted values:
//
//     scene.toml:7:1: found key 'edge_lenght' in [skin], expected one of: …; did you mean
//     'edge_length'?
#pragma once

#include <initializer_list>
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

/// A string read from a file, with its location, so that later checks can report the location.
struct LocatedString {
  std::string text;
  SourceLocation location;
};

/// A TOML table with a fixed set of permitted keys. The member functions read the value of a key.
/// They throw InputError, with the location, the value found and the value expected, if the value
/// has the wrong type. They also throw InputError if the key is missing and the function has no
/// parameter `fallback`.
class TomlTable {
 public:
  /// Keeps a reference to `table`. `what`: name of the table in messages, such as "[skin]". Throws
  /// InputError if the table contains a key that is not in `keys`.
  TomlTable(std::string file, const toml::table& table, std::string what,
            std::vector<std::string> keys);

  bool has(const std::string& key) const;
  /// The location of the table, or of one of its keys. For a missing key: the location of the
  /// table.
  SourceLocation location() const;
  SourceLocation location(const std::string& key) const;
  const std::string& what() const { return what_; }

  /// A non-empty string.
  std::string text(const std::string& key) const;
  std::string text(const std::string& key, const std::string& fallback) const;
  /// A finite number.
  double number(const std::string& key) const;
  double number(const std::string& key, double fallback) const;
  /// A finite number above 0.
  double positive(const std::string& key) const;
  double positive(const std::string& key, double fallback) const;
  bool boolean(const std::string& key, bool fallback) const;
  /// An integer from `least` to 1,000,000.
  int integer(const std::string& key, int least, int fallback) const;
  /// A list of finite numbers. `shape`: names of the numbers ("x, y, z"), which also determine how
  /// many there must be.
  VecX numbers(const std::string& key, const std::string& shape) const;
  Vec3 vector(const std::string& key) const;
  /// A non-zero vector, normalised.
  Vec3 direction(const std::string& key) const;
  bool is_array(const std::string& key) const;
  std::vector<Vec3> points(const std::string& key) const;
  /// A list of lists of finite numbers. `shape`: names of the numbers in each inner list ("t,
  /// value"), which also determine its length.
  std::vector<VecX> rows(const std::string& key, const std::string& shape) const;
  /// A non-empty list of finite numbers.
  std::vector<double> list(const std::string& key) const;
  /// A non-empty list of strings. The result is empty if the key is missing.
  std::vector<LocatedString> strings(const std::string& key) const;
  /// A non-empty list of non-empty lists of names.
  std::vector<std::vector<LocatedString>> string_lists(const std::string& key) const;
  /// A single name or a list of names. The result is empty if the key is missing.
  std::vector<LocatedString> names(const std::string& key) const;

  /// The value that `choices` associates with the string found. Throws InputError for any other
  /// string.
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

  /// Subtables with the permitted `keys`. table() reads a single table, [key] or {…}; the result
  /// has one element. tables() reads a list of tables, [[key]] or [{…}, {…}]. The result is empty
  /// if the key is missing.
  std::vector<TomlTable> table(const std::string& key, std::vector<std::string> keys) const;
  std::vector<TomlTable> tables(const std::string& key, std::vector<std::string> keys) const;

  /// Throws InputError "FILE:LINE:COLUMN: found …, expected …" with the location of the key.
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

}  // namespace batten
