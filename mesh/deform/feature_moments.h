// SPDX-License-Identifier: MPL-2.0
// Moments of forces on rigid features, with which their rotations are determined.
#pragma once

#include <span>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/deform/feature_stiffness.h"

namespace batten {

struct FormFeatureData;

/// Moments of the forces that the surface exerts on the rigid features, see
/// FormFeatureDeformer::feature_moments() and feature_stiffness().
class FeatureMoments {
 public:
  /// Computes the levers in the undeformed shape. Cost: O(nonzeros of A).
  explicit FeatureMoments(const FormFeatureData& data);
  /// The first moments in the last solution of the same data. Does not allocate.
  const Points& evaluate(const FormFeatureData& data);
  FeatureStiffness stiffness(FormFeatureData& data, std::span<const int> body) const;

 private:
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  /// Responses to rotations of groups of bodies, three columns each.
  struct Response {
    RowMajor residuals;  // A p - b
    MatX points;         // movements of the points of point constraints, by the free unknowns only
  };
  Response response(FormFeatureData& data, std::span<const int> body, int first, int count) const;

  void add_forces(FormFeatureData& data, std::span<const int> body, MatX& w) const;

  struct Lever {
    long row;  // of A, or a point equation
    Vec3 arm;
  };
  std::vector<std::vector<Lever>> of_rows_, of_equations_;  // per feature
  Points tensors_;                                          // stacked 3×3 matrices
};

}  // namespace batten
