// SPDX-License-Identifier: MPL-2.0
// The subcommands of the `batten` program and their common options.
#pragma once

#include <functional>
#include <string>

#include "batten/apps/cli/command_line.h"
#include "batten/io/report/run_report.h"

namespace batten {

/// Options that all long-running subcommands have in common.
struct CommonOptions {
  int threads = 0;
  double memory = 0;
  bool quiet = false;
  bool in_place = false;  ///< output files may replace input files
};

/// A subcommand, and the function that runs it after the command line was parsed. `run` returns the
/// exit code.
struct Command {
  Subcommand subcommand;
  std::function<int()> run;
};

/// Each of these adds one subcommand to the program. `common` must outlive the returned Command.
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
Command add_fill(CommandLine& program, CommonOptions& common);
Command add_blend(CommandLine& program, CommonOptions& common);
Command add_info(CommandLine& program);
Command add_view(CommandLine& program, CommonOptions& common);

/// Adds the options of CommonOptions to a subcommand.
void add_common(Subcommand& subcommand, CommonOptions& common);
/// Adds the option --unit (length unit), with this description.
void add_unit(const Subcommand& subcommand, std::string& unit, const std::string& text);

/// Options of STEP export: curves of the input lines in the file; schema AP242 instead of AP214.
struct StepFileArguments {
  bool lines = false, ap242 = false;
};
/// Adds the options of StepFileArguments.
void add_step_options(const Subcommand& subcommand, StepFileArguments& step);
/// Adds the option --schema (AP214 or AP242).
void add_schema(const Subcommand& subcommand, bool& ap242);

/// Prints the text of a result (unless quiet), its warnings and its failed checks. Returns
/// kCheckFailed if a check failed, otherwise kDone.
int print_result(const RunReport& report, const std::string& text, const CommonOptions& common);

}  // namespace batten
