// SPDX-License-Identifier: MPL-2.0
// Command-line parser: subcommands and options, and their --help. A facade for CLI11, which only
// command_line.cpp includes, because its templates add ten seconds of compile time to every source
// that includes them.
#pragma once

#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace batten {

/// What --help tells about an option, flag or positional argument.
struct OptionHelp {
  std::string group;  ///< heading under which it is listed
  std::string name;   ///< "--out"; of a positional argument "CURVES"
  std::string value;  ///< type of the value: "FOLDER", "ap214|ap242"; empty: a flag
  std::string text;
  std::string default_text = {};  ///< the default in words; empty: none
  bool required = false, repeated = false;

  bool is_positional() const { return !name.starts_with("-"); }
};

/// What --help tells about a subcommand.
struct CommandHelp {
  std::string name, group, summary;
  struct Example {
    std::string command, comment;
  };
  std::vector<Example> examples = {};
  std::deque<OptionHelp> options = {};
};

/// An option, flag or positional argument of a subcommand.
///
/// Each method adds a rule and returns the option, so that calls can be chained. If a value
/// violates a rule, parse() returns ParseResult::Invalid with a message that names the option.
class CommandOption {
 public:
  CommandOption(CLI::Option* option, OptionHelp* help) : option_(option), help_(help) {}

  /// The option must be given.
  CommandOption required() const;
  /// The option may be given several times, each time with one value.
  CommandOption allow_repeated() const;
  /// The option takes exactly `values` values.
  CommandOption count(int values) const;
  /// Shows the default in the help, in words: "1e-4 of the size".
  CommandOption default_text(const std::string& text) const;

  CommandOption needs(CommandOption other) const;  ///< only allowed together with the other option
  /// Not allowed together with the other option.
  CommandOption excludes(CommandOption other) const;
  CommandOption positive() const;  ///< the value must be finite and above 0
  CommandOption folder() const;    ///< the value must not be the name of a file ("part.step")
  /// The value must lie in [least, most].
  CommandOption in_range(int least, int most) const;
  CommandOption in_range(double least, double most) const;
  /// The value must be one of these texts.
  CommandOption one_of(const std::vector<std::string>& values) const;
  /// Accepts the text `other` as a synonym for `value`.
  CommandOption with_alias(const std::string& other, const std::string& value) const;

 private:
  CLI::Option* option_;
  OptionHelp* help_;
};

/// A subcommand and its options.
///
/// Names that begin with dashes are options; other names are positional arguments, in the order in
/// which they are added. The name of an option is followed by the type of its value, which --help
/// shows: "--out FOLDER". The variables are set by CommandLine::parse() and must outlive it.
class Subcommand {
 public:
  Subcommand(CLI::App* app, CommandHelp* help) : app_(app), help_(help) {}

  /// Sets the heading under which --help lists the options that are added next.
  void group(const std::string& heading) { group_ = heading; }
  /// Adds an example to the help: a command line, and what it does.
  void example(const std::string& command, const std::string& comment) const;

  CommandOption option(const char* name, std::string& value, const std::string& description) const;
  CommandOption option(const char* name, std::filesystem::path& value,
                       const std::string& description) const;
  CommandOption option(const char* name, double& value, const std::string& description) const;
  CommandOption option(const char* name, std::optional<double>& value,
                       const std::string& description) const;
  CommandOption option(const char* name, int& value, const std::string& description) const;
  CommandOption option(const char* name, std::vector<std::string>& values,
                       const std::string& description) const;
  CommandOption option(const char* name, std::vector<double>& values,
                       const std::string& description) const;
  /// Adds an option without a value; `value` becomes true if it is given.
  CommandOption flag(const char* name, bool& value, const std::string& description) const;
  /// Adds an option with a syntax of its own. `parse_value` returns an error message, or "" if the
  /// text is valid.
  CommandOption parsed_option(const char* name,
                              std::function<std::string(const std::string&)> parse_value,
                              const std::string& description) const;
  /// Adds an option that takes one of several texts, case-insensitive.
  CommandOption enum_option(const char* name, const std::vector<std::string>& values,
                            std::function<void(const std::string&)> parse_value,
                            const std::string& description) const;

  /// True if the subcommand was given on the command line.
  bool given() const;

 private:
  CommandOption added(CLI::Option* option, const char* name, const std::string& description) const;

  CLI::App* app_;
  CommandHelp* help_;
  std::string group_ = "Options";
};

/// The command line of a program with subcommands, exactly one of which must be given.
class CommandLine {
 public:
  /// `version`: printed by --version. `footer`: end of the help of the program.
  CommandLine(const char* name, const char* description, std::string version, const char* footer);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  /// Adds a subcommand. `group`: heading under which the help of the program lists it.
  Subcommand command(const char* name, const char* group, const char* summary);

  enum class ParseResult {
    Command,    ///< a subcommand was given: run it
    HelpShown,  ///< help or version was requested and printed
    Invalid     ///< invalid command line; the message was printed to standard error
  };
  /// Parses the command line and sets the variables of all options.
  ParseResult parse(int argc, char** argv);

  /// The help of the program, or of one of its subcommands; at most 80 columns wide.
  std::string help() const;
  std::string help(const std::string& command) const;
  const std::deque<CommandHelp>& commands() const { return commands_; }

 private:
  const CommandHelp* find(const std::string& command) const;
  std::string explain(int argc, char** argv, const std::string& reason) const;

  std::unique_ptr<CLI::App> app_;
  std::string name_, description_, version_, footer_;
  std::deque<CommandHelp> commands_;
};

}  // namespace batten
