// Implements `batten fair`: fairs curves and writes them.
#pragma once

#include <filesystem>
#include <string>

#include "batten/core/progress.h"
#include "batten/io/report/report.h"
#include "batten/io/scene/fair_scene.h"

namespace batten {

/// Fairs the lines of a scene and writes all files and report.json into the folder, all or none.
/// report.failed_checks lists pictures that cannot be drawn and violated conditions.
/// report.warnings lists lines that cannot be faired, which are written unchanged. Throws
/// InputError, ConflictError, CancelledError.
FairReport run_fair(const FairScene& scene, const std::filesystem::path& folder,
                    const Progress& progress = {});

/// Paths of the files of one run; empty: not written.
struct FairFiles {
  std::filesystem::path out, picture, report;
};
/// Like run_fair() above, with a separate path per file, each written atomically. `scene.outputs`
/// and `scene.pictures` are ignored.
FairReport run_fair(const FairScene& scene, const FairFiles& files, const Progress& progress = {});

/// A table with one row per line (the first twenty) and a total.
std::string summary(const FairReport& report);
/// The same table, followed by the time and the files.
std::string summary(const FairReport& report, const std::filesystem::path& folder);

}  // namespace batten
