// Does the work of `batten fair`: fairs lines and writes them.
#pragma once

#include <filesystem>
#include <string>

#include "batten/core/progress.h"
#include "batten/io/report/report.h"
#include "batten/io/scene/fair_scene.h"

namespace batten {

/// Fairs the lines of a scene and writes all files and report.json into the folder, all of them or
/// none. report.missed has pictures that cannot be drawn and conditions that do not hold;
/// report.warnings has lines that cannot be faired, which are written as given. Throws InputError,
/// ConflictError, CancelledError.
FairReport run_fair(const FairScene& scene, const std::filesystem::path& folder,
                    const Progress& progress = {});

/// Paths of the files of one run; "" for none.
struct FairFiles {
  std::filesystem::path out, picture, report;
};
/// Does the same with each file at its own path; each appears whole or not at all. It does not use
/// `scene.outputs` and `scene.pictures`.
FairReport run_fair(const FairScene& scene, const FairFiles& files, const Progress& progress = {});

/// A table with one row for each line (the first twenty) and a total.
std::string summary(const FairReport& report);
/// The same table, with the time and the files at its end.
std::string summary(const FairReport& report, const std::filesystem::path& folder);

}  // namespace batten
