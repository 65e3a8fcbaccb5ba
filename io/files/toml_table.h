// Typed access to TOML tables. Error messages state the position and what to write instead:
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

/// A 1-based position in a text file. Line 0: unknown position.
struct SourceLocation {
  int line = 0, column = 0;
};
/// The position as a prefix of messages: "file:line:column: ". If it is unknown: "file: ", or ""
/// without a file.
std::string format_location(const std::string& file, const SourceLocation& location);

/// The text "; did you mean 'x'?" if one of `words` is similar enough to `word`, else "".
std::string did_you_mean(const std::string& word, const std::vector<std::string>& words);
/// Part of a file, quoted for messages: at most 32 characters, with '?' for unprintable ones.
std::string quoted_excerpt(std::string_view found);
/// Joins words: "a, b, c".
std::string comma_separated(const std::vector<std::string>& words);
/// The text "one of: a, b, c; did you mean 'b'?" for an invalid word.
std::string expected_one_of(const std::string& word, const std::vector<std::string>& words);

/// A string of a file with its position, for later checks.
struct LocatedString {
  std::string text;
  SourceLocation location;
};

/// A TOML table with the keys that it may have. Its functions read the value of a key. They throw
/// InputError with the position, the value found and the value expected if the value has the wrong
/// type, or if a key without `fallback` is missing.
class TomlTable {
 public:
  /// Keeps a reference to `table`. `what`: name of the table in messages, "[skin]". Throws
  /// InputError if the table has a key that is not in `keys`.
  TomlTable(std::string file, const toml::table& table, std::string what,
            std::vector<std::string> keys);

  bool has(const std::string& key) const;
  /// The position of the table, or of a key; if the key is missing, that of the table.
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
  /// An integer from `least` to a million.
  int integer(const std::string& key, int least, int fallback) const;
  /// A list of finite numbers. `shape` lists their names and thereby their number: "x, y, z".
  VecX numbers(const std::string& key, const std::string& shape) const;
  Vec3 vector(const std::string& key) const;
  /// A non-zero vector, normalised.
  Vec3 direction(const std::string& key) const;
  bool is_array(const std::string& key) const;
  std::vector<Vec3> points(const std::string& key) const;
  /// A list of lists of finite numbers, each with as many entries as `shape` has names ("t,
  /// value").
  std::vector<VecX> rows(const std::string& key, const std::string& shape) const;
  /// A non-empty list of finite numbers.
  std::vector<double> list(const std::string& key) const;
  /// A non-empty list of strings; empty if the key is missing.
  std::vector<LocatedString> words(const std::string& key) const;
  /// A non-empty list of non-empty lists of names.
  std::vector<std::vector<LocatedString>> string_lists(const std::string& key) const;
  /// One name or a list of names; empty if the key is missing.
  std::vector<LocatedString> names(const std::string& key) const;

  /// The value associated with one of the given words. Throws InputError for another word.
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

  /// Subtables, which may have the given keys. table() reads a single one, [key] or {…}, and
  /// returns at most one; tables() reads a list of them, [[key]] or [{…}, {…}]. Empty if the key is
  /// missing.
  std::vector<TomlTable> table(const std::string& key, std::vector<std::string> keys) const;
  std::vector<TomlTable> tables(const std::string& key, std::vector<std::string> keys) const;

  /// Throws InputError "FILE:LINE:COLUMN: found …, expected …" with the position of the key.
  [[noreturn]] void fail(const std::string& key, const std::string& found,
                         const std::string& expected) const;
  /// The position of a key as a prefix of other messages: "FILE:LINE:COLUMN: ".
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
