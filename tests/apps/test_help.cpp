// SPDX-License-Identifier: MPL-2.0
// Help, completion and messages about wrong command lines.
#include "batten/tests/apps/cli_case.h"

#include <algorithm>
#include <regex>
#include <set>

#include "batten/apps/cli/program.h"

using namespace batten_test;
using namespace batten;

namespace {

const CommandHelp& command_named(const CommandLine& line, const std::string& name) {
  const auto found = std::find_if(line.commands().begin(), line.commands().end(),
                                  [&](const CommandHelp& one) { return one.name == name; });
  REQUIRE(found != line.commands().end());
  return *found;
}

std::set<std::string> words_in(const std::string& text, const std::string& pattern) {
  const std::regex word(pattern);
  std::set<std::string> found;
  for (std::sregex_iterator i(text.begin(), text.end(), word), end; i != end; ++i)
    found.insert((*i)[1]);
  return found;
}

/// Number of columns of the longest line; the text is ASCII.
size_t width_of(const std::string& text) {
  size_t width = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) width = std::max(width, line.size());
  return width;
}

bool is_ascii(const std::string& text) {
  return std::all_of(text.begin(), text.end(), [](unsigned char c) { return c < 128; });
}

/// What bash proposes for the last word of a command line.
std::set<std::string> completions(const CliCase& c, const std::string& command_line) {
  const std::string script = "cd '" + c.folder().string() +
                             "'; compopt() { :; }; source '" BATTEN_SOURCE_DIR
                             "/cmake/packages/batten.bash'; COMP_WORDS=(" +
                             command_line +
                             "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _batten '" BATTEN_CLI
                             "'; printf '%s\\n' \"${COMPREPLY[@]}\"";
  const fs::path out = c / "completions", file = c / "script";
  write(file, script);
  REQUIRE(std::system(("bash '" + file.string() + "' > '" + out.string() + "'").c_str()) == 0);
  return words_in(contents(out), "([^\\n]+)");
}

}  // namespace

TEST_CASE("help fits into 80 columns and shows type and default of every option", "[apps][help]") {
  CommonOptions common;
  const Program program(common);
  const std::string all = program.line.help();
  CHECK(width_of(all) <= 80);
  CHECK(is_ascii(all));
  for (const CommandHelp& command : program.line.commands()) {
    INFO(command.name);
    const std::string help = program.line.help(command.name);
    CHECK(width_of(help) <= 80);
    CHECK(is_ascii(help));
    CHECK(all.find("\n  " + command.name + "  ") != std::string::npos);
    CHECK(command.name.size() + 2 + command.summary.size() <= 80);
    for (const OptionHelp& option : command.options) {
      INFO(option.name);
      CHECK_FALSE(option.text.empty());
      CHECK(help.find("  " + option.name) != std::string::npos);
      if (!option.value.empty())
        CHECK((option.required || option.repeated || !option.default_text.empty()));
    }
  }
}

TEST_CASE("examples in the help are of their own command, and name files of examples",
          "[apps][help]") {
  CommonOptions common;
  const Program program(common);
  for (const CommandHelp& command : program.line.commands()) {
    INFO(command.name);
    CHECK(command.examples.size() >= 1);
    CHECK(command.examples.size() <= 4);
    const auto options = words_in(program.line.help(command.name), "\n  (--[a-z-]+)");
    for (const CommandHelp::Example& example : command.examples) {
      INFO(example.command);
      CHECK(example.command.starts_with("batten " + command.name + " "));
      for (const std::string& option : words_in(example.command, " (--[a-z-]+)"))
        CHECK(options.count(option) == 1);
      for (const std::string& file : words_in(example.command, "(examples/[^ ]+)"))
        CHECK(fs::exists(fs::path(BATTEN_SOURCE_DIR) / file));
    }
  }
}

TEST_CASE("examples in the help run in a copy of the examples", "[apps][help]") {
  const std::string name = GENERATE("skin", "fair", "convert", "info", "deform");
  CommonOptions common;
  const Program program(common);
  const CliCase c("help_" + name);
  fs::create_symlink(BATTEN_SOURCE_DIR "/examples", c / "examples");
  for (const CommandHelp::Example& example : command_named(program.line, name).examples) {
    if (example.command.find("examples/") == std::string::npos) continue;
    std::vector<std::string> words;
    std::istringstream text(example.command.substr(7));
    for (std::string word; text >> word;) words.push_back(word);
    const bool draws = example.command.find(".png") != std::string::npos;
    const CliResult r = c.run(words);
    INFO(example.command << "\n" << r.err);
    // Without an X server, pictures fail, and nothing else does.
    CHECK((draws || r.code == 0 || r.err.find("not drawn") != std::string::npos));
    if (draws) CHECK(r.err.find("no display") != std::string::npos);
  }
}

