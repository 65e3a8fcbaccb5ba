// Reading a TOML table so that every mistake is answered with its place and a remedy:
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

/// A place in a text file, counted from 1; line 0: nowhere.
struct FilePlace {
  int line = 0, column = 0;
};
/// "file:line:column: ", or "" for nowhere.
std::string place_prefix(const std::string& file, const FilePlace& place);

/// "; did you mean 'x'?" when one of the words is near enough, else "".
std::string did_you_mean(const std::string& word, const std::vector<std::string>& words);
/// What a message shows of a file: in quotes, short, one line, printable.
std::string in_quotes(std::string_view found);
/// "a, b, c".
std::string listed(const std::vector<std::string>& words);
/// "one of: a, b, c; did you mean 'b'?"
std::string one_of(const std::string& word, const std::vector<std::string>& words);

/// One word of a file with its place, for checks that come later.
struct PlacedWord {
  std::string text;
  FilePlace place;
};

/// One table with the list of the keys it may have. All functions throw InputError with the place,
/// what was found and what was expected. A missing key without fallback is such a mistake.
class TomlTable {
 public:
  /// `what` names the table in messages: "[skin]". Throws when the table has any other key.
  TomlTable(std::string file, const toml::table& table, std::string what,
            std::vector<std::string> keys);

  bool has(const std::string& key) const;
  FilePlace place() const;
  FilePlace place(const std::string& key) const;
  const std::string& what() const { return what_; }

  std::string text(const std::string& key) const;
  std::string text(const std::string& key, const std::string& fallback) const;
  /// Finite.
  double number(const std::string& key) const;
  double number(const std::string& key, double fallback) const;
  double positive(const std::string& key) const;
  double positive(const std::string& key, double fallback) const;
  bool boolean(const std::string& key, bool fallback) const;
  /// At least `least`, at most a million.
  int whole_number(const std::string& key, int least, int fallback) const;
  /// As many finite numbers as there are words in `shape` ("x, y, z").
  VecX numbers(const std::string& key, const std::string& shape) const;
  Vec3 vector(const std::string& key) const;
  /// Not zero; made a unit vector.
  Vec3 direction(const std::string& key) const;
  bool is_array(const std::string& key) const;
  std::vector<Vec3> points(const std::string& key) const;
  /// A list of lists of finite numbers, each as long as `shape` has words ("t, value").
  std::vector<VecX> rows(const std::string& key, const std::string& shape) const;
  std::vector<double> list(const std::string& key) const;
  std::vector<PlacedWord> words(const std::string& key) const;
  /// A list of lists of names, each with one or more.
  std::vector<std::vector<PlacedWord>> word_rows(const std::string& key) const;
  /// One name or a list of them; none when the key is missing.
  std::vector<PlacedWord> names(const std::string& key) const;

  /// One of the given words.
  template <class Value>
  Value choice(const std::string& key,
               std::initializer_list<std::pair<const char*, Value>> choices) const {
    std::vector<std::string> names;
    for (const auto& c : choices) names.emplace_back(c.first);
    const std::string found = text(key);
    for (const auto& c : choices)
      if (found == c.first) return c.second;
    fail_word(key, found, names);
  }
  template <class Value>
  Value choice(const std::string& key, Value fallback,
               std::initializer_list<std::pair<const char*, Value>> choices) const {
    return has(key) ? choice(key, choices) : fallback;
  }

  /// Tables inside this one: [key], [[key]] or {…}, {…} in a list. None when the key is missing.
  std::vector<TomlTable> table(const std::string& key, std::vector<std::string> keys) const;
  std::vector<TomlTable> tables(const std::string& key, std::vector<std::string> keys) const;

  /// "FILE:LINE:COLUMN: found …, expected …" at a key of this table (at the table itself when the
  /// key is missing).
  [[noreturn]] void fail(const std::string& key, const std::string& found,
                         const std::string& expected) const;
  /// "FILE:LINE:COLUMN: " for messages of one's own.
  std::string at(const std::string& key) const { return place_prefix(file_, place(key)); }

 private:
  const toml::node& node(const std::string& key, const std::string& expected) const;
  [[noreturn]] void fail_node(const toml::node& node, const std::string& found,
                              const std::string& expected) const;
  [[noreturn]] void fail_word(const std::string& key, const std::string& found,
                              const std::vector<std::string>& names) const;
  double finite(const toml::node& node, const std::string& expected) const;

  std::string file_;
  const toml::table* table_;
  std::string what_;
};

}  // namespace batten
