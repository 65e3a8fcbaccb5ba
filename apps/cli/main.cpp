// SPDX-License-Identifier: MPL-2.0
// batten: the command-line program.
#include <csignal>
#include <iostream>

#include "batten/apps/cli/program.h"
#include "batten/core/memory.h"
#include "batten/core/parallel.h"
#include "batten/io/files/input_file.h"

namespace {

using namespace batten;

/// Parses the command line and runs the subcommand. Returns the exit code.
int command(int argc, char** argv) {
  CommonOptions common;
  Program program(common);
  const CommandLine::ParseResult parse = program.line.parse(argc, argv);
  if (parse != CommandLine::ParseResult::Command)
    return parse == CommandLine::ParseResult::HelpShown ? kDone : kBadInput;
  catch_interrupts(kCancelled);
  std::signal(SIGXFSZ, SIG_IGN);  // writers then report files that exceed the size limit
  enable_sandboxed_read(true);
  set_thread_count(common.threads);
  set_memory_limit(1e9 * common.memory);
  for (const Command& one : program.commands)
    if (one.subcommand.given()) return one.run();
  return kBadInput;  // not reached: a subcommand is required
}

}  // namespace

int main(int argc, char** argv) {
  int code = kBadInput;
  std::string message;
  try {
    code = command(argc, argv);
  } catch (const ConflictError& e) {
    code = kConflict;
    message = e.what();
  } catch (const NoSolutionError& e) {
    code = kNoSolution;
    message = e.what();
  } catch (const CancelledError& e) {
    code = kCancelled;
    message = e.what();
  } catch (const InputError& e) {
    message = e.what();
  } catch (const std::bad_alloc&) {
    code = kNoSolution;
    message = "not enough memory";
  } catch (const std::exception& e) {
    code = kNoSolution;
    message = std::string("unexpected error: ") + e.what();
  }
  // The error may only be due to a file removed after the interrupt.
  if (interrupted() && !message.empty()) {
    code = kCancelled;
    message = CancelledError().what();
  }
  end_progress();
  if (!message.empty()) std::cerr << "batten: " << message << "\n";
  return code;
}
