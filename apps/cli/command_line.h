// What a command line may say. CLI11 reads it, in words.cpp only: its templates take ten seconds to compile
// in every source that sees them.
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

/// One option, flag or argument. What it is told returns it again, so that calls can be chained. A value
/// that breaks a rule ends the program with kBadInput and a message that names the option.
class CommandOption {
 public:
  explicit CommandOption(CLI::Option* option) : option_(option) {}

  CommandOption required() const;
  /// It may be there several times, each with one value.
  CommandOption allow_repeated() const;
  /// So many values follow it.
  CommandOption count(int values) const;
  /// The help says its default.
  CommandOption show_default() const;
  CommandOption hidden() const;                       ///< the help does not list it
  CommandOption needs(CommandOption other) const;     ///< it makes sense beside the other one only
  CommandOption excludes(CommandOption other) const;  ///< the two contradict each other
  CommandOption positive() const;                     ///< a finite number above 0
  CommandOption in_range(int least, int most) const;
  CommandOption in_range(double least, double most) const;
  CommandOption one_of(const std::vector<std::string>& values) const;
  /// It may be written in another way.
  CommandOption with_alias(const std::string& other, const std::string& value) const;

 private:
  CLI::Option* option_;
};

/// The words of one command. Names begin with dashes, or are those of arguments, which go by their order.
/// Variables must outlive it; they are set while the command line is read.
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
  CommandOption flag(const char* name, bool& value, const std::string& description) const;
  /// A text of its own form; `parse_value` returns what is wrong with it, "" if nothing is.
  CommandOption parsed_option(const char* name,
                              std::function<std::string(const std::string&)> parse_value,
                              const std::string& description) const;
  /// One of several texts, in any case.
  CommandOption enum_option(const char* name, const std::vector<std::string>& values,
                            std::function<void(const std::string&)> parse_value,
                            const std::string& description) const;
  /// One of several named numbers, by its name in any case or by itself.
  CommandOption indexed_enum_option(const char* name, const std::map<std::string, int>& values,
                                    std::function<void(int)> parse_value,
                                    const std::string& description) const;

  /// Whether the command line has this command.
  bool given() const;

 private:
  CLI::App* app_;
};

/// The commands of a program, one of which must be given.
class CommandLine {
 public:
  CommandLine(const char* name, const char* description, const char* version, const char* footer);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  Subcommand command(const char* name, const char* description);

  enum class ParseResult {
    Command,    ///< a command is to be run
    HelpShown,  ///< help or version was asked for, and printed
    Invalid     ///< something is wrong, and was said on standard error
  };
  ParseResult parse(int argc, char** argv);

 private:
  std::unique_ptr<CLI::App> app_;
};

}  // namespace batten
