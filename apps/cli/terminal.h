// The program's side of the terminal: progress, and the wish to stop.
#pragma once

#include "batten/core/progress.h"

namespace batten {

/// From now on Ctrl-C (and SIGTERM, SIGHUP) ask the work to stop instead of ending the program at
/// once; the second one does that, for libraries that cannot be stopped, and may leave a hidden
/// folder behind.
void catch_interrupts();

/// Draws a bar on the terminal's standard error once the work takes more than a second, and none
/// when standard error is not a terminal or `quiet`. Asks for interrupts. The bar is wiped by
/// end_progress().
Progress terminal_progress(bool quiet);
void end_progress();

}  // namespace batten
