// A deformed shape that an edit with features may follow.
#pragma once

#include <optional>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// A shape that another deformer found for the same edit, without features: it has turned the sheet
/// where the handles' turns alone do not say how it turns.
struct ShapeEstimate {
  Points positions;         ///< n×3
  std::vector<char> known;  ///< vertices that it knows the places of; empty: all
  enum class Use {
    Rotations,  ///< only its features' turns count: the field is harmonic between them, the handles and
                ///< what is fixed, and turns the curvature of the rest shape
    Shape       ///< curvature is the estimate's own: without features the result is the estimate
  } use = Use::Rotations;
  /// The turn of each feature, the same for features that share vertices; none: as the harmonic field
  /// has it. Those that handles or fixed vertices hold, or that keep their direction, do as these say.
  std::vector<std::optional<Mat3>> feature_rotations;
};

}  // namespace batten
