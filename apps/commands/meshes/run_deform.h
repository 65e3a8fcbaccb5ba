// The work of `batten deform`: edits of a mesh that keep its form features.
#pragma once

#include <filesystem>
#include <string>

#include "batten/core/progress.h"
#include "batten/io/report/deform_report.h"
#include "batten/io/scene/deform_scene.h"

namespace batten {

/// Does the edits one after the other, measures the result and writes all files and report.json
/// into the folder, all of them or none. A result that misses a promise is written too, and says so
/// in report.missed. Throws InputError, ConflictError, NoSolutionError, CancelledError.
DeformReport run_deform(const DeformScene& scene, const std::filesystem::path& folder,
                        const Progress& progress = {});

/// What a newcomer wants to know, a dozen lines, ending with the files.
std::string summary(const DeformReport& report, const std::filesystem::path& folder);

}  // namespace batten
