// SPDX-License-Identifier: MPL-2.0
// Curves of files and scenes that chains of a mesh follow.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Where a curve is.
struct DrivingCurveSource {
  std::filesystem::path file;  ///< curve file, CAD file or scene (.toml)
  std::string curve;           ///< its name; empty: the only one
  std::string own_unit;        ///< length unit of a curve file; empty: `unit`
  std::string unit;            ///< length unit of the result
};

/// Reads a curve, and samples it densely. A curve of a scene is faired as the scene states. Throws
/// InputError as the readers do, and unless the file has a curve of this name, or only one curve.
std::vector<Vec3> read_curve_samples(const DrivingCurveSource& source);

/// Points of a sampled curve that correspond to the points of a chain: at the same share of the
/// length. The direction of the curve, and of closed ones the start, are those with the smallest sum
/// of squared distances from the chain. Throws InputError if a chain is closed and the curve is open,
/// or the curve has no length.
std::vector<Vec3> points_along(const std::vector<Vec3>& chain, bool closed,
                               const std::vector<Vec3>& samples);

}  // namespace batten
