// A piece of a surface laid out in a plane.
#pragma once

#include <functional>
#include <optional>

#include "batten/mesh/pn_triangle_mesh.h"

namespace batten {

/// A harmonic map of a mesh with a rim into the plane: places u_i of the vertices for which
///
///     Σ w_ij |u_i - u_j|²  over all edges is least, those on the rim are given;
///
/// w the cotangent weights, of 0.01 at least and 100 at most. Such weights turn no triangle over where the rim's
/// places are convex; elsewhere few. Sources: Tutte 1963; Floater 1997, "Parametrization and smooth approximation
/// of surface triangulations"; Pinkall and Polthier 1993 (the cotangents).
class HarmonicMap {
 public:
  /// `boundary_parameter`: the place of each vertex on the rim, from its point. Throws InputError: a mesh without rim
  /// or of several sheets. Costs one factor. The mesh has to outlive the map.
  HarmonicMap(const PnTriangleMesh& mesh,
              const std::function<Vec2(const Vec3&)>& boundary_parameter);

  Vec2 parameter(int vertex) const { return flat_.point(vertex).head<2>(); }
  /// The surface's point over a place, or over the nearest one that has any. A microsecond.
  Vec3 surface_point(const Vec2& parameter) const;

 private:
  const PnTriangleMesh& mesh_;
  TriangleMesh flat_;
  AabbTree search_;
};

}  // namespace batten
