// SPDX-License-Identifier: MPL-2.0
// Measurement of a STEP file independently of Batten and OpenCASCADE, by step_cross_check.py, with
// points of the expected surfaces.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "batten/io/step/step_report.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten::bench {

/// About `count` points of surfaces in total, evenly over triangles, inside the trim.
std::vector<std::vector<Vec3>> points_of(const std::vector<const SkinnedRegion*>& regions,
                                         int count);

class StepCrossCheck {
 public:
  /// Writes points of the surfaces, and points along shared edges with the angles between the
  /// surfaces, into the folder.
  StepCrossCheck(const std::vector<const SkinnedRegion*>& regions,
                 const std::vector<StepJoin>& joins, int count,
                 const std::filesystem::path& folder);

  struct Result {
    int faces = 0, joins = 0, above = 0;  ///< above: edges of more than 0.1 degrees
    long points = 0, positions = 0;
    double distance = 0;  ///< largest distance of a point from its face
    double degrees = 0;   ///< largest angle between faces at the points
    double beyond = 0;    ///< largest excess of that angle over the angle of the surfaces
  };
  /// None if Python, NumPy or SciPy is missing.
  std::optional<Result> seen(const std::filesystem::path& file) const;

 private:
  std::filesystem::path points_, joins_, results_file_;
};

}  // namespace batten::bench
