// Reference functions N̂(L) of the two C1 triangles and their integrals: shared by single elements
// and by assembly. See c1_triangle.h for the dofs.
#pragma once

#include <functional>
#include <vector>
#include <array>

#include "batten/elements/quadrature.h"
#include "batten/core/eigen.h"

namespace batten {

// Resistance of a surface to stretching and bending.

/// Material of the energy
///
///     E = ∬ (a11 w_u² + 2 a12 w_u w_v + a22 w_v² + b11 w_uu² + 2 b12 w_uv² + b22 w_vv²
///            + 2 m1 w_uu w_uv + 2 m2 w_uu w_vv + 2 m3 w_uv w_vv) du dv,
///
/// beta = (b11, b12, b22), beta_mixed = (m1, m2, m3), zero but for resistance in a direction of its
/// own. Valid: alpha and [[b11 m1 m2], [m1 2 b12 m3], [m2 m3 b22]] positive semi-definite.
/// b11 = b12 = b22 without mixed terms is the rotation-invariant bending energy.
struct SurfaceStiffness {
  Mat2 alpha = Mat2::Zero();
  Vec3 beta = Vec3::Ones();
  Vec3 beta_mixed = Vec3::Zero();

  static SurfaceStiffness isotropic(double alpha, double beta) {
    return {alpha * Mat2::Identity(), Vec3::Constant(beta)};
  }
  /// alpha w_t² + beta w_tt²: resistance in one direction t of (u, v) only. Throws InputError when
  /// t is not of length 1.
  static SurfaceStiffness directional(const Vec2& t, double alpha, double beta);

  SurfaceStiffness& operator+=(const SurfaceStiffness& other);
  SurfaceStiffness& operator*=(double factor);
  friend SurfaceStiffness operator+(SurfaceStiffness a, const SurfaceStiffness& b) {
    return a += b;
  }
  friend SurfaceStiffness operator*(double factor, SurfaceStiffness m) { return m *= factor; }

  /// The matrix of the bending energy over (w_uu, w_uv, w_vv).
  Mat3 bending() const;
  /// Whether all is finite, and alpha and bending() are positive semi-definite to 1e-12 of their
  /// size.
  bool is_valid() const;
};


// The shape of a parametric triangle, and how its functions are tabulated.

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


ReferenceTabulation reference_functions(TriangleElement kind, const Vec3& L);
/// The two columns of first derivatives of the same, in a third of the time.
Eigen::Matrix<double, 12, 2> reference_gradients(TriangleElement kind, const Vec3& L);

/// Rows of the ten Bézier ordinates of HCT sub-triangle `sub` over the reference dofs.
const Eigen::Matrix<double, 10, 12>& hct_ordinates(int sub);

/// Integrals over a triangle of area 1, in the reference dofs.
struct ReferenceTensors {
  /// Row-major 12×12 each. 0-2: stretching 11, 12 + 21, 22; 3-8: bending 11·11, 12·12, 22·22,
  /// 11·12 + 12·11, 11·22 + 22·11, 12·22 + 22·12.
  alignas(64) double stiffness[9][144];
  Mat12 mass;
  Vec12 load;
};

/// Computed once, at first use, by an exact rule (HCT) or six-Duffy with m = 14 (Z12): entries are
/// right to about 1e-15.
const ReferenceTensors& reference_tensors(TriangleElement kind);

/// Derivatives in (u, v) from those in (L1, L2): rows u, v of the gradient map and uu, uv, vv of
/// the second-derivative map.
struct DerivativeMap {
  Eigen::Matrix<double, 2, 2> first;   ///< (w_u, w_v) = first · (∂1, ∂2)
  Eigen::Matrix<double, 3, 3> second;  ///< (w_uu, w_uv, w_vv) = second · (∂11, ∂12, ∂22)
  explicit DerivativeMap(const TriangleShape& shape);
};

/// A rule with the reference functions tabulated at its points.
struct TabulatedRule {
  TriangleRule rule;
  std::vector<ReferenceTabulation> functions;
  std::vector<double> rows;  ///< the five derivatives of the functions: [point][derivative][12]
  TabulatedRule(TriangleElement kind, TriangleRule r);
};

/// TriangleShape reduced to the numbers of P: 2×2 gradient maps, edge altitudes, mid-edge slants.
struct DofTransformCoefficients {
  double gradient[3][4];  ///< row-major [to next; to previous] × [u, v]
  double altitude[3];     ///< edge_sign · 2A / edge length
  double slant[3];        ///< (V_i - M_i)·(V_k - V_j) / |V_k - V_j|²
  explicit DofTransformCoefficients(const TriangleShape& shape);
};

/// Stiffness K (144 doubles) for constant material: the inner loop of assembly.
void constant_stiffness(const ReferenceTensors& tensors, const TriangleShape& shape,
                        const SurfaceStiffness& material, double* K);

/// Stiffness K (144 doubles) for a material that varies with L, by the given rule.
void variable_stiffness(const TabulatedRule& points, const TriangleShape& shape,
                        const std::function<SurfaceStiffness(const Vec3& L)>& material, double* K);


// What bending and stretching cost, and in which units.

/// Relative (default): alpha, beta and loads are pure numbers on the region scaled to size 1, so
/// that the same region in mm and in m is the same shape under the same numbers. Absolute: alpha is
/// force/length, beta force·length, uniform loads and pressure force/length², point loads force,
/// all in the model's length unit.
enum class LoadUnits { Relative, Absolute };

/// The material on a domain that is the region over its size (u = length / size). Stretching is
/// free of scale in two dimensions; bending carries 1/size² in absolute units.
inline SurfaceStiffness scaled_to_unit_domain(const SurfaceStiffness& material, LoadUnits units,
                                              double size) {
  SurfaceStiffness scaled = material;
  if (units == LoadUnits::Absolute) {
    scaled.beta /= size * size;
    scaled.beta_mixed /= size * size;
  }
  return scaled;
}

struct SurfaceEnergy {
  double stretching = 0;  ///< ∬ alpha part of the energy, sum over x, y, z
  double bending = 0;     ///< ∬ beta part
};

}  // namespace batten
