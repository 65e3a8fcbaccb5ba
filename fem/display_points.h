// Points and normals of a moving surface at fixed places of (u, v), for display.
#pragma once

#include <array>
#include <vector>

#include "batten/fem/surface_assembler.h"

namespace batten {

/// What a viewer draws of a surface whose dofs change all the time: position x and unit normal
/// x_u × x_v / |x_u × x_v| at places that stand. Each place knows the few numbers that it needs:
///
///     at a vertex          3 dofs: they are x, x_u and x_v
///     on an element edge   7: those of its ends and the edge's slope (c1_triangle.h)
///     inside a triangle   12
///
/// Coefficients are kept in single precision, of differences: Σ N = 1 over the position dofs a, so
/// x_u = Σ N_u,a (q_a - q_1) + slopes, and no digit is lost to the 1/h in N_u. Sums are taken in
/// double precision. Good to 1e-6 of the surface's size and of a unit normal, where x_u and x_v are
/// not nearly parallel.
///
/// Memory: about 100 bytes a place on an edge, 180 inside. Time: about ten nanoseconds a
/// place on one thread.
class DisplayPoints {
 public:
  /// Throws InputError: a place in no triangle, barycentric coordinates that are not finite or do
  /// not add up to 1 or lie outside of the triangle by more than 1e-9. O(places).
  DisplayPoints(const ParametricMesh& mesh, TriangleElement kind,
                const std::vector<Location>& where);

  int count() const { return count_; }

  /// Points and normals for dofs x (n×3), 3 numbers each, in the order of the places; `shift` is
  /// added to the points. Zero normals where the surface is singular: |x_u × x_v| ≤ 1e-6
  /// |x_u||x_v|. Both arrays hold 3 count() numbers. Allocates nothing; the same bits on one thread
  /// or two. Not from two threads at once (they would share its workspace). Throws InputError when
  /// x has another number of dofs than the mesh.
  void evaluate(const Points& x, const Vec3& shift, float* points, float* normals) const;

 private:
  // Places of one kind.
  struct Group {
    std::vector<int> numbers;  // of each place: its number, vertices, edge dofs
    // Of x, x_u, x_v: other vertices less the first, slopes at the vertices, slopes of the edges.
    std::vector<float> coefficients;
    int count = 0;
  };
  struct alignas(32) Row {
    double xyz0[4];
  };

  int count_ = 0, dof_count_ = 0;
  std::array<Group, 3> groups_;  // at vertices, on edges, inside
  // Of the evaluation at hand: dofs with their three coordinates side by side, so that one load of
  // a vector unit serves all three.
  mutable std::vector<Row> rows_;
};

}  // namespace batten
