// The work of `batten run` for a scene with [network].
#pragma once

#include <filesystem>
#include <string>

#include "batten/io/report.h"

namespace batten {

/// As run_scene, of a whole network: one model, its files and report.json.
Report run_network(const Scene& scene, const std::filesystem::path& folder,
                   const Progress& progress = {});

/// As view_scene.
void view_network(const Scene& scene, const PictureScene& look, const std::filesystem::path& file,
                  const Progress& progress = {});

/// What was found, repaired, skinned, left over, and what to say in the scene to have it otherwise.
std::string network_summary(const Report& report, const std::filesystem::path& folder);

}  // namespace batten
