// SPDX-License-Identifier: MPL-2.0
// Adaptive mesh refinement: error indicator, Dörfler marking, bisection, and transfer of the
// surface.
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "batten/fem/parametric_mesh.h"
#include "batten/fem/surface.h"

namespace batten {

/// Residual error indicator for the bending energy: η_T² for each triangle T,
///
///     η_T² = ½ Σ_edges of T  h_e ∫_e |[x_nn]|² ds  +  Σ_spokes of T  h_s ∫_s |[x_nn]|² ds
///
/// Edges e and spokes s have the lengths h_e and h_s. [x_nn] is the jump of the second normal
/// derivative of the surface x, a vector. No other second derivative of a C1 surface jumps, so it
/// equals the jump of x_uu + x_vv, which is what is computed. Spokes are the inner edges of HCT
/// triangles, from the vertices to the centroid. All lengths are in (u, v) and beta is 1; the unit
/// is x² over domain length².
///
/// The indicator is zero for a cubic surface. On smooth shapes its sum is O(h⁴), like the error of
/// the energy. With a trim, only the part of the surface inside it counts; boundary edges have no
/// jump. Integrals use three Gauss points, which is exact for HCT. Cost: about a microsecond per
/// triangle. Reference: [Verfurth1996], residual estimator for plates; only the dominant edge term
/// is used.
VecX residual_indicator(const Surface& surface);

// Marking.

/// Dörfler (bulk) marking: the smallest set of indices whose values add up to at least `fraction`
/// of the sum of all values. The indices are in descending order of their values, equal values in
/// ascending order of index. Values must be ≥ 0; if all are zero, the result is empty.
template <class Values>
std::vector<int> dorfler_marking(const Values& values, double fraction) {
  std::vector<int> order(static_cast<size_t>(values.size()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return values[a] > values[b]; });
  double sum = 0, taken = 0;
  for (const double value : values) sum += value;
  size_t count = 0;
  while (count < order.size() && taken < fraction * sum) taken += values[order[count++]];
  order.resize(count);
  return order;
}

// Local refinement of a conforming mesh.

/// Result of bisected(). The vertices of the original mesh keep their indices; new vertices follow,
/// in the order of the bisected edges.
struct Bisection {
  ParametricMesh mesh;
  /// Per edge of the original mesh: index of the new vertex at its midpoint; -1: edge not bisected.
  std::vector<int> midpoint;
};

/// Bisects the marked triangles across their longest edges, and the additional triangles needed to
/// keep the mesh conforming ([Rivara1984]).
///
/// `marked`: one flag per triangle. Angles never fall below half of the smallest angle of the
/// initial mesh, however often a mesh is refined; right isosceles triangles keep their shape. The
/// two to four children of a triangle take its position in the list of triangles. Throws InputError
/// if `marked` has the wrong size. Cost: O(triangles), in a few sweeps.
Bisection bisected(const ParametricMesh& mesh, const std::vector<char>& marked);

/// Result of extract_submesh(). Its vertices are in the order of the original mesh.
struct Submesh {
  ParametricMesh mesh;
  std::vector<int> vertex;  ///< index in the submesh of each original vertex; -1: not contained
};
/// Extracts the part of a mesh that consists of the given triangles.
Submesh extract_submesh(const ParametricMesh& mesh, const std::vector<int>& triangles);

// Transfer of a surface to another mesh of the same domain.

/// Result of interpolate_onto().
struct SurfaceTransfer {
  Points dofs;  ///< dofs of the surface on the new mesh, n×3
  /// Largest distance of the new from the old surface at equal (u, v), model units.
  double max_displacement = 0;
};

/// Interpolates a surface onto another mesh: values and gradients at the vertices of `to`, normal
/// derivatives at its edge midpoints.
///
/// `to` must lie in the same domain and not extend beyond it, for example the result of bisected(),
/// with or without extract_submesh(). Points outside of the old mesh are evaluated in its nearest
/// triangle. Vertices, edges and triangles that both meshes share keep their dofs to the last bit.
/// Along edges that are halves of old ones, position and normal derivative are preserved exactly.
/// Cubics are preserved everywhere.
///
/// Elsewhere, an old element and its children are different piecewise cubics: positions change by
/// O(h³) times the curvature jumps inside the old element, and by O(h⁴) on smooth shapes.
/// `max_displacement` is measured at six points inside each new triangle. Cost: O(triangles log
/// triangles), about ten microseconds per new triangle; uses several threads.
SurfaceTransfer interpolate_onto(const Surface& from, const ParametricMesh& to);

}  // namespace batten
