// Does the work of `batten deform`: edits a mesh and keeps its form features.
#pragma once

#include <filesystem>
#include <string>

#include "batten/core/progress.h"
#include "batten/io/report/deform_report.h"
#include "batten/io/scene/deform_scene.h"

namespace batten {

/// Does the edits one after the other, measures the result and writes all files and report.json
/// into the folder, all of them or none. A result that misses a promise is written, too;
/// report.missed says so. Throws InputError, ConflictError, NoSolutionError, CancelledError.
DeformReport run_deform(const DeformScene& scene, const std::filesystem::path& folder,
                        const Progress& progress = {});

/// The most important results in about a dozen lines, with the files at the end.
std::string summary(const DeformReport& report, const std::filesystem::path& folder);

}  // namespace batten
