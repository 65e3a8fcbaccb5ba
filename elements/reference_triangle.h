// Reference functions N̂(L) of the two C1 triangles and their integrals: shared by single elements
// and by assembly. See c1_triangle.h for the dofs.
#pragma once

#include <functional>
#include <vector>

#include "batten/elements/quadrature.h"
#include "batten/elements/surface_stiffness.h"
#include "batten/elements/triangle_shape.h"

namespace batten {

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

}  // namespace batten
