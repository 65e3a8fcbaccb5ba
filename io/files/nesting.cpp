#include "batten/io/files/nesting.h"

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/io/files/toml_table.h"

namespace batten {
namespace {

// The place behind a text in quotes that begins at `at`, or the end of the text.
size_t behind_quotes(std::string_view text, size_t at) {
  const char quote = text[at];
  const std::string_view three = quote == '"' ? "\"\"\"" : "'''";
  const std::string_view closing = text.substr(at).starts_with(three) ? three : three.substr(0, 1);
  for (size_t i = at + closing.size(); i < text.size(); ++i) {
    if (quote == '"' && text[i] == '\\')
      ++i;
    else if (text.substr(i).starts_with(closing))
      return i + closing.size();
    else if (closing.size() == 1 && text[i] == '\n')
      return i;  // not closed: the parser will say so
  }
  return text.size();
}

[[noreturn]] void fail(std::string_view text, size_t at, const std::string& file,
                       const std::string& what) {
  const auto line = std::count(text.begin(), text.begin() + static_cast<long>(at), '\n');
  const size_t before = at == 0 ? text.npos : text.rfind('\n', at - 1);
  const size_t column = before == text.npos ? at + 1 : at - before;
  throw InputError(format_location(file, {static_cast<int>(line) + 1, static_cast<int>(column)}) +
                   "found " + what + " in each other, expected " +
                   std::to_string(kMaxNestingDepth) + " levels at most");
}

}  // namespace

void check_nesting_depth(std::string_view text, const std::string& file) {
  int depth = 0, dots = 0;
  for (size_t i = 0; i < text.size();) {
    switch (text[i]) {
      case '"':
      case '\'':
        i = behind_quotes(text, i);
        continue;
      case '#':
        i = std::min(text.find('\n', i), text.size());
        continue;
      case '[':
      case '{':
        ++depth;
        dots = 0;
        break;
      case ']':
      case '}':
        depth = std::max(0, depth - 1);
        break;
      case '.':
        ++dots;
        break;
      case '=':
      case ',':
      case '\n':
        dots = 0;
        break;
      default:
        break;
    }
    if (depth + dots > kMaxNestingDepth) fail(text, i, file, "lists, tables or parts of a key");
    ++i;
  }
}

void check_xml_nesting_depth(std::string_view text, const std::string& file) {
  int depth = 0;
  const auto behind = [&](std::string_view ending, size_t from) {
    const size_t found = text.find(ending, from);
    return found == text.npos ? text.size() : found + ending.size();
  };
  for (size_t i = text.find('<'); i < text.size(); i = text.find('<', i)) {
    const std::string_view rest = text.substr(i);
    if (rest.starts_with("<!--")) {
      i = behind("-->", i);
    } else if (rest.starts_with("<![CDATA[")) {
      i = behind("]]>", i);
    } else if (rest.starts_with("<?")) {
      i = behind("?>", i);
    } else if (rest.starts_with("<!")) {
      i = behind(">", i);
    } else {
      const size_t start = i;
      for (++i; i < text.size() && text[i] != '>'; ++i)
        if (text[i] == '"' || text[i] == '\'') i = std::min(text.find(text[i], i + 1), text.size());
      if (rest.starts_with("</"))
        --depth;
      else if (i < text.size() && text[i - 1] != '/' && ++depth > kMaxNestingDepth)
        fail(text, start, file, "elements");
    }
  }
}

}  // namespace batten
