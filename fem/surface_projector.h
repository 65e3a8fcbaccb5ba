// SPDX-License-Identifier: MPL-2.0
// Fast closest-point projection of many points onto a surface.
#pragma once

#include <vector>

#include "batten/fem/surface.h"
#include "batten/fem/triangle_locator.h"

namespace batten {

/// Projects points in space onto a surface by Newton's method across elements. The iteration starts
/// at the nearest sample (vertex or centroid of an element), or at a known location nearby.
///
/// All points of the mesh are candidates, also those outside of a trim. The result is a local
/// minimum of the distance: on a surface that folds between two samples, another point may be
/// nearer. Surface::closest_point() searches everywhere and takes hundreds of times as long.
///
/// Keeps a reference to the surface, which must outlive it. Queries are thread-safe. Cost:
/// O(triangles) for the construction; a few microseconds per point, plus O(triangles) to find the
/// nearest sample.
class SurfaceProjector {
 public:
  explicit SurfaceProjector(const Surface& surface);

  /// Point of the surface nearest to p in space, by Newton's method from the nearest sample (vertex
  /// or centroid of an element). p and the distance are in model units.
  Surface::ClosestPoint nearest(const Vec3& p) const;
  /// Point of the surface nearest to p in space, by Newton's method from a known location nearby,
  /// for example that of the previous point on a curve. Newton steps are replaced by Gauss-Newton
  /// steps if the distance is not convex. Steps are halved until the distance decreases; a step
  /// that leaves the mesh ends on its boundary.
  Surface::ClosestPoint nearest(const Vec3& p, const Location& start) const;

 private:
  const Surface& surface_;
  TriangleLocator locator_;
  Points samples_;
  std::vector<Location> where_;
};

// Fast evaluation of a fixed surface.

/// Copy of a surface prepared for many evaluations. For HCT triangles it stores the Bézier
/// ordinates of their three cubics, 90 numbers per triangle, which Surface::position() recomputes
/// at each point. Cost: O(triangles) for the construction, O(1) per point. Thread-safe.
class SurfaceEvaluator {
 public:
  explicit SurfaceEvaluator(Surface surface);

  const Surface& surface() const { return surface_; }
  /// Triangle that contains (u, v), and barycentric coordinates; see TriangleLocator::locate().
  Location locate(const Vec2& uv) const { return locator_.locate(uv); }
  /// Position of the surface at a location of the mesh or at parameters (u, v); model units.
  Vec3 position(const Location& where) const;
  Vec3 position(const Vec2& uv) const { return position(locate(uv)); }

 private:
  Surface surface_;
  TriangleLocator locator_;
  std::vector<Eigen::Matrix<double, 3, 10>> cubics_;  // three per triangle; empty for Z12
};

}  // namespace batten
