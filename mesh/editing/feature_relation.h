// Geometric relations between form features, as constraints of a deformation.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/features/feature_detection.h"

namespace batten {

/// A geometric relation between form features that a deformation preserves. The undeformed features
/// must satisfy it.
struct FeatureRelation {
  enum class Kind {
    Parallel,  ///< the features rotate equally
    Coaxial,   ///< parallel, and the centres keep their relative position along the common axis
    /// The vector between two centres keeps its length and rotates with the first feature.
    Distance,
    Spacing,   ///< evenly spaced centres stay evenly spaced
    Symmetric  ///< two centres stay mirror images with respect to a plane
  };
  std::string name;
  Kind kind = Kind::Parallel;
  /// Indices of features: two for Symmetric, three or more in their order for Spacing, otherwise
  /// two or more.
  std::vector<int> features;
  /// Coaxial: the first feature, if it is a hole. The centres must be on its axis, to 1e-3 of their
  /// distance or of its radius. Empty: not checked.
  std::optional<HoleMeasure> hole;
  /// Symmetric: normal of the plane (any length above 0), and a point of it.
  std::optional<std::pair<Vec3, Vec3>> plane;
};

/// The constraints that preserve relations; members of a DeformProblem and of its DeformEdit.
struct RelationConstraints {
  std::vector<std::vector<int>> shared_rotations;  ///< groups of features that rotate equally
  std::vector<LinearConstraint> rows;              ///< hard constraints of centres
  std::vector<PointConstraint> point_constraints;
  std::vector<Vec3> constraint_origins;  ///< one for each of `point_constraints`
};

/// The constraints of a relation:
///
///     Parallel   one rotation for all features
///     Coaxial    the same, and c_i - c_0 = R_0 (c_i⁰ - c_0⁰)
///     Distance   c_i - c_0 = R_0 (c_i⁰ - c_0⁰)
///     Spacing    c_{i+1} - 2 c_i + c_{i-1} = R_0 (c_{i+1}⁰ - 2 c_i⁰ + c_{i-1}⁰)
///     Symmetric  (c_0 + c_1) / 2 is on the plane, c_1 - c_0 is along its normal
///
/// `features`: all features of the problem. `centres`: the centre c of each, with coefficients that
/// sum to 1, such as the mean of its vertices or of the loop of a hole. `points`: undeformed
/// vertices (n×3). Throws InputError, naming the relation: too few or too many features, an index
/// out of range, no plane, or features that do not satisfy the relation to 1e-3 of the distance of
/// their centres. O(vertices of the centres).
RelationConstraints relation_constraints(const FeatureRelation& relation,
                                         std::span<const FormFeature> features,
                                         std::span<const VertexCombination> centres,
                                         const Points& points);

}  // namespace batten
