// SPDX-License-Identifier: MPL-2.0
// Keyword and data lines of Abaqus and CalculiX input, including included files.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "batten/io/meshes/mesh_source_text.h"

namespace batten {

/// A keyword line. It continues on the next line if it ends with a comma.
struct Keyword {
  std::string name;
  std::map<std::string, std::string_view> parameters;
  std::string_view line;
  bool has(const std::string& key) const { return parameters.contains(key); }
  /// Value of a parameter; empty if it is missing or has no value.
  std::string_view value(const std::string& key) const {
    const auto found = parameters.find(key);
    return found == parameters.end() ? std::string_view() : found->second;
  }
};

/// The text without enclosing quotes.
std::string_view unquoted(std::string_view text);
/// The values between commas, without surrounding blanks and quotes.
std::vector<std::string_view> comma_values(std::string_view line);

/// A name, and what follows each of its dots: "instance.set" refers to a set of the only instance,
/// but names may contain dots, too.
std::vector<std::string_view> local_names(std::string_view name);

/// Reads keywords and their data lines. *INCLUDE is followed wherever it occurs.
class AbaqusLines {
 public:
  explicit AbaqusLines(MeshSourceText& file) : file_(file) {}

  /// The next keyword, skipping all lines before it; empty at the end of the input.
  std::optional<Keyword> next_keyword();
  /// Advances line() to the next data line of the current keyword; false if there is none.
  bool next_data();
  std::string_view line() const { return line_; }
  /// Continues with the file of INPUT=, if the keyword has that parameter.
  void follow_input(const Keyword& keyword);

 private:
  bool next(std::string_view& line);
  Keyword read_keyword();

  MeshSourceText& file_;
  std::string_view line_;
};

}  // namespace batten
