// SPDX-License-Identifier: MPL-2.0
// Estimate of the deformed shape that guides a FormFeatureDeformer.
#pragma once

#include <optional>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Estimate of the deformed shape, computed by another deformer for the same edit without features.
/// It provides surface rotations that cannot be interpolated from the handle rotations, such as
/// those caused by translating a handle.
struct ShapeEstimate {
  Points positions;         ///< estimated vertex positions, n×3
  std::vector<char> known;  ///< per vertex: nonzero if the position is valid; empty: all are valid
  enum class Use {
    /// Only the feature rotations of the estimate are used. The rotation field interpolates the
    /// rotations of features, handles and fixed vertices harmonically, and rotates the curvature of
    /// the undeformed mesh.
    Rotations,
    Shape  ///< the curvature of the estimate is kept; without features the result is the estimate
  } use = Use::Rotations;
  /// Rotation of each feature; empty entry: the rotation is interpolated harmonically. Features
  /// that share vertices must have the same rotation. The entry is ignored for features of kind
  /// TranslationOnly, and for features that contain handle vertices or fixed vertices.
  std::vector<std::optional<Mat3>> feature_rotations;
};

}  // namespace batten
