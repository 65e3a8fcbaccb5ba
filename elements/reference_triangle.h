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

/// Coefficients of the surface energy
///
///     E = ∬ (a11 w_u² + 2 a12 w_u w_v + a22 w_v² + b11 w_uu² + 2 b12 w_uv² + b22 w_vv²
///            + 2 m1 w_uu w_uv + 2 m2 w_uu w_vv + 2 m3 w_uv w_vv) du dv.
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
  /// Stiffness alpha w_t² + beta w_tt² in one direction t of (u, v) only. Throws InputError if t is
  /// not a unit vector.
  static SurfaceStiffness directional(const Vec2& t, double alpha, double beta);

  SurfaceStiffness& operator+=(const SurfaceStiffness& other);
  SurfaceStiffness& operator*=(double factor);
  friend SurfaceStiffness operator+(SurfaceStiffness a, const SurfaceStiffness& b) {
    return a += b;
  }
  friend SurfaceStiffness operator*(double factor, SurfaceStiffness m) { return m *= factor; }

  /// The 3×3 matrix of the bending energy with respect to (w_uu, w_uv, w_vv).
  Mat3 bending() const;
  /// Whether all coefficients are finite, and alpha and bending() are positive semi-definite up to
  /// 1e-12 of their norms.
  bool is_valid() const;
};

// Shape of a parametric triangle, and tabulated shape functions.

/// The two C1 triangle elements: Hsieh-Clough-Tocher and the rational triangle of Celniker and
/// Gossard.
enum class TriangleElement { HCT, Z12 };

using Vec12 = Eigen::Matrix<double, 12, 1>;
using Mat12 = Eigen::Matrix<double, 12, 12>;

/// Column indices of a Tabulation: value and derivatives up to order two.
enum Derivative { kW = 0, kU, kV, kUU, kUV, kVV, kDerivatives };

/// The twelve shape functions at one point. Row a belongs to dof a; the columns are w, w_u, w_v,
/// w_uu, w_uv, w_vv.
using Tabulation = Eigen::Matrix<double, 12, kDerivatives>;

/// Shape of one parametric triangle: all geometric data that an element needs.
struct TriangleShape {
  /// Vertices in (u, v), and the sign of each edge's normal dof (see c1_triangle.h).
  std::array<Vec2, 3> vertex;
  std::array<double, 3> edge_sign{1, 1, 1};
  std::array<double, 3> b{}, c{};  ///< b_i = v_j - v_k, c_i = u_k - u_j, (i, j, k) cyclic
  double area = 0;

  /// `v1`, `v2`, `v3`: vertices in counter-clockwise order. `signs`: sign of the normal dof of each
  /// edge. Throws MeshError if the area is not positive or a coordinate is not finite.
  TriangleShape(const Vec2& v1, const Vec2& v2, const Vec2& v3,
                const std::array<double, 3>& signs = {1, 1, 1});

  /// Point in (u, v) with barycentric coordinates L.
  Vec2 point(const Vec3& L) const { return L[0] * vertex[0] + L[1] * vertex[1] + L[2] * vertex[2]; }
  /// Barycentric coordinates of a point, which may lie outside of the triangle.
  Vec3 barycentric(const Vec2& p) const;
};

/// Reference shape functions at one point. Row a contains N̂_a and its derivatives in the reduced
/// variables (L1, L2), L3 = 1-L1-L2: columns N, ∂1, ∂2, ∂11, ∂12, ∂22.
using ReferenceTabulation = Eigen::Matrix<double, 12, 6>;

/// Reference shape functions and their derivatives up to order two at barycentric L.
ReferenceTabulation reference_functions(TriangleElement kind, const Vec3& L);
/// First derivatives (∂1, ∂2) of the reference shape functions; takes a third of the time of
/// reference_functions().
Eigen::Matrix<double, 12, 2> reference_gradients(TriangleElement kind, const Vec3& L);

/// Matrix that maps the reference dofs to the ten Bézier ordinates of HCT sub-triangle `sub`.
const Eigen::Matrix<double, 10, 12>& hct_ordinates(int sub);

