#include "batten/apps/cli/words.h"

#include <CLI/CLI.hpp>
#include <cmath>

namespace batten {
namespace {

// CLI::PositiveNumber, in words and without infinity.
const CLI::Validator kPositive(
    [](std::string& text) {
      double value = 0;
      return CLI::detail::lexical_cast(text, value) && value > 0 && std::isfinite(value)
                 ? std::string()
                 : "found " + text + ", expected a number above 0";
    },
    "POSITIVE");

}  // namespace

Word Word::required() const { return Word(option_->required()); }

Word Word::hidden() const {
  option_->group("");
  return *this;
}
Word Word::repeated() const { return Word(option_->take_all()->allow_extra_args(false)); }

Word Word::count(int values) const { return Word(option_->expected(values)); }

Word Word::with_default() const { return Word(option_->capture_default_str()); }

Word Word::needs(Word other) const { return Word(option_->needs(other.option_)); }

Word Word::excludes(Word other) const { return Word(option_->excludes(other.option_)); }

Word Word::positive() const { return Word(option_->check(kPositive)); }

Word Word::within(int least, int most) const {
  return Word(option_->check(CLI::Range(least, most)));
}

Word Word::within(double least, double most) const {
  return Word(option_->check(CLI::Range(least, most)));
}

Word Word::one_of(const std::vector<std::string>& values) const {
  return Word(option_->check(CLI::IsMember(values)));
}

Word Word::also(const std::string& other, const std::string& value) const {
  return Word(option_->transform(CLI::Transformer({{other, value}})));
}

Word Words::option(const char* name, std::string& value, const std::string& what) const {
  return Word(app_->add_option(name, value, what));
}

Word Words::option(const char* name, std::filesystem::path& value, const std::string& what) const {
  return Word(app_->add_option(name, value, what));
}

Word Words::option(const char* name, double& value, const std::string& what) const {
  return Word(app_->add_option(name, value, what));
}

Word Words::option(const char* name, int& value, const std::string& what) const {
  return Word(app_->add_option(name, value, what));
}

Word Words::option(const char* name, std::vector<std::string>& values,
                   const std::string& what) const {
  return Word(app_->add_option(name, values, what));
}

Word Words::option(const char* name, std::vector<double>& values, const std::string& what) const {
  return Word(app_->add_option(name, values, what));
}

Word Words::flag(const char* name, bool& value, const std::string& what) const {
  return Word(app_->add_flag(name, value, what));
}

Word Words::form(const char* name, std::function<std::string(const std::string&)> take,
                 const std::string& what) const {
  const auto checked = [name, take](const std::string& text) {
    const std::string wrong = take(text);
    if (!wrong.empty()) throw CLI::ValidationError(name, wrong);
  };
  return Word(app_->add_option_function<std::string>(name, checked, what));
}

Word Words::choice(const char* name, const std::vector<std::string>& values,
                   std::function<void(const std::string&)> take, const std::string& what) const {
  return Word(app_->add_option_function<std::string>(name, std::move(take), what)
                  ->type_name("")
                  ->check(CLI::IsMember(values, CLI::ignore_case)));
}

Word Words::numbered_choice(const char* name, const std::map<std::string, int>& values,
                            std::function<void(int)> take, const std::string& what) const {
  return Word(app_->add_option_function<int>(name, std::move(take), what)
                  ->type_name("ENUM")
                  ->transform(CLI::CheckedTransformer(values, CLI::ignore_case)));
}

bool Words::given() const { return app_->parsed(); }

ProgramWords::ProgramWords(const char* name, const char* what, const char* version,
                           const char* footer)
    : app_(std::make_unique<CLI::App>(what, name)) {
  app_->footer(footer);
  app_->set_version_flag("--version", version);
  app_->require_subcommand(1);
}

ProgramWords::~ProgramWords() = default;

Words ProgramWords::command(const char* name, const char* what) {
  return Words(app_->add_subcommand(name, what));
}

ProgramWords::Read ProgramWords::read(int argc, char** argv) {
  try {
    app_->parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app_->exit(e) == 0 ? Read::Answer : Read::Wrong;
  }
  return Read::Command;
}

}  // namespace batten
