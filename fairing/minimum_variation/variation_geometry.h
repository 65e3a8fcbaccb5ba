// SPDX-License-Identifier: MPL-2.0
// Geometry of the minimum-variation terms on one triangle in its (L1, L2): basis-function tables,
// curvature jumps and twist of the normal.
#pragma once

#include <array>

#include "batten/elements/reference_triangle.h"
#include "batten/fairing/minimum_variation/curvature_variation.h"
#include "batten/fem/surface.h"

namespace batten {

/// Basis functions of the reference HCT triangle with three derivatives, tabulated at the
/// quadrature points.
///
/// Derivatives are with respect to (L1, L2), L3 = 1 - L1 - L2. Third s is (V_j, V_k, centre), (s,
/// j, k) cyclic. Edge i lies in third i; spoke i runs from V_i to the centre.
struct HctTables {
  using Slopes = Eigen::Matrix<double, 12, 2>;
  using Second = Eigen::Matrix<double, 12, 3>;
  /// Two Gauss points on [0, 1], weights ½; and three Gauss points with their weights.
  static const std::array<double, 2> gauss;
  static const std::array<double, 3> gauss3, weight3;

  std::array<Table3, 9> inside;  ///< three points per third; weights 1/9 of the area
  struct Spoke {
    Slopes slopes;
    Second jump;  ///< second derivatives on third i+1 minus those on third i+2
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

using TriangleDofs = Eigen::Matrix<double, 12, 3>;
using LocalJet = Eigen::Matrix<double, 3, 5>;  ///< X_1, X_2, X_11, X_12, X_22
using LocalSlopes = Eigen::Matrix<double, 3, 2>;

/// Weight of each of nine points in a triangle of area ½.
inline constexpr double kPointWeight = 1.0 / 18;

/// Maps the dofs of a triangle to those of the reference functions.
Mat12 reference_map(const Surface& surface, int t);

/// Directions in (L1, L2): edge i from V_j to V_k, spoke i from V_i to the centre.
Vec2 edge_direction(int i);
Vec2 spoke_direction(int i);
/// Weights of ∂11, ∂12, ∂22 in the second derivative along a direction.
Vec3 second_derivative_weights(const Vec2& direction);
/// Weights of ∂11, ∂12, ∂22 in the mixed second derivative along rows a and b of M.
Vec3 mixed_derivative_weights(const Mat2& M, int a, int b);

/// Weighted jump of curvature across a line at a Gauss point: value = weight n·jump. `jump` is the
/// jump of the second derivative in a direction across the line.
struct CurvatureJump {
  double weight, value;
  Vec3 n;
  Vec2 slopes;  ///< the derivative of n·jump by X_a is slopes[a] n
};
/// `direction`: of the line over its full length. `across`: the direction across it. `thickness`:
/// mean area of the two thirds beside the line over the area of the triangle. `jumps`:
/// MinimumVariationOptions::jumps.
CurvatureJump curvature_jump(const LocalSlopes& X, const Vec3& jump, const Vec2& direction,
                             const Vec2& across, double thickness, double jumps);
inline constexpr double kSpokeThickness = 1.0 / 3;

/// Second fundamental form at a line: index 1 is its unit tangent, index 2 the perpendicular
/// direction in the tangent plane.
struct EdgeSecondForm {
  double along, twist, across;  ///< II_11, II_12, II_22
  Vec3 n, Y1, Y2;
  Mat2 M;                 ///< Y_a = Σ_i M_ai X_i
  Vec2 gamma12, gamma22;  ///< Γ^l_12, Γ^l_22
};
EdgeSecondForm edge_second_form(const LocalJet& jet, const Vec2& direction);

LocalJet local_jet(const TriangleDofs& q, const HctTables::EdgePoint& point);

}  // namespace batten
