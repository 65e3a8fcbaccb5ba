// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/cli/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <set>
#include <sstream>

#include "batten/core/errors.h"
#include "batten/io/files/text.h"

namespace batten {
namespace {

// Like CLI::PositiveNumber, but rejects infinity.
const CLI::Validator kPositive(
    [](std::string& text) {
      double value = 0;
      return CLI::detail::lexical_cast(text, value) && value > 0 && std::isfinite(value)
                 ? std::string()
                 : "found " + text + ", expected a number above 0";
    },
    "POSITIVE");

// A folder, and not the name of a file, which would become a folder of this name.
const CLI::Validator kFolder(
    [](std::string& text) {
      static const std::set<std::string> files{
          ".step", ".stp", ".iges", ".igs", ".brep", ".vtp", ".vtu", ".inp", ".bdf",  ".nas",
          ".k",    ".rad", ".obj",  ".stl", ".ply",  ".off", ".glb", ".3mf", ".png",  ".csv",
          ".dxf",  ".svg", ".msh",  ".unv", ".gif",  ".pvd", ".pc2", ".mdd", ".toml", ".json"};
      const std::filesystem::path path = text;
      std::error_code none;
      if (!files.contains(lower_extension(path)) || std::filesystem::is_directory(path, none))
        return std::string();
      return "found '" + text + "', expected a folder, such as '" +
             std::filesystem::path(path).replace_extension().string() +
             "': this command writes several files, whose names the scene or the input gives";
    },
    "FOLDER");

/// An option of an earlier version, and what replaces it.
struct RenamedOption {
  const char* subcommand;
  const char* old_name;
  const char* expected;
};
constexpr RenamedOption kRenamedOptions[] = {
    {"fair", "--hold-ends", "--fix-ends"},
    {"fair", "--minimum", "--minimize bending or --minimize variation"},
    {"info", "--choices", "--alternatives"},
    {"fit", "--lines", "--curves"},
    {"fit", "--tolerance", "--fit-tolerance"},
    {"fit", "--step-lines", "--step-curves"},
    {"skin", "--tolerance", "--fit-tolerance"},
    {"skin", "--step-lines", "--step-curves"},
    {"skin", "--network", "none: faces are always detected"},
    {"view", "--network", "none: faces are always detected"}};

/// A message that names the replacement if the command line contains a renamed option; else empty.
std::string renamed_option_message(int argc, char** argv) {
  for (int i = 2; i < argc; ++i) {
    const std::string argument(argv[i]);
    const std::string name = argument.substr(0, argument.find('='));
    for (const RenamedOption& renamed : kRenamedOptions)
      if (renamed.subcommand == std::string(argv[1]) && name == renamed.old_name)
        return "found the old option " + name + ", expected " + renamed.expected;
  }
  return "";
}

std::string joined(const std::vector<std::string>& words, const char* between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

}  // namespace

CommandOption CommandOption::required() const {
  help_->required = true;
  return {option_->required(), help_};
}

CommandOption CommandOption::allow_repeated() const {
  help_->repeated = true;
  return {option_->take_all()->allow_extra_args(false), help_};
}

CommandOption CommandOption::count(int values) const { return {option_->expected(values), help_}; }

CommandOption CommandOption::default_text(const std::string& text) const {
  help_->default_text = text;
  return *this;
}

CommandOption CommandOption::needs(CommandOption other) const {
  return {option_->needs(other.option_), help_};
}

CommandOption CommandOption::excludes(CommandOption other) const {
  return {option_->excludes(other.option_), help_};
}

CommandOption CommandOption::positive() const { return {option_->check(kPositive), help_}; }
CommandOption CommandOption::folder() const { return {option_->check(kFolder), help_}; }

CommandOption CommandOption::in_range(int least, int most) const {
  return {option_->check(CLI::Range(least, most)), help_};
}

CommandOption CommandOption::in_range(double least, double most) const {
  return {option_->check(CLI::Range(least, most)), help_};
}

CommandOption CommandOption::one_of(const std::vector<std::string>& values) const {
  help_->value = joined(values, "|");
  return {option_->check(CLI::IsMember(values)), help_};
}

CommandOption CommandOption::with_alias(const std::string& other, const std::string& value) const {
  return {option_->transform(CLI::Transformer({{other, value}})), help_};
}

// The name of an option for CLI11, without the type of its value.
namespace {
std::string bare(const char* name) {
  const std::string text = name;
  return text.substr(0, text.find(' '));
}
}  // namespace

CommandOption Subcommand::added(CLI::Option* option, const char* name,
                                const std::string& description) const {
  const std::string text = name;
  const size_t space = text.find(' ');
  OptionHelp help{group_, bare(name), space == text.npos ? "" : text.substr(space + 1),
                  description};
  if (help.is_positional()) {
    help.group = "Arguments";
    help.repeated = option->get_expected_max() > 1;
  }
  help_->options.push_back(std::move(help));
  return {option, &help_->options.back()};
}

void Subcommand::example(const std::string& command, const std::string& comment) const {
  help_->examples.push_back({command, comment});
}

CommandOption Subcommand::option(const char* name, std::string& value,
                                 const std::string& description) const {
  return added(app_->add_option(bare(name), value), name, description);
}

CommandOption Subcommand::option(const char* name, std::filesystem::path& value,
                                 const std::string& description) const {
  return added(app_->add_option(bare(name), value), name, description);
}

CommandOption Subcommand::option(const char* name, double& value,
                                 const std::string& description) const {
  return added(app_->add_option(bare(name), value), name, description);
}

CommandOption Subcommand::option(const char* name, std::optional<double>& value,
                                 const std::string& description) const {
  return added(app_->add_option(bare(name), value), name, description);
}

CommandOption Subcommand::option(const char* name, int& value,
                                 const std::string& description) const {
  return added(app_->add_option(bare(name), value), name, description);
}

CommandOption Subcommand::option(const char* name, std::vector<std::string>& values,
                                 const std::string& description) const {
  return added(app_->add_option(bare(name), values), name, description);
}

CommandOption Subcommand::option(const char* name, std::vector<double>& values,
                                 const std::string& description) const {
  return added(app_->add_option(bare(name), values), name, description);
}

CommandOption Subcommand::flag(const char* name, bool& value,
                               const std::string& description) const {
  return added(app_->add_flag(name, value), name, description);
}

CommandOption Subcommand::parsed_option(const char* name,
                                        std::function<std::string(const std::string&)> parse_value,
                                        const std::string& description) const {
  const auto checked = [name, parse_value](const std::string& text) {
    const std::string wrong = parse_value(text);
    if (!wrong.empty()) throw CLI::ValidationError(bare(name), wrong);
  };
  return added(app_->add_option_function<std::string>(bare(name), checked), name, description);
}

CommandOption Subcommand::enum_option(const char* name, const std::vector<std::string>& values,
                                      std::function<void(const std::string&)> parse_value,
                                      const std::string& description) const {
  const CommandOption option =
      added(app_->add_option_function<std::string>(name, std::move(parse_value))
                ->check(CLI::IsMember(values, CLI::ignore_case)),
            name, description);
  help_->options.back().value = joined(values, "|");
  return option;
}

bool Subcommand::given() const { return app_->parsed(); }

CommandLine::CommandLine(const char* name, const char* description, std::string version,
                         const char* footer)
    : app_(std::make_unique<CLI::App>(description, name)),
      name_(name),
      description_(description),
      version_(std::move(version)),
      footer_(footer) {
  app_->set_version_flag("--version", version_);
  app_->require_subcommand(1);
}

CommandLine::~CommandLine() = default;

Subcommand CommandLine::command(const char* name, const char* group, const char* summary) {
  commands_.push_back({name, group, summary});
  return {app_->add_subcommand(name, summary), &commands_.back()};
}

const CommandHelp* CommandLine::find(const std::string& command) const {
  for (const CommandHelp& one : commands_)
    if (one.name == command) return &one;
  return nullptr;
}

// Help.

namespace {

// Width of the help; columns of the descriptions of options and of commands.
constexpr size_t kColumns = 80, kOptionColumn = 26, kCommandColumn = 14;

/// Text broken into lines that fit between `column` and the last column; the first line continues one
/// of the width `used`.
std::string wrapped(const std::string& text, size_t column, size_t used) {
  std::string lines;
  size_t at = used;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (at > column && at + 1 + word.size() > kColumns) {
      lines += "\n";
      at = 0;
    }
    const size_t gap = at < column ? column - at : at > column ? 1 : 0;
    lines += std::string(gap, ' ') + word;
    at += gap + word.size();
  }
  return lines + "\n";
}

/// Two columns: a term, and its description.
std::string described(const std::string& term, const std::string& text, size_t column) {
  constexpr size_t separation = 2;
  const std::string left = "  " + term;
  if (left.size() + separation <= column) return left + wrapped(text, column, left.size());
  return left + "\n" + wrapped(text, column, 0);
}

/// A command line, continued on further lines before an option if it is wider than the help.
std::string continued(const std::string& command) {
  std::string lines = " ";
  size_t width = lines.size();
  for (size_t at = 0, next; at < command.size(); at = next) {
    next = std::min(command.find(" --", at + 1), command.size());
    const std::string part = (at == 0 ? " " : "") + command.substr(at, next - at);
    constexpr size_t continuation = 2, indent = 5;
    if (at > 0 && width + part.size() + continuation > kColumns) {
      lines += " \\\n" + std::string(indent, ' ');
      width = indent;
    }
    lines += part;
    width += part.size();
  }
  return lines + "\n";
}

std::string capitalized(std::string text) {
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

std::string term_of(const OptionHelp& option) {
  const std::string more = option.is_positional() && option.repeated ? "..." : "";
  return option.name + more + (option.value.empty() ? "" : " " + option.value);
}

std::string described(const OptionHelp& option) {
  std::string text = option.text;
  if (option.repeated && !option.is_positional()) text += "; may be repeated";
  if (option.required && !option.is_positional()) text += " (required)";
  if (!option.default_text.empty()) text += " (default: " + option.default_text + ")";
  return described(term_of(option), text, kOptionColumn);
}

/// Groups in the order of their first member.
template <class Members, class Group>
std::vector<std::string> groups_of(const Members& members, const Group& group) {
  std::vector<std::string> groups;
  for (const auto& one : members)
    if (std::find(groups.begin(), groups.end(), group(one)) == groups.end())
      groups.push_back(group(one));
  return groups;
}

}  // namespace

std::string CommandLine::help() const {
  std::string text = "Usage: " + name_ + " COMMAND [OPTION...]\n" + wrapped(description_, 0, 0);
  const auto group_of = [](const CommandHelp& one) { return one.group; };
  for (const std::string& group : groups_of(commands_, group_of)) {
    text += "\n" + group + ":\n";
    for (const CommandHelp& one : commands_)
      if (one.group == group) text += described(one.name, one.summary, kCommandColumn);
  }
  return text + "\nOptions:\n" +
         described("-h, --help", "show this help; after a COMMAND: its help", kCommandColumn) +
         described("--version", "show version, commit, libraries and licence", kCommandColumn) +
         footer_;
}

std::string CommandLine::help(const std::string& command) const {
  const CommandHelp& own = *find(command);
  std::string usage = "Usage: " + name_ + " " + own.name;
  for (const OptionHelp& option : own.options)
    if (option.required) usage += " " + term_of(option);
  std::string text =
      wrapped(usage + " [OPTION...]", 0, 0) + wrapped(capitalized(own.summary) + ".", 0, 0);
  const auto group_of = [](const OptionHelp& one) { return one.group; };
  for (const std::string& group : groups_of(own.options, group_of)) {
    text += "\n" + group + ":\n";
    for (const OptionHelp& option : own.options)
      if (option.group == group) text += described(option);
  }
  text += described("-h, --help", "show this help", kOptionColumn) + "\nExamples:\n";
  for (const CommandHelp::Example& example : own.examples)
    text += continued(example.command) + wrapped(example.comment, 6, 0);
  return text;
}

// Parsing.

/// What is wrong with a command line that CLI11 rejects because of `reason`.
std::string CommandLine::explain(int argc, char** argv, const std::string& reason) const {
  std::vector<std::string> words, names;
  for (int i = 1; i < argc; ++i) words.push_back(printable(argv[i]));
  for (const CommandHelp& one : commands_) names.push_back(one.name);
  if (words[0].starts_with("-"))
    return ": found " + words[0] + ", expected a command\nTry '" + name_ + " --help'.";
  const CommandHelp* command = find(words[0]);
  if (!command)
    return ": '" + words[0] + "' is not a command" + did_you_mean(words[0], names) + "\nTry '" +
           name_ + " --help'.";
  const std::string place = " " + command->name + ": ",
                    advice = "\nTry '" + name_ + " " + command->name + " --help'.";
  names = {"--help"};
  for (const OptionHelp& option : command->options) names.push_back(option.name);
  for (const std::string& word : words) {
    const std::string option = word.substr(0, word.find('='));
    if (option.starts_with("--") && std::find(names.begin(), names.end(), option) == names.end())
      return place + "there is no option " + option + did_you_mean(option, names) + advice;
  }
  return place + printable(reason) + advice;
}

CommandLine::ParseResult CommandLine::parse(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << help();
    return ParseResult::Invalid;
  }
  try {
    app_->parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    std::cout << (find(argv[1]) ? help(argv[1]) : help());
    return ParseResult::HelpShown;
  } catch (const CLI::CallForVersion&) {
    std::cout << version_ << "\n";
    return ParseResult::HelpShown;
  } catch (const CLI::ParseError& e) {
    const std::string renamed = renamed_option_message(argc, argv);
    std::cerr << name_ << (renamed.empty() ? explain(argc, argv, e.what()) : ": " + renamed)
              << "\n";
    return ParseResult::Invalid;
  }
  return ParseResult::Command;
}

}  // namespace batten
