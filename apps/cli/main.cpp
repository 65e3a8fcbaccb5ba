// SPDX-License-Identifier: MPL-2.0
// batten: the command-line program.
#include "batten/apps/cli/process.h"
#include "batten/apps/cli/program.h"
#include "batten/core/memory.h"
#include "batten/core/parallel.h"
#include "batten/io/files/command_files.h"
#include "batten/io/files/input_file.h"
#include "batten/io/vtk/vtk_files.h"

/// Replaces a function of OpenBLAS, if that is the BLAS: no threads. Batten does not use them.
/// OpenBLAS starts them before main(), raises SIGINT if the system provides none, and waits for them
/// without end in fork() and exit() if memory is short.
extern "C" __attribute__((visibility("default"))) int openblas_num_threads_env() { return 1; }

namespace {

using namespace batten;

/// Parses the command line and runs the subcommand. Returns the exit code.
int command(int argc, char** argv) {
  prepare_process();
  CommonOptions common;
  Program program(common);
  const CommandLine::ParseResult parse = program.line.parse(argc, argv);
  if (parse != CommandLine::ParseResult::Command)
    return parse == CommandLine::ParseResult::HelpShown ? kDone : kBadInput;
  catch_interrupts();
  use_vtk_on_calling_thread();
  enable_sandboxed_read(true);
  const CommandFiles files(common.in_place ? CommandFiles::Inputs::Replaceable
                                           : CommandFiles::Inputs::Protected);
  set_thread_count(common.threads);
  set_memory_limit(1e9 * common.memory);
  for (const Command& one : program.commands)
    if (one.subcommand.given()) return one.run();
  return kBadInput;  // not reached: a subcommand is required
}

}  // namespace

int main(int argc, char** argv) {
  int code = kBadInput;
  try {
    code = command(argc, argv);
  } catch (...) {
    code = print_failure();
  }
  end_process(code);
}
