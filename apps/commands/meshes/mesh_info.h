// Describes a mesh file in a few lines of text.
#pragma once

#include <filesystem>
#include <string>

#include "batten/mesh/features/feature_detection.h"

namespace batten {

/// Describes a mesh file: counts, defects, the box around it, sets and properties, parts and what
/// hangs on them, boundary loops and proposed features. `unit` is that of its lengths. Throws
/// InputError.
std::string mesh_info(const std::filesystem::path& path, const std::string& unit,
                      const FeatureDetectionOptions& proposals = {});

}  // namespace batten
