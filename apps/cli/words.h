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
class Word {
 public:
  explicit Word(CLI::Option* option) : option_(option) {}

  Word required() const;
  /// It may be there several times, each with one value.
  Word repeated() const;
  /// So many values follow it.
  Word count(int values) const;
  /// The help says its default.
  Word with_default() const;
  Word hidden() const;              ///< the help does not list it
  Word needs(Word other) const;     ///< it makes sense beside the other one only
  Word excludes(Word other) const;  ///< the two contradict each other
  Word positive() const;            ///< a finite number above 0
  Word within(int least, int most) const;
  Word within(double least, double most) const;
  Word one_of(const std::vector<std::string>& values) const;
  /// It may be written in another way.
  Word also(const std::string& other, const std::string& value) const;

 private:
  CLI::Option* option_;
};

/// The words of one command. Names begin with dashes, or are those of arguments, which go by their order.
/// Variables must outlive it; they are set while the command line is read.
class Words {
 public:
  explicit Words(CLI::App* app) : app_(app) {}

  Word option(const char* name, std::string& value, const std::string& what) const;
  Word option(const char* name, std::filesystem::path& value, const std::string& what) const;
  Word option(const char* name, double& value, const std::string& what) const;
  Word option(const char* name, int& value, const std::string& what) const;
  Word option(const char* name, std::vector<std::string>& values, const std::string& what) const;
  Word option(const char* name, std::vector<double>& values, const std::string& what) const;
  Word flag(const char* name, bool& value, const std::string& what) const;
  /// A text of its own form; `take` returns what is wrong with it, "" if nothing is.
  Word form(const char* name, std::function<std::string(const std::string&)> take,
            const std::string& what) const;
  /// One of several texts, in any case.
  Word choice(const char* name, const std::vector<std::string>& values,
              std::function<void(const std::string&)> take, const std::string& what) const;
  /// One of several named numbers, by its name in any case or by itself.
  Word numbered_choice(const char* name, const std::map<std::string, int>& values,
                       std::function<void(int)> take, const std::string& what) const;

  /// Whether the command line has this command.
  bool given() const;

 private:
  CLI::App* app_;
};

/// The commands of a program, one of which must be given.
class ProgramWords {
 public:
  ProgramWords(const char* name, const char* what, const char* version, const char* footer);
  ~ProgramWords();
  ProgramWords(const ProgramWords&) = delete;
  ProgramWords& operator=(const ProgramWords&) = delete;

  Words command(const char* name, const char* what);

  enum class Read {
    Command,  ///< a command is to be run
    Answer,   ///< help or version was asked for, and printed
    Wrong     ///< something is wrong, and was said on standard error
  };
  Read read(int argc, char** argv);

 private:
  std::unique_ptr<CLI::App> app_;
};

}  // namespace batten
