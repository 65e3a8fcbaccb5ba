// The program's terminal: it shows progress and takes the user's wish to stop.
#pragma once

#include "batten/core/progress.h"

namespace batten {

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
