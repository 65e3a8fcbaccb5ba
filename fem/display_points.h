// SPDX-License-Identifier: MPL-2.0
// Points and normals of a changing surface at fixed parametric locations, for display.
#pragma once

#include <array>
#include <vector>

#include "batten/fem/surface_assembler.h"

namespace batten {

/// Evaluates position x and unit normal x_u × x_v / |x_u × x_v| at fixed locations of a surface
/// whose dofs change continually, for example while it is dragged. Only the dofs that contribute
/// are stored for each location:
///
///     at a vertex          3 dofs: they are x, x_u and x_v
///     on an element edge   7: those of its ends and the edge's normal derivative (c1_triangle.h)
///     inside a triangle   12
///
/// Coefficients are stored in single precision and applied to differences. Since Σ N_a = 1 over the
/// position dofs a, x_u = Σ N_u,a (q_a - q_1) + slopes, and no digits are lost to the factor 1/h in
/// N_u. Sums are accumulated in double precision. Accuracy: 1e-6 of the size of the surface for
/// points and 1e-6 for unit normals, unless x_u and x_v are almost parallel.
///
/// Memory: about 100 bytes per location on an edge, 180 inside a triangle. Time: about ten
/// nanoseconds per location on one thread.
class DisplayPoints {
 public:
  /// Prepares the evaluation of points and normals at the locations `where` of the mesh. Cost:
  /// O(locations). Throws InputError if a triangle does not exist, or if barycentric coordinates
  /// are not finite, do not sum to 1 or lie outside of the triangle by more than 1e-9.
  DisplayPoints(const ParametricMesh& mesh, TriangleElement kind,
                const std::vector<Location>& where);

  /// Number of locations.
  int count() const { return count_; }

  /// Computes points and unit normals at all locations, for the surface with dofs x (n×3).
  ///
  /// `shift` is added to the points. `points` and `normals` must hold 3 count() numbers each (x, y,
  /// z of each location). The normal is zero if the surface is singular: |x_u × x_v| ≤ 1e-6
  /// |x_u||x_v|. Allocates no memory; results are bit-identical for any number of threads. Not
  /// thread-safe, because calls share a workspace. Throws InputError if x does not have as many
  /// rows as the mesh has dofs.
  void evaluate(const Points& x, const Vec3& shift, float* points, float* normals) const;

 private:
  // Locations of one kind: at vertices, on element edges, or inside triangles.
  struct Group {
    std::vector<int> numbers;  // per location: its index, vertices, edge dofs
    // Coefficients of x, x_u, x_v: position of the other vertices minus the first, derivatives at
    // the vertices, normal derivatives at the edges.
    std::vector<float> coefficients;
    int count = 0;
  };
  struct alignas(32) Row {
    double xyz0[4];
  };

  int count_ = 0, dof_count_ = 0;
  std::array<Group, 3> groups_;  // at vertices, on edges, inside
  // Workspace of evaluate(): dofs with their three coordinates side by side, so that one vector
  // load fetches all three.
  mutable std::vector<Row> rows_;
};

}  // namespace batten