/// Stiffness tensors, mass matrix and unit load of the reference shape functions, integrated over a
/// triangle of area 1.
struct ReferenceTensors {
  /// Nine row-major 12×12 matrices. 0-2: stretching 11, 12 + 21, 22; 3-8: bending 11·11, 12·12,
  /// 22·22, 11·12 + 12·11, 11·22 + 22·11, 12·22 + 22·12.
  alignas(64) double stiffness[9][144];
  Mat12 mass;
  Vec12 load;
};

/// Reference tensors of an element type. They are computed at first use by an exact rule (HCT) or
/// by the six-Duffy rule with m = 14 (Z12); entries are accurate to about 1e-15.
const ReferenceTensors& reference_tensors(TriangleElement kind);

/// Converts derivatives with respect to (L1, L2) into derivatives with respect to (u, v). The rows
/// are u, v for first derivatives and uu, uv, vv for second derivatives.
struct DerivativeMap {
  Eigen::Matrix<double, 2, 2> first;   ///< (w_u, w_v) = first · (∂1, ∂2)
  Eigen::Matrix<double, 3, 3> second;  ///< (w_uu, w_uv, w_vv) = second · (∂11, ∂12, ∂22)
  explicit DerivativeMap(const TriangleShape& shape);
};

/// Quadrature rule with the reference shape functions tabulated at its points.
struct TabulatedRule {
  TriangleRule rule;
  std::vector<ReferenceTabulation> functions;
  std::vector<double> rows;  ///< five derivatives of the functions: [point][derivative][function]
  TabulatedRule(TriangleElement kind, TriangleRule r);
};

/// Entries of the matrix P that maps the dofs of a triangle to its reference dofs: 2×2 gradient
/// maps, altitudes over the edges, and slants of the medians.
struct DofTransformCoefficients {
  double gradient[3][4];  ///< per vertex V_i, row-major: (u, v) of V_j - V_i; of V_k - V_i
  double altitude[3];     ///< edge_sign · 2 · triangle area / edge length
  double slant[3];        ///< (V_i - M_i)·(V_k - V_j) / |V_k - V_j|², M_i: midpoint of edge i
  explicit DofTransformCoefficients(const TriangleShape& shape);
};

/// Computes the element stiffness K (144 doubles) for a constant material. This is the inner loop
/// of assembly.
void constant_stiffness(const ReferenceTensors& tensors, const TriangleShape& shape,
                        const SurfaceStiffness& material, double* K);

/// Computes the element stiffness K (144 doubles) for a material that varies with L, by quadrature.
void variable_stiffness(const TabulatedRule& points, const TriangleShape& shape,
                        const std::function<SurfaceStiffness(const Vec3& L)>& material, double* K);

// Units of stiffness and loads; elastic energy of a surface.

/// Units of stiffness and loads.
///
/// - Relative (default): alpha, beta and loads are dimensionless numbers on the region scaled to
///   size 1. The same region in mm and in m then has the same shape for the same numbers.
/// - Absolute: alpha is force/length, beta force·length, uniform loads and pressure force/length²,
///   point loads force, all in the length unit of the model.
enum class LoadUnits { Relative, Absolute };

/// Converts a material to the domain scaled to size 1 (u = length / size). Stretching does not
/// depend on the scale in two dimensions; bending is divided by size² in absolute units.
inline SurfaceStiffness scaled_to_unit_domain(const SurfaceStiffness& material, LoadUnits units,
                                              double size) {
  SurfaceStiffness scaled = material;
  if (units == LoadUnits::Absolute) {
    scaled.beta /= size * size;
    scaled.beta_mixed /= size * size;
  }
  return scaled;
}

/// Elastic energy ½ qᵀK q of a surface, split into its two terms.
struct SurfaceEnergy {
  double stretching = 0;  ///< ½ ∬ of the alpha terms, summed over x, y, z
  double bending = 0;     ///< ½ ∬ of the beta terms, summed over x, y, z
};

}  // namespace batten
