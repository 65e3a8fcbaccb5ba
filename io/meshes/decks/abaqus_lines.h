// Lines of Abaqus and CalculiX input, through included files. Internal.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "batten/io/meshes/mesh_source_text.h"

namespace batten {

/// A keyword line, which goes on in the next one after a comma.
struct Keyword {
  std::string name;
  std::map<std::string, std::string_view> parameters;
  std::string_view line;
  bool has(const std::string& key) const { return parameters.contains(key); }
  std::string_view value(const std::string& key) const {
    const auto found = parameters.find(key);
    return found == parameters.end() ? std::string_view() : found->second;
  }
};

std::string_view unquoted(std::string_view text);
/// Values between commas, without blanks and quotes around them.
std::vector<std::string_view> comma_values(std::string_view line);

/// Reads keywords and their lines of data. *INCLUDE is followed wherever it stands.
class AbaqusLines {
 public:
  explicit AbaqusLines(MeshSourceText& file) : file_(file) {}

  /// The next keyword; lines before it are passed over. Nothing at the end.
  std::optional<Keyword> next_keyword();
  /// The next line of data of this keyword, which line() then is.
  bool next_data();
  std::string_view line() const { return line_; }
  /// Goes on with the file that INPUT= names, if it does.
  void follow_input(const Keyword& keyword);

 private:
  bool next(std::string_view& line);
  Keyword read_keyword();

  MeshSourceText& file_;
  std::string_view line_;
};

}  // namespace batten
