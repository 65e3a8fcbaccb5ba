// The words of the program's commands: each in a file of its own, what they share here.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "batten/io/report/report_parts.h"

namespace batten {

/// Exit codes, docs/conventions.md.
enum Exit {
  kDone = 0,
  kBadInput = 1,
  kConflict = 2,
  kNoSolution = 3,
  kMissed = 4,
  kCancelled = 130
};

/// What every long command takes.
struct CommonWords {
  int threads = 0;
  double memory = 0;
  bool quiet = false;
};

/// A command: its words, and what it does once they are read. It returns the exit code.
struct Command {
  CLI::App* words;
  std::function<int()> run;
};

/// Each adds one command to the program, or two that share their words. `common` must outlive it.
Command add_run(CLI::App& app, CommonWords& common);
Command add_stress(CLI::App& app, CommonWords& common);
Command add_sculpt(CLI::App& app, CommonWords& common);
Command add_deform(CLI::App& app, CommonWords& common);
Command add_sequence(CLI::App& app, CommonWords& common);
Command add_fair(CLI::App& app, CommonWords& common);
Command add_skin(CLI::App& app, CommonWords& common);
Command add_convert(CLI::App& app, CommonWords& common);
Command add_fit(CLI::App& app, CommonWords& common);
Command add_info(CLI::App& app);
Command add_view(CLI::App& app, CommonWords& common);

/// CLI::PositiveNumber, in words.
extern const CLI::Validator kPositive;

/// Adds the options of CommonWords.
void add_common(CLI::App* sub, CommonWords& common);
/// An option that may be there several times, each with one value.
CLI::Option* repeated(CLI::Option* option);
/// Adds the unit of lengths.
void add_unit(CLI::App* sub, std::string& unit);

/// Prints the text of a result, its warnings and the promises that it missed; returns the exit
/// code.
int finish(const RunReport& report, const std::string& text, const CommonWords& common);

}  // namespace batten
