// The program's terminal: it shows progress and takes the user's wish to stop.
#pragma once

#include "batten/core/progress.h"

namespace batten {

/// Makes the first Ctrl-C (or SIGTERM, SIGHUP) ask the work to stop. The second one ends the
/// program at once, because some libraries cannot be stopped; it may leave a hidden folder behind.
void catch_interrupts();

/// A progress that stops the work after an interrupt and draws a bar on standard error once the
/// work takes more than a second. It draws none when `quiet`, or when standard error is not a
/// terminal.
Progress terminal_progress(bool quiet);
/// Removes the bar.
void end_progress();

}  // namespace batten
