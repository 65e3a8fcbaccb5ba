// Reads a TOML table. The message about a mistake says its place and what to write instead:
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

/// A place in a text file, counted from 1. Line 0 stands for no place.
struct SourceLocation {
  int line = 0, column = 0;
};
/// The place as messages begin with it: "file:line:column: ", or "file: " for no place ("" when
/// there is no file either).
std::string format_location(const std::string& file, const SourceLocation& location);

/// The text "; did you mean 'x'?" when one of the words is near enough to `word`, else "".
std::string did_you_mean(const std::string& word, const std::vector<std::string>& words);
/// A part of a file as messages show it: in quotes, 32 characters at most, '?' for those that
/// cannot be printed.
std::string quoted_excerpt(std::string_view found);
/// The words as one text: "a, b, c".
std::string comma_separated(const std::vector<std::string>& words);
/// The text "one of: a, b, c; did you mean 'b'?" for a word that is none of them.
std::string expected_one_of(const std::string& word, const std::vector<std::string>& words);

/// One word of a file with its place, for checks that come later.
struct LocatedString {
  std::string text;
  SourceLocation location;
};

/// A TOML table and the keys that it may have. Its functions read the value of a key and throw
/// InputError with the place, what was found and what was expected: for a value of another kind,
/// and for a missing key without `fallback`.
class TomlTable {
 public:
  /// Keeps a reference to `table`. `what` names it in messages: "[skin]". Throws InputError when
  /// the table has a key that is not in `keys`.
  TomlTable(std::string file, const toml::table& table, std::string what,
            std::vector<std::string> keys);

  bool has(const std::string& key) const;
  /// The place of the table, or of a key (of the table when the key is missing).
  SourceLocation location() const;
  SourceLocation location(const std::string& key) const;
  const std::string& what() const { return what_; }

  /// A text that is not empty.
  std::string text(const std::string& key) const;
  std::string text(const std::string& key, const std::string& fallback) const;
  /// A finite number.
  double number(const std::string& key) const;
  double number(const std::string& key, double fallback) const;
  /// A finite number above 0.
  double positive(const std::string& key) const;
  double positive(const std::string& key, double fallback) const;
  bool boolean(const std::string& key, bool fallback) const;
  /// A whole number from `least` to a million.
  int integer(const std::string& key, int least, int fallback) const;
  /// A list of as many finite numbers as there are words in `shape` ("x, y, z").
  VecX numbers(const std::string& key, const std::string& shape) const;
  Vec3 vector(const std::string& key) const;
  /// A vector that is not zero, as a unit vector.
  Vec3 direction(const std::string& key) const;
  bool is_array(const std::string& key) const;
  std::vector<Vec3> points(const std::string& key) const;
  /// A list of lists of finite numbers, each as long as `shape` has words ("t, value").
  std::vector<VecX> rows(const std::string& key, const std::string& shape) const;
  std::vector<double> list(const std::string& key) const;
  std::vector<LocatedString> words(const std::string& key) const;
  /// A list of lists of names, each of one name or more.
  std::vector<std::vector<LocatedString>> string_lists(const std::string& key) const;
  /// One name or a list of them; none when the key is missing.
  std::vector<LocatedString> names(const std::string& key) const;

  /// The value that belongs to one of the given words.
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

  /// The tables inside this one, which may have `keys`: table() reads one, [key] or {…}; tables()
  /// reads a list of them, [[key]] or [{…}, {…}]. Empty when the key is missing.
  std::vector<TomlTable> table(const std::string& key, std::vector<std::string> keys) const;
  std::vector<TomlTable> tables(const std::string& key, std::vector<std::string> keys) const;

  /// Throws InputError "FILE:LINE:COLUMN: found …, expected …" with the place of the key.
  [[noreturn]] void fail(const std::string& key, const std::string& found,
                         const std::string& expected) const;
  /// The place of a key as "FILE:LINE:COLUMN: ", with which other messages begin.
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
