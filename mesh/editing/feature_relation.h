// SPDX-License-Identifier: MPL-2.0
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
    Coaxial,   ///< equal rotations; the centres keep their distances along the common axis
    /// The vectors from the centre of the first feature to the centres of the other features keep
    /// their lengths and rotate with the first feature.
    Distance,
    Spacing,   ///< evenly spaced feature centres stay evenly spaced
    Symmetric  ///< two feature centres stay mirror images with respect to a plane
  };
  std::string name;
  Kind kind = Kind::Parallel;
  /// Indices of the related features: two for Kind::Symmetric, three or more in the order along the
  /// row for Kind::Spacing, otherwise two or more.
  std::vector<int> features;
  /// For Kind::Coaxial: measure of the first feature, if it is a hole. The centres of the other
  /// features must lie on the axis of this hole; the tolerance is 1e-3 of their distance from the
  /// hole, or of the hole radius if that is larger. Empty: the axis is not checked.
  std::optional<HoleMeasure> hole;
  /// For Kind::Symmetric: normal of the symmetry plane (of any length above 0), and a point on it.
  std::optional<std::pair<Vec3, Vec3>> plane;
};

/// Constraints that preserve a relation, to be appended to the members with the same names of a
/// DeformProblem and of its DeformEdit.
struct RelationConstraints {
  std::vector<std::vector<int>> shared_rotations;  ///< groups of features that rotate equally
  std::vector<LinearConstraint> rows;              ///< hard constraints on the centres of features
  std::vector<PointConstraint> point_constraints;
  std::vector<Vec3> constraint_origins;  ///< origin of each point constraint, see DeformEdit
};

/// Constraints that preserve a relation between features with the centres c_0, c_1, … (undeformed:
/// c_0⁰, c_1⁰, …). R_0 is the rotation of the first feature.
///
///     Parallel   one rotation for all features
///     Coaxial    one rotation for all features, and c_i - c_0 = R_0 (c_i⁰ - c_0⁰)
///     Distance   c_i - c_0 = R_0 (c_i⁰ - c_0⁰)
///     Spacing    c_{i+1} - 2 c_i + c_{i-1} = R_0 (c_{i+1}⁰ - 2 c_i⁰ + c_{i-1}⁰)
///     Symmetric  (c_0 + c_1) / 2 is on the plane, c_1 - c_0 is along the normal of the plane
///
/// `features`: all features of the problem. `centres`: centre of each feature, for example the mean
/// of the vertices of the feature or of the loop of a hole; the coefficients must sum to 1.
/// `points`: undeformed vertex positions (n×3). Throws InputError if there are too few or too many
/// features, an index is out of range, the plane is missing, or the undeformed features deviate
/// from the relation by more than 1e-3 of the distance between their centres. The message names the
/// relation. O(vertices of the centres).
RelationConstraints relation_constraints(const FeatureRelation& relation,
                                         std::span<const FormFeature> features,
                                         std::span<const VertexCombination> centres,
                                         const Points& points);

}  // namespace batten
