// Implements `batten deform`: morphs a mesh and preserves its form features.
#pragma once

#include <filesystem>
#include <string>

#include "batten/core/progress.h"
#include "batten/io/report/deform_report.h"
#include "batten/io/scene/deform_scene.h"

namespace batten {

/// Performs the edits in order, measures the result and writes all files and report.json into the
/// folder, all or none. A result that violates checks is written, too; report.failed_checks lists
/// them. Throws InputError, ConflictError, NoSolutionError, CancelledError.
DeformReport run_deform(const DeformScene& scene, const std::filesystem::path& folder,
                        const Progress& progress = {});

/// A summary of the most important results in about a dozen lines, followed by the files.
std::string summary(const DeformReport& report, const std::filesystem::path& folder);

}  // namespace batten
