// SPDX-License-Identifier: MPL-2.0
// Reference shape functions N̂(L) of the C1 triangles, their integrals, and the surface energy.
// Used by single elements and by assembly. See c1_triangle.h for the dofs.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/elements/quadrature.h"

namespace batten {

// Stretching and bending stiffness of a surface.

/// Stretching and bending stiffness of a surface. The energy of one coordinate w(u, v) is
///
///     E = ½ ∬ (a11 w_u² + 2 a12 w_u w_v + a22 w_v² + b11 w_uu² + 2 b12 w_uv² + b22 w_vv²
///              + 2 m1 w_uu w_uv + 2 m2 w_uu w_vv + 2 m3 w_uv w_vv) du dv.
///
/// alpha = [[a11 a12], [a12 a22]] is the stretching (membrane) stiffness and beta = (b11, b12, b22)
/// the bending stiffness. beta_mixed = (m1, m2, m3) is nonzero only for anisotropic stiffness, see
/// directional(). Valid coefficients: alpha and [[b11 m1 m2], [m1 2 b12 m3], [m2 m3 b22]] are
/// positive semi-definite. The bending energy is rotation-invariant for b11 = b12 = b22 without
/// mixed terms.
struct SurfaceStiffness {
  Mat2 alpha = Mat2::Zero();
  Vec3 beta = Vec3::Ones();
  Vec3 beta_mixed = Vec3::Zero();

  static SurfaceStiffness isotropic(double alpha, double beta) {
    return {alpha * Mat2::Identity(), Vec3::Constant(beta)};
  }
  /// Creates a stiffness that acts only along the direction t in (u, v): alpha w_t² + beta w_tt²
  /// with the derivatives w_t, w_tt along t. Throws InputError if t is not a unit vector.
  static SurfaceStiffness directional(const Vec2& t, double alpha, double beta);

  SurfaceStiffness& operator+=(const SurfaceStiffness& other);
  SurfaceStiffness& operator*=(double factor);
  friend SurfaceStiffness operator+(SurfaceStiffness a, const SurfaceStiffness& b) {
    return a += b;
  }
  friend SurfaceStiffness operator*(double factor, SurfaceStiffness m) { return m *= factor; }

  /// The symmetric 3×3 matrix B of the bending energy ½ ∬ hᵀB h with h = (w_uu, w_uv, w_vv).
  Mat3 bending() const;
  /// True if all coefficients are finite, and the matrices alpha and bending() are positive
  /// semi-definite up to 1e-12 of their norms.
  bool is_valid() const;
};

// Shape of a parametric triangle, and tabulated shape functions.

/// C1 triangle elements: Hsieh-Clough-Tocher, and the rational triangle of [Celniker1991].
enum class TriangleElement { HCT, Z12 };

using Vec12 = Eigen::Matrix<double, 12, 1>;
using Mat12 = Eigen::Matrix<double, 12, 12>;

/// Column indices of a Tabulation: value of a function of (u, v), and derivatives up to order two.
enum Derivative { kW = 0, kU, kV, kUU, kUV, kVV, kDerivatives };

/// The twelve shape functions of a C1 triangle at one point. Row a contains the shape function w of
/// dof a and its derivatives: w, w_u, w_v, w_uu, w_uv, w_vv.
using Tabulation = Eigen::Matrix<double, 12, kDerivatives>;

/// Shape of one parametric triangle: all geometric data that an element needs.
struct TriangleShape {
  /// Vertices in (u, v), counter-clockwise. `edge_sign`: for the edge opposite each vertex, +1 if
  /// it runs counter-clockwise from its lower to its higher global vertex index, otherwise -1.
  std::array<Vec2, 3> vertex;
  std::array<double, 3> edge_sign{1, 1, 1};
  /// Coordinate differences b_i = v_j - v_k, c_i = u_k - u_j of the vertices, (i, j, k) cyclic.
  std::array<double, 3> b{}, c{};
  double area = 0;

  /// Computes the shape from the vertices `v1`, `v2`, `v3` in counter-clockwise order. `signs`: see
  /// `edge_sign`. Throws MeshError if the area is not positive or a coordinate is not finite.
  TriangleShape(const Vec2& v1, const Vec2& v2, const Vec2& v3,
                const std::array<double, 3>& signs = {1, 1, 1});

