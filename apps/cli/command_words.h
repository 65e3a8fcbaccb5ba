// The words of the program's commands: each in a file of its own, what they share here.
#pragma once

#include <functional>
#include <string>

#include "batten/apps/cli/words.h"
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
  Words words;
  std::function<int()> run;
};

/// Each adds one command to the program, or two that share their words. `common` must outlive it.
Command add_run(ProgramWords& program, CommonWords& common);
Command add_stress(ProgramWords& program, CommonWords& common);
Command add_sculpt(ProgramWords& program, CommonWords& common);
Command add_run_script(ProgramWords& program, CommonWords& common);
Command add_deform(ProgramWords& program, CommonWords& common);
Command add_sequence(ProgramWords& program, CommonWords& common);
Command add_fair(ProgramWords& program, CommonWords& common);
Command add_skin(ProgramWords& program, CommonWords& common);
Command add_convert(ProgramWords& program, CommonWords& common);
Command add_fit(ProgramWords& program, CommonWords& common);
Command add_info(ProgramWords& program);
Command add_view(ProgramWords& program, CommonWords& common);

/// Adds the options of CommonWords.
void add_common(const Words& sub, CommonWords& common);
/// Adds the unit of lengths.
void add_unit(const Words& sub, std::string& unit);

/// What the STEP file of a surface holds and says.
struct StepWords {
  bool lines = false, ap242 = false;
};
/// Adds the options of StepWords.
void add_step_words(const Words& sub, StepWords& step);
/// Adds the schema of STEP files.
void add_schema(const Words& sub, bool& ap242);

/// Prints the text of a result, its warnings and the promises that it missed; returns the exit
/// code.
int finish(const RunReport& report, const std::string& text, const CommonWords& common);

}  // namespace batten
