// Does the work of `batten run-script`.
#pragma once

#include <filesystem>
#include <string>

#include "batten/core/progress.h"
#include "batten/io/report/run_report.h"

namespace batten {

struct ScriptReport : RunReport {
  int commands = 0;
  std::string shape;  ///< what the document is in the end, rows of a summary
};

/// Does the commands of a script (document_command.h) on a document, one after the other. A shape
/// that has no solution goes back to the last one that had, as in the window where the script was
/// recorded, and is told in `warnings`; anything else that is refused ends the script. Misses of
/// `run` and `export` are in `failed_checks`. Throws InputError, ConflictError, NoSolutionError that begin
/// with the script's line, CancelledError.
ScriptReport run_script(const std::filesystem::path& script, const Progress& progress = {});

}  // namespace batten
