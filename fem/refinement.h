// Where a mesh is too coarse: jumps of curvature across edges.
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "batten/fem/surface.h"
#include "batten/fem/parametric_mesh.h"

namespace batten {

/// An estimate of the bending energy's error, one η_T² for each triangle:
///
///     η_T² = ½ Σ_edges of T  h_e ∫_e |[x_nn]|² ds  +  Σ_spokes of T  h_s ∫_s |[x_nn]|² ds
///
/// [x_nn] is the jump of the second normal derivative, a vector. A C1 surface has no other jumps of
/// second derivatives, and so [x_nn] is also the jump of x_uu + x_vv, which is what is computed.
/// Spokes are the inner edges of HCT triangles. All in (u, v), unit beta: x² over domain length².
/// Zero for a cubic; O(h⁴) in sum on a smooth shape, as the energy's error. With a trim, only what
/// is inside counts; edges of the mesh's boundary have no jump. Integrals by three Gauss points:
/// exact for HCT. O(triangles), about a microsecond each.
/// Source: residual estimator of the plate, Verfürth 1996, with the edge term that dominates.
VecX residual_indicator(const Surface& surface);


// The few large among many values.

/// Indices of the largest values, the largest first, that make at least this share of the sum
/// together; equal ones in their order. Values are 0 or above; without a sum above 0 there are none.
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

/// A finer mesh. Old vertices keep their numbers; new ones follow, in the order of the edges that
/// they halve.
struct Bisection {
  ParametricMesh mesh;
  std::vector<int> midpoint;  ///< new vertex at the middle of each old edge, or -1
};

/// Halves the marked triangles across their longest edges, and so many others that the mesh stays
/// conforming (Rivara 1984). Angles do not fall below half of the smallest angle of the first mesh,
/// however often it is called; right isosceles triangles keep their shape. Triangles that are
/// halved stand, as two to four, where they stood. O(triangles) and a few sweeps.
Bisection bisected(const ParametricMesh& mesh, const std::vector<char>& marked);

/// The mesh of these triangles alone, vertices in their old order.
struct Submesh {
  ParametricMesh mesh;
  std::vector<int> vertex;  ///< number in the part of each old vertex, or -1
};
Submesh extract_submesh(const ParametricMesh& mesh, const std::vector<int>& triangles);


// A surface carried over to another mesh of the same domain.

struct SurfaceTransfer {
  Points dofs;                  ///< dofs of the new mesh, dofs × 3
  double max_displacement = 0;  ///< largest |new - old| at the same (u, v), model units
};

/// The dofs of `to` that interpolate the surface: value and gradient at the vertices, slope across
/// the edges at their midpoints. `to` lies in the same domain and covers no more of it (a mesh
/// after bisected(), with or without part_of()); points outside take the nearest triangle.
///
/// Vertices, edges and triangles that both meshes have keep their dofs to the last bit. Where edges
/// are halves of old ones, shape and slope across stay exactly as they were; a cubic stays as it
/// was everywhere. Elsewhere, an old element and its children are different piecewise cubics:
/// positions move by O(h³) of the jumps of curvature inside the old element, O(h⁴) on smooth
/// shapes. `max_displacement` is taken at six points inside of each new triangle. O(triangles log
/// triangles); some ten microseconds for each that is new, on several threads.
SurfaceTransfer interpolate_onto(const Surface& from, const ParametricMesh& to);

}  // namespace batten
