// The reference functions of the HCT triangle with three derivatives, tabulated where the variation
// of curvature looks at them. Internal.
#pragma once

#include <array>

#include "batten/elements/reference_triangle.h"
#include "batten/fairing/curvature_variation.h"

namespace batten {

/// Derivatives are with respect to (L1, L2), L3 = 1 - L1 - L2. Third s is (V_j, V_k, centre),
/// (s, j, k) cyclic; edge i lies in third i, spoke i runs from V_i to the centre.
struct HctTables {
  using Slopes = Eigen::Matrix<double, 12, 2>;
  using Second = Eigen::Matrix<double, 12, 3>;
  /// Gauss points on [0, 1], weights ½; and three of them, with their weights.
  static const std::array<double, 2> gauss;
  static const std::array<double, 3> gauss3, weight3;

  std::array<Table3, 9> inside;  ///< three points of each third; weights 1/9 of the area
  struct Spoke {
    Slopes slopes;
    Second jump;  ///< second derivatives on third i+1 less those on third i+2
  };
  std::array<std::array<Spoke, 2>, 3> spokes;
  struct EdgePoint {
    Slopes slopes;
    Second second;
  };
  /// Points of edge i from V_j to V_k.
  std::array<std::array<EdgePoint, 2>, 3> edges;
  std::array<std::array<EdgePoint, 3>, 3> edges3;

  static const HctTables& get();

 private:
  HctTables();
};

}  // namespace batten
