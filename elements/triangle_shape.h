// The shape of a parametric triangle, and how its functions are tabulated.
#pragma once

#include <array>

#include "batten/core/eigen.h"

namespace batten {

enum class TriangleElement { HCT, Z12 };

using Vec12 = Eigen::Matrix<double, 12, 1>;
using Mat12 = Eigen::Matrix<double, 12, 12>;

/// Columns of a tabulation: value and derivatives up to order two.
enum Derivative { kW = 0, kU, kV, kUU, kUV, kVV, kDerivatives };

/// The twelve functions at a point: row a is that of dof a, columns w, w_u, w_v, w_uu, w_uv, w_vv.
using Tabulation = Eigen::Matrix<double, 12, kDerivatives>;

/// The shape of one parametric triangle: everything an element needs to know of it.
struct TriangleShape {
  std::array<Vec2, 3> vertex;
  std::array<double, 3> edge_sign{1, 1, 1};
  std::array<double, 3> b{}, c{};  ///< b_i = v_j - v_k, c_i = u_k - u_j
  double area = 0;

  /// Counter-clockwise vertices. Throws MeshError when the area is not > 0 or a number is not
  /// finite.
  TriangleShape(const Vec2& v1, const Vec2& v2, const Vec2& v3,
                const std::array<double, 3>& signs = {1, 1, 1});

  Vec2 point(const Vec3& L) const { return L[0] * vertex[0] + L[1] * vertex[1] + L[2] * vertex[2]; }
  /// Barycentric coordinates of a point, which may lie outside.
  Vec3 barycentric(const Vec2& p) const;
};

/// Reference functions at one point. Row a: N̂_a. Columns: value, then derivatives in the reduced
/// variables (L1, L2), L3 = 1-L1-L2: N, ∂1, ∂2, ∂11, ∂12, ∂22.
using ReferenceTabulation = Eigen::Matrix<double, 12, 6>;

}  // namespace batten
