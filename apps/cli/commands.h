// The words of the program's commands: each in a file of its own, what they share here.
#pragma once

#include <functional>
#include <string>

#include "batten/apps/cli/command_line.h"
#include "batten/io/report/run_report.h"
#include "batten/core/progress.h"

namespace batten {

/// Exit codes, docs/conventions.md.
enum ExitCode {
  kDone = 0,
  kBadInput = 1,
  kConflict = 2,
  kNoSolution = 3,
  kCheckFailed = 4,
  kCancelled = 130
};

/// What every long command takes.
struct CommonOptions {
  int threads = 0;
  double memory = 0;
  bool quiet = false;
};

/// A command: its words, and what it does once they are read. It returns the exit code.
struct Command {
  Subcommand subcommand;
  std::function<int()> run;
};

/// Each adds one command to the program, or two that share their words. `common` must outlive it.
Command add_run(CommandLine& program, CommonOptions& common);
Command add_stress(CommandLine& program, CommonOptions& common);
Command add_sculpt(CommandLine& program, CommonOptions& common);
Command add_run_script(CommandLine& program, CommonOptions& common);
Command add_deform(CommandLine& program, CommonOptions& common);
Command add_sequence(CommandLine& program, CommonOptions& common);
Command add_fair(CommandLine& program, CommonOptions& common);
Command add_skin(CommandLine& program, CommonOptions& common);
Command add_convert(CommandLine& program, CommonOptions& common);
Command add_fit(CommandLine& program, CommonOptions& common);
Command add_info(CommandLine& program);
Command add_view(CommandLine& program, CommonOptions& common);

/// Adds the options of CommonOptions.
void add_common(const Subcommand& subcommand, CommonOptions& common);
/// Adds the unit of lengths.
void add_unit(const Subcommand& subcommand, std::string& unit);

/// What the STEP file of a surface holds and says.
struct StepFileArguments {
  bool lines = false, ap242 = false;
};
/// Adds the options of StepFileArguments.
void add_step_options(const Subcommand& subcommand, StepFileArguments& step);
/// Adds the schema of STEP files.
void add_schema(const Subcommand& subcommand, bool& ap242);

/// Prints the text of a result, its warnings and the promises that it missed; returns the exit
/// code.
int print_result(const RunReport& report, const std::string& text, const CommonOptions& common);


// The program's terminal: it shows progress and takes the user's wish to stop.

/// Makes Ctrl-C, SIGTERM and SIGHUP ask the work to stop. Some libraries cannot be stopped: after a
/// third of a second, or at the second signal, a thread of its own removes what is unfinished and
/// ends the program with this exit code.
void catch_interrupts(int exit_code);
/// Whether one of these signals came.
bool interrupted();

/// A progress that stops the work after an interrupt and draws a bar on standard error once the
/// work takes more than a second. It draws none when `quiet`, or when standard error is not a
/// terminal.
Progress terminal_progress(bool quiet);
/// Removes the bar.
void end_progress();

}  // namespace batten