  /// Point in (u, v) with the barycentric coordinates L.
  Vec2 point(const Vec3& L) const { return L[0] * vertex[0] + L[1] * vertex[1] + L[2] * vertex[2]; }
  /// Barycentric coordinates of a point p in (u, v), which may lie outside of the triangle.
  Vec3 barycentric(const Vec2& p) const;
};

/// The twelve reference shape functions of a C1 triangle at one point, as functions of the
/// barycentric coordinates L1 and L2 (L3 = 1 - L1 - L2). Row a contains function a and its
/// derivatives with respect to L1, L2, L1L1, L1L2 and L2L2.
using ReferenceTabulation = Eigen::Matrix<double, 12, 6>;

/// Reference shape functions, and derivatives up to order two, at barycentric coordinates L.
ReferenceTabulation reference_functions(TriangleElement kind, const Vec3& L);
/// First derivatives of the reference shape functions with respect to L1 and L2 (L3 = 1 - L1 - L2)
/// at the barycentric coordinates L. Takes a third of the time of reference_functions().
Eigen::Matrix<double, 12, 2> reference_gradients(TriangleElement kind, const Vec3& L);

/// Matrix that maps the 12 reference dofs of the HCT triangle to the ten Bézier ordinates of its
/// sub-triangle `sub` (0 to 2).
const Eigen::Matrix<double, 10, 12>& hct_ordinates(int sub);

/// Integrals of the reference shape functions of a C1 triangle over a triangle of area 1: stiffness
/// tensors, mass matrix and unit load.
struct ReferenceTensors {
  /// Nine row-major 12×12 matrices: integrals of products of derivatives with respect to the
  /// barycentric coordinates L1, L2. 0-2: stretching 1·1, 1·2 + 2·1, 2·2; 3-8: bending 11·11,
  /// 12·12, 22·22, 11·12 + 12·11, 11·22 + 22·11, 12·22 + 22·12.
  alignas(64) double stiffness[9][144];
  Mat12 mass;
  Vec12 load;
};

/// Integrals of the reference shape functions of an element type. They are computed at the first
/// call by an exact quadrature rule (HCT) or by six_duffy_rule(14) (Z12); entries are accurate to
/// about 1e-15.
const ReferenceTensors& reference_tensors(TriangleElement kind);

/// Converts derivatives with respect to the barycentric coordinates L1, L2 of a triangle (L3 = 1 -
/// L1 - L2) into derivatives with respect to (u, v).
struct DerivativeMap {
  Eigen::Matrix<double, 2, 2> first;   ///< (w_u, w_v) from the derivatives of w by L1 and L2
  Eigen::Matrix<double, 3, 3> second;  ///< (w_uu, w_uv, w_vv) from the L1L1, L1L2, L2L2 derivatives
  explicit DerivativeMap(const TriangleShape& shape);
};

/// Triangle quadrature rule with the reference shape functions of a C1 triangle at its points.
struct TabulatedRule {
  TriangleRule rule;
  std::vector<ReferenceTabulation> functions;
  /// Derivatives by L1, L2, L1L1, L1L2 and L2L2: [point][derivative][function].
  std::vector<double> rows;
  TabulatedRule(TriangleElement kind, TriangleRule r);
};

/// Entries of the matrix that maps the dofs of a C1 triangle to its reference dofs; see
/// C1Triangle::pull_back_matrix().
struct DofTransformCoefficients {
  /// Per vertex: (u, v) of the edge vector to the next vertex, then to the previous one.
  double gradient[3][4];
  double altitude[3];  ///< per edge: height of the triangle over the edge, times the edge's sign
  double slant[3];     ///< per edge: component of the median along the edge / edge length
  explicit DofTransformCoefficients(const TriangleShape& shape);
};

/// Computes the 12×12 element stiffness matrix K (144 doubles) of a C1 triangle with constant
/// material. This is the inner loop of assembly.
void constant_stiffness(const ReferenceTensors& tensors, const TriangleShape& shape,
                        const SurfaceStiffness& material, double* K);

/// Computes the 12×12 element stiffness matrix K (144 doubles) of a C1 triangle by quadrature.
/// `material`: stiffness at the barycentric coordinates L.
void variable_stiffness(const TabulatedRule& points, const TriangleShape& shape,
                        const std::function<SurfaceStiffness(const Vec3& L)>& material, double* K);

// Units of stiffness and loads; elastic energy of a surface.

/// Units of stiffness and loads.
///
/// - Relative (default): alpha, beta and loads are dimensionless numbers that refer to the face
///   scaled to size 1. The same face in mm and in m then has the same shape for the same numbers.
/// - Absolute: alpha is force/length, beta force·length, uniform loads and pressure force/length²,
///   point loads force, all in the length unit of the model.
enum class LoadUnits { Relative, Absolute };

/// Converts the stiffness of a face of the given size to the face scaled to size 1. The stretching
/// stiffness does not depend on the scale; the bending stiffness is divided by size² for
/// LoadUnits::Absolute.
inline SurfaceStiffness scaled_to_unit_domain(const SurfaceStiffness& material, LoadUnits units,
                                              double size) {
  SurfaceStiffness scaled = material;
  if (units == LoadUnits::Absolute) {
    scaled.beta /= size * size;
    scaled.beta_mixed /= size * size;
  }
  return scaled;
}

/// Elastic energy of a surface, split into stretching and bending.
struct SurfaceEnergy {
  double stretching = 0;  ///< energy of the stretching stiffness alpha, summed over x, y, z
  double bending = 0;     ///< energy of the bending stiffness beta, summed over x, y, z
};

}  // namespace batten
