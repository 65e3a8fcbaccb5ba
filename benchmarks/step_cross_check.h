// What a program that knows nothing of Batten or OpenCASCADE finds in a STEP file: step_witness.py, with
// points of the surfaces that the file should be.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "batten/io/step/step_report.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten::bench {

/// Points of surfaces, about `count` in all, evenly over triangles, inside of what the trim leaves.
std::vector<std::vector<Vec3>> points_of(const std::vector<const SkinnedRegion*>& regions,
                                         int count);

class StepCrossCheck {
 public:
  /// Writes points of the surfaces, and places along the joins with the angles between the surfaces, into
  /// the folder.
  StepCrossCheck(const std::vector<const SkinnedRegion*>& regions,
                 const std::vector<StepJoin>& joins, int count,
                 const std::filesystem::path& folder);

  struct Result {
    int faces = 0, joins = 0, above = 0;  ///< above: joins of more than 0.1 degrees
    long points = 0, positions = 0;
    double distance = 0;  ///< largest, of the points from their faces
    double degrees = 0;   ///< largest angle between faces at the places
    double beyond = 0;    ///< largest of that angle less the one between the surfaces
  };
  /// None where Python, NumPy or SciPy are missing.
  std::optional<Result> seen(const std::filesystem::path& file) const;

 private:
  std::filesystem::path points_, joins_, results_file_;
};

}  // namespace batten::bench
