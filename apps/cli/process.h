// SPDX-License-Identifier: MPL-2.0
// The process of the program: its standard streams, the limits of the system, interrupts, the
// progress bar, the exit codes, and its end.
#pragma once

#include <string>

#include "batten/core/progress.h"

namespace batten {

/// Exit codes of the program (docs/conventions.md).
enum ExitCode {
  /// Success: all checks passed.
  kDone = 0,
  /// Invalid input or command line, or output that cannot be written (InputError).
  kBadInput = 1,
  /// Contradictory constraints (ConflictError).
  kConflict = 2,
  /// Singular problem, load beyond its limit, or a limit of the system (NoSolutionError).
  kNoSolution = 3,
  /// Results were written, but a check failed.
  kCheckFailed = 4,
  /// Cancelled by the user (CancelledError).
  kCancelled = 130
};

/// Prepares the process; call it first. Opens closed standard streams, so that no other file gets
/// their numbers: reading from them and writing to them fails. Raises the limits of the stack and of
/// open files as far as permitted. Writing to closed pipes, and beyond the limit of file sizes, is
/// an error of the writer from now on. Throws NoSolutionError if a limit is too low for the program.
void prepare_process();

/// Ends the program from the outside in good order:
///
/// - Ctrl-C, SIGTERM and SIGHUP, unless the starting process ignores them (as nohup does), request
///   cancellation. Some libraries cannot be cancelled. Therefore, 0.3 s later or at the second
///   signal, a separate thread removes unfinished files and ends the program with kCancelled.
/// - Shortly before the limit of the processor time (`ulimit -t`), the thread does the same with a
///   message and kNoSolution.
/// - An exception in a destructor or in a thread of a library does not abort the program, but ends
///   it with the message of print_failure().
///
/// Throws std::system_error if the system does not provide a thread.
void catch_interrupts();
/// True if one of the signals has arrived.
bool interrupted();

/// Writes a text of several rows to the standard output, with printable() rows. end_process()
/// reports a failure.
void print(const std::string& text);

/// Prints the message of the exception that is being handled, and returns its exit code.
ExitCode print_failure() noexcept;

/// Ends the program: removes unfinished files, and writes buffered output. If that fails, a message
/// says why, and the exit code becomes kBadInput. Does not call the exit handlers of libraries,
/// which may wait without end if memory is short.
[[noreturn]] void end_process(int code);

/// Progress callbacks that cancel the work after an interrupt, and draw a bar on standard error if
/// the work takes more than a second. No bar is drawn if `quiet` is set or standard error is not a
/// terminal.
Progress terminal_progress(bool quiet);
/// Removes the progress bar.
void end_progress();

}  // namespace batten
