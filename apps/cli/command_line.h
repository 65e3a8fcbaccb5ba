// SPDX-License-Identifier: MPL-2.0
// Command-line parser: subcommands and options. A facade for CLI11, which only command_line.cpp
// includes, because its templates add ten seconds of compile time to every source that includes
// them.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace batten {

/// An option, flag or positional argument of a subcommand.
///
/// Each method adds a rule and returns the option, so that calls can be chained. If a value
/// violates a rule, parse() returns ParseResult::Invalid with a message that names the option.
class CommandOption {
 public:
  explicit CommandOption(CLI::Option* option) : option_(option) {}

  /// The option must be given.
  CommandOption required() const;
  /// The option may be given several times, each time with one value.
  CommandOption allow_repeated() const;
  /// The option takes exactly `values` values.
  CommandOption count(int values) const;
  /// Shows the default value in the help.
  CommandOption show_default() const;

  CommandOption needs(CommandOption other) const;  ///< only allowed together with the other option
  /// Not allowed together with the other option.
  CommandOption excludes(CommandOption other) const;
  CommandOption positive() const;  ///< the value must be finite and above 0
  /// The value must lie in [least, most].
  CommandOption in_range(int least, int most) const;
  CommandOption in_range(double least, double most) const;
  /// The value must be one of these texts.
  CommandOption one_of(const std::vector<std::string>& values) const;
  /// Accepts the text `other` as a synonym for `value`.
  CommandOption with_alias(const std::string& other, const std::string& value) const;

 private:
  CLI::Option* option_;
};

/// A subcommand and its options.
///
/// Names that begin with dashes are options; other names are positional arguments, in the order in
/// which they are added. The variables are set by CommandLine::parse() and must outlive it.
class Subcommand {
 public:
  explicit Subcommand(CLI::App* app) : app_(app) {}

  CommandOption option(const char* name, std::string& value, const std::string& description) const;
  CommandOption option(const char* name, std::filesystem::path& value,
                       const std::string& description) const;
  CommandOption option(const char* name, double& value, const std::string& description) const;
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
  /// Adds an option that takes one of several named numbers: the name (case-insensitive) or the
  /// number.
  CommandOption indexed_enum_option(const char* name, const std::map<std::string, int>& values,
                                    std::function<void(int)> parse_value,
                                    const std::string& description) const;

  /// True if the subcommand was given on the command line.
  bool given() const;

 private:
  CLI::App* app_;
};

/// The command line of a program with subcommands, exactly one of which must be given.
class CommandLine {
 public:
  CommandLine(const char* name, const char* description, const char* version, const char* footer);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  /// Adds a subcommand.
  Subcommand command(const char* name, const char* description);

  enum class ParseResult {
    Command,    ///< a subcommand was given: run it
    HelpShown,  ///< help or version was requested and printed
    Invalid     ///< invalid command line; the message was printed to standard error
  };
  /// Parses the command line and sets the variables of all options.
  ParseResult parse(int argc, char** argv);

 private:
  std::unique_ptr<CLI::App> app_;
};

}  // namespace batten
