// The work of `batten fair`: lines that fair themselves.
#pragma once

#include <filesystem>
#include <string>

#include "batten/core/progress.h"
#include "batten/io/report/fair_report.h"
#include "batten/io/scene/fair_scene.h"

namespace batten {

/// Fairs the lines of a scene and writes all files and report.json into the folder, all of them or
/// none. Pictures that cannot be drawn and conditions that do not hold are in report.missed; lines
/// that cannot be faired are named in report.warnings and written as they came. Throws InputError,
/// ConflictError, CancelledError.
FairReport run_fair(const FairScene& scene, const std::filesystem::path& folder,
                    const Progress& progress = {});

/// Files of one run, wherever they are to be; "" for none.
struct FairFiles {
  std::filesystem::path out, picture, report;
};
/// The same with each file at its own place, written whole; `scene.outputs` and `scene.pictures`
/// are not looked at.
FairReport run_fair(const FairScene& scene, const FairFiles& files, const Progress& progress = {});

/// A table, one row a line (of many the first twenty), with a total.
std::string summary(const FairReport& report);
std::string summary(const FairReport& report, const std::filesystem::path& folder);

}  // namespace batten