TEST_CASE("completion proposes commands, options, values and files", "[apps][help]") {
  CommonOptions common;
  const Program program(common);
  const CliCase c("completion");
  c.file("a.toml", "");
  fs::create_directories(c / "out");
  std::set<std::string> commands = {"--help", "--version"};
  for (const CommandHelp& command : program.line.commands()) commands.insert(command.name);
  CHECK(completions(c, "batten ''") == commands);
  for (const std::string name : {"skin", "fair", "run-script"}) {
    std::set<std::string> options = {"--help"};
    for (const OptionHelp& option : command_named(program.line, name).options)
      if (!option.is_positional()) options.insert(option.name);
    CHECK(completions(c, "batten " + name + " --") == options);
  }
  CHECK(completions(c, "batten skin --schema ''") == std::set<std::string>{"ap214", "ap242"});
  CHECK(completions(c, "batten skin --out ''") == std::set<std::string>{"out"});
  CHECK(completions(c, "batten run a") == std::set<std::string>{"a.toml"});
  CHECK(completions(c, "batten skin --threads ''").empty());
}

TEST_CASE("man pages list the options of the help", "[apps][help]") {
  if (std::system("command -v help2man > /dev/null") != 0) {
    WARN("skipped: help2man is not installed");
    return;
  }
  CommonOptions common;
  const Program program(common);
  const CliCase c("man");
  const std::string command = "help2man --no-info --version-string 1 --name x '" BATTEN_CLI
                              " fair' > '" +
                              (c / "page").string() + "'";
  REQUIRE(std::system(command.c_str()) == 0);
  const std::string page = contents(c / "page");
  for (const OptionHelp& option : command_named(program.line, "fair").options) {
    const std::string name = std::regex_replace(option.name, std::regex("-"), "\\-");
    INFO(name);
    CHECK((page.find("\\fB" + name + "\\fR") != std::string::npos) != option.is_positional());
  }
  CHECK(page.find(".SH EXAMPLES") != std::string::npos);
}

TEST_CASE("wrong words on the command line get a proposal", "[apps][help]") {
  const CliCase c("words");
  c.file("hood.toml", "");
  const auto says = [&](const std::vector<std::string>& words, const std::string& message) {
    const CliResult r = c.run(words);
    INFO(r.err);
    CHECK(r.code == 1);
    CHECK(r.out.empty());
    CHECK(r.err.find(message) != std::string::npos);
  };
  says({}, "Usage: batten COMMAND");
  says({"foo"}, "batten: 'foo' is not a command");
  says({"scuplt"}, "batten: 'scuplt' is not a command; did you mean 'sculpt'?");
  says({"skin", "a.csv", "--otu", "out"},
       "batten skin: there is no option --otu; did you mean '--out'?");
  says({"skin", "a.csv", "--zzzzzz", "out"}, "batten skin: there is no option --zzzzzz\n");
  says({"skin", "a.csv"}, "batten skin: --out is required");
  says({"run", "hodo.toml", "--out", "out"}, "; did you mean 'hood.toml'?");
}

TEST_CASE("the exit codes of the help are those of the documents", "[apps][help]") {
  const std::string document = contents(BATTEN_SOURCE_DIR "/docs/conventions.md");
  CommonOptions common;
  const std::string help = Program(common).line.help();
  const auto codes = words_in(help, "\n  ([0-9]+)  ");
  CHECK(codes == std::set<std::string>{"0", "1", "130", "2", "3", "4"});
  CHECK(words_in(document, "\n\\| [^|]+ \\| ([0-9]+) \\| ") == codes);
}

TEST_CASE("every command ends with exit code 1 for a missing file", "[apps][help]") {
  CommonOptions common;
  const Program program(common);
  const CliCase c("missing");
  for (const CommandHelp& command : program.line.commands()) {
    std::vector<std::string> words = {command.name};
    for (const OptionHelp& option : command.options) {
      if (option.is_positional()) words.push_back("missing.stp");
      if (option.required && !option.is_positional())
        words.insert(words.end(), {option.name, "x.png"});
    }
    if (command.name == "convert") words.back() = "out.stl";
    const CliResult r = c.run(words);
    INFO(command.name << ": " << r.err);
    CHECK(r.code == 1);
    CHECK(std::distance(fs::directory_iterator(c.folder()), fs::directory_iterator()) == 2);
  }
}

TEST_CASE("the version names commit, compiler, libraries and licence", "[apps][help]") {
  const CliCase c("version");
  const CliResult r = c.run({"--version"});
  CHECK(r.code == 0);
  CHECK(std::regex_search(r.out, std::regex("^batten [0-9]+\\.[0-9]+\\.[0-9]+\n")));
  for (const char* name : {"commit", "compiler", "Eigen", "CHOLMOD", "CGAL", "Ceres", "OpenCASCADE",
                           "VTK", "CAD module", "PETSc module", "licence"}) {
    INFO(name << " in\n" << r.out);
    CHECK(std::regex_search(r.out, std::regex("\n" + std::string(name) + " +[^ \n]")));
  }
}
