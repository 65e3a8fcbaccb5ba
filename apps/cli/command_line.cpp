// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/cli/command_line.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>

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

}  // namespace

CommandOption CommandOption::required() const { return CommandOption(option_->required()); }

CommandOption CommandOption::allow_repeated() const {
  return CommandOption(option_->take_all()->allow_extra_args(false));
}

CommandOption CommandOption::count(int values) const {
  return CommandOption(option_->expected(values));
}

CommandOption CommandOption::show_default() const {
  return CommandOption(option_->capture_default_str());
}

CommandOption CommandOption::needs(CommandOption other) const {
  return CommandOption(option_->needs(other.option_));
}

CommandOption CommandOption::excludes(CommandOption other) const {
  return CommandOption(option_->excludes(other.option_));
}

CommandOption CommandOption::positive() const { return CommandOption(option_->check(kPositive)); }

CommandOption CommandOption::in_range(int least, int most) const {
  return CommandOption(option_->check(CLI::Range(least, most)));
}

CommandOption CommandOption::in_range(double least, double most) const {
  return CommandOption(option_->check(CLI::Range(least, most)));
}

CommandOption CommandOption::one_of(const std::vector<std::string>& values) const {
  return CommandOption(option_->check(CLI::IsMember(values)));
}

CommandOption CommandOption::with_alias(const std::string& other, const std::string& value) const {
  return CommandOption(option_->transform(CLI::Transformer({{other, value}})));
}

CommandOption Subcommand::option(const char* name, std::string& value,
                                 const std::string& description) const {
  return CommandOption(app_->add_option(name, value, description));
}

CommandOption Subcommand::option(const char* name, std::filesystem::path& value,
                                 const std::string& description) const {
  return CommandOption(app_->add_option(name, value, description));
}

CommandOption Subcommand::option(const char* name, double& value,
                                 const std::string& description) const {
  return CommandOption(app_->add_option(name, value, description));
}

CommandOption Subcommand::option(const char* name, int& value,
                                 const std::string& description) const {
  return CommandOption(app_->add_option(name, value, description));
}

CommandOption Subcommand::option(const char* name, std::vector<std::string>& values,
                                 const std::string& description) const {
  return CommandOption(app_->add_option(name, values, description));
}

CommandOption Subcommand::option(const char* name, std::vector<double>& values,
                                 const std::string& description) const {
  return CommandOption(app_->add_option(name, values, description));
}

CommandOption Subcommand::flag(const char* name, bool& value,
                               const std::string& description) const {
  return CommandOption(app_->add_flag(name, value, description));
}

CommandOption Subcommand::parsed_option(const char* name,
                                        std::function<std::string(const std::string&)> parse_value,
                                        const std::string& description) const {
  const auto checked = [name, parse_value](const std::string& text) {
    const std::string wrong = parse_value(text);
    if (!wrong.empty()) throw CLI::ValidationError(name, wrong);
  };
  return CommandOption(app_->add_option_function<std::string>(name, checked, description));
}

CommandOption Subcommand::enum_option(const char* name, const std::vector<std::string>& values,
                                      std::function<void(const std::string&)> parse_value,
                                      const std::string& description) const {
  return CommandOption(
      app_->add_option_function<std::string>(name, std::move(parse_value), description)
          ->type_name("")
          ->check(CLI::IsMember(values, CLI::ignore_case)));
}

CommandOption Subcommand::indexed_enum_option(const char* name,
                                              const std::map<std::string, int>& values,
                                              std::function<void(int)> parse_value,
                                              const std::string& description) const {
  return CommandOption(app_->add_option_function<int>(name, std::move(parse_value), description)
                           ->type_name("ENUM")
                           ->transform(CLI::CheckedTransformer(values, CLI::ignore_case)));
}

bool Subcommand::given() const { return app_->parsed(); }

CommandLine::CommandLine(const char* name, const char* description, const char* version,
                         const char* footer)
    : app_(std::make_unique<CLI::App>(description, name)) {
  app_->footer(footer);
  app_->set_version_flag("--version", version);
  app_->require_subcommand(1);
}

CommandLine::~CommandLine() = default;

Subcommand CommandLine::command(const char* name, const char* description) {
  return Subcommand(app_->add_subcommand(name, description));
}

CommandLine::ParseResult CommandLine::parse(int argc, char** argv) {
  try {
    app_->parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    const bool help = e.get_exit_code() == 0;
    if (const std::string message = renamed_option_message(argc, argv); !help && !message.empty()) {
      std::cerr << app_->get_name() << ": " << message << "\n";
      return ParseResult::Invalid;
    }
    return app_->exit(e) == 0 ? ParseResult::HelpShown : ParseResult::Invalid;
  }
  return ParseResult::Command;
}

}  // namespace batten
