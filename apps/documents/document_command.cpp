// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/documents/document_command.h"

#include <algorithm>
#include <optional>
#include <sstream>

#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"
#include "batten/scenes/runs/run_support.h"

namespace batten {
namespace {

using CommandKind = DocumentCommand::CommandKind;

/// Arguments of a command, one letter each: k kind, n name, y key, v rest of the line, p parameter,
/// x number, u unit, f file, F optional file.
struct Form {
  CommandKind kind;
  const char* word;
  const char* words;
};
constexpr Form kForms[] = {{CommandKind::Open, "open", "f"},
                           {CommandKind::Recover, "recover", "f"},
                           {CommandKind::New, "new", "u"},
                           {CommandKind::Add, "add", "kv"},
                           {CommandKind::Set, "set", "knyv"},
                           {CommandKind::Erase, "erase", "kny"},
                           {CommandKind::Remove, "remove", "kn"},
                           {CommandKind::Move, "move", "v"},
                           {CommandKind::SetSlider, "slide", "px"},
                           {CommandKind::SolvePreview, "update", ""},
                           {CommandKind::SolveToEquilibrium, "solve", ""},
                           {CommandKind::Step, "step", "x"},
                           {CommandKind::Undo, "undo", ""},
                           {CommandKind::Redo, "redo", ""},
                           {CommandKind::Save, "save", "F"},
                           {CommandKind::Run, "run", "f"},
                           {CommandKind::Export, "export", "f"}};

const char* meaning(char word) {
  switch (word) {
    case 'k':
      return "a kind of table (such as load)";
    case 'n':
      return "a name, or - for none";
    case 'y':
      return "a key";
    case 'v':
      return "a value";
    case 'p':
      return "a parameter";
    case 'x':
      return "a number";
    case 'u':
      return "a unit of length";
    default:
      return "a file";
  }
}

/// A word of a script, quoted if necessary.
std::string quoted(const std::string& word) {
  const bool plain = !word.empty() && word != "-" && word.find_first_of(" \t\"#\\") == word.npos;
  return plain ? word : SceneText::toml_value(word);
}
std::string quoted_name(const std::string& name) { return name.empty() ? "-" : quoted(name); }

/// Extracts words from the front of a line.
class Line {
 public:
  Line(const std::string& text, std::string where) : text_(text), where_(std::move(where)) {}

  std::optional<std::string> next() {
    skip();
    if (at_ >= text_.size() || text_[at_] == '#') return std::nullopt;
    if (text_[at_] == '"') return in_quotes_word();
    const size_t end = std::min(text_.find_first_of(" \t", at_), text_.size());
    std::string word = text_.substr(at_, end - at_);
    at_ = end;
    return word;
  }
  std::string rest() {
    skip();
    std::string rest(trimmed(std::string_view(text_).substr(at_)));
    at_ = text_.size();
    return rest;
  }
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    throw InputError(where_ + "found " + found + ", expected " + expected);
  }

 private:
  void skip() {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
  }
  std::string in_quotes_word() {
    std::string word;
    for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_) {
      if (text_[at_] == '\\' && at_ + 1 < text_.size()) ++at_;
      word += text_[at_];
    }
    if (at_ >= text_.size()) fail("a quoted text without closing quote", "'\"' after it");
    ++at_;
    return word;
  }

  const std::string& text_;
  std::string where_;
  size_t at_ = 0;
};

void take(DocumentCommand& command, char kind, const std::string& word, const Line& line) {
  switch (kind) {
    case 'k':
      command.table.kind = word == "-" ? "" : word;
      break;
    case 'n':
      command.table.name = word == "-" ? "" : word;
      break;
    case 'y':
    case 'p':
    case 'u':
      command.key = word;
      break;
    case 'v':
      command.text = word;
      break;
    case 'x': {
      const std::optional<double> value = parse_number(word);
      if (!value) line.fail(quoted_excerpt(word), "a number");
      command.value = *value;
      break;
    }
    default:
      command.file = word;
  }
}

}  // namespace

std::string script_line(const DocumentCommand& command) {
  std::string line;
  for (const Form& form : kForms) {
    if (form.kind != command.kind) continue;
    line = form.word;
    for (const char* word = form.words; *word; ++word) {
      if (*word == 'F' && command.file.empty()) break;
      line += ' ';
      switch (*word) {
        case 'k':
          line += quoted_name(command.table.kind);
          break;
        case 'n':
          line += quoted_name(command.table.name);
          break;
        case 'y':
        case 'p':
        case 'u':
          line += quoted(command.key);
          break;
        case 'v':
          line += command.text;
          break;
        case 'x':
          line += SceneText::toml_value(command.value);
          break;
        default:
          line += quoted(command.file.string());
      }
    }
  }
  std::replace(line.begin(), line.end(), '\n', ' ');
  return line;
}

DocumentCommand parse_command(const std::string& text, const std::string& where) {
  Line line(text, where);
  const std::optional<std::string> kind = line.next();
  std::vector<std::string> verbs;
  for (const Form& form : kForms) verbs.emplace_back(form.word);
  if (!kind) line.fail("nothing", expected_one_of("", verbs));
  for (const Form& form : kForms) {
    if (*kind != form.word) continue;
    DocumentCommand command;
    command.kind = form.kind;
    for (const char* word = form.words; *word; ++word) {
      const std::optional<std::string> found = *word == 'v' ? line.rest() : line.next();
      if (found && !found->empty())
        take(command, *word, *found, line);
      else if (*word != 'F')
        line.fail("'" + *kind + "' without " + meaning(*word), meaning(*word));
    }
    if (const auto more = line.next())
      line.fail(quoted_excerpt(*more) + " after '" + *kind + "'", "the end of the line");
    return command;
  }
  if (*kind == "settle") line.fail("the old command 'settle'", "'solve'");
  if (*kind == "answer") line.fail("the old command 'answer'", "'update'");
  line.fail("the command " + quoted_excerpt(*kind), expected_one_of(*kind, verbs));
}

std::vector<LocatedCommand> read_script(const std::filesystem::path& file) {
  std::istringstream lines(read_input_file(file, "a script"));
  std::vector<LocatedCommand> commands;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    const std::string_view words = trimmed(line);
    if (words.empty() || words.front() == '#') continue;
    const std::string where = format_location(file.string(), {number, 1});
    commands.push_back({parse_command(line, where), where});
    DocumentCommand& command = commands.back().command;
    if (!command.file.empty() && command.file.is_relative())
      command.file = file.parent_path() / command.file;
  }
  return commands;
}

}  // namespace batten
