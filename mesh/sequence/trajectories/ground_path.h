// Ground paths: the path of a sequence over the ground, and the motions that move its frames to
// another path.
#pragma once

#include <vector>

#include "batten/mesh/sequence/trajectories/keyframe_weights.h"
#include "batten/mesh/sequence/trajectories/rigid_motion.h"

namespace batten {

/// A C2 curve in the ground plane (through the origin, perpendicular to `up`), parametrised by arc
/// length s. It is extended by straight lines beyond its ends. Value semantics.
class GroundPath {
 public:
  /// Interpolates points, projected to the ground, by the cubic spline of least ∫ |x''|² over chord
  /// length. Throws InputError: fewer than two points, consecutive points with the same projection,
  /// a coordinate that is not finite, an `up` without direction.
  static GroundPath through(const std::vector<Vec3>& points, const Vec3& up = Vec3::UnitZ());
  /// Wraps a curve that already lies in the ground plane. `up`: unit normal of the plane.
  GroundPath(PiecewiseCubic curve, const Vec3& up);

  double length() const { return lengths_.back(); }
  const Vec3& up() const { return up_; }
  /// Point at arc length s.
  Vec3 at(double s) const;
  /// Local frame at arc length s: the columns of `rotation` are tangent, up × tangent, up;
  /// `translation` is at(s). A Frenet normal would be undefined on straight parts and flip at
  /// inflections.
  RigidMotion frame(double s) const;
  /// Arc length from the start to curve parameter u, accurate to about 1e-10 of the total length.
  double length_to(double u) const;
  /// Curve parameter at arc length s; the inverse of length_to().
  double parameter(double s) const;

 private:
  PiecewiseCubic curve_;
  Vec3 up_;
  std::vector<double> u_, lengths_;  // at several parameters of each span
};

/// Options of fit_path().
struct PathOptions {
  Vec3 up = Vec3::UnitZ();
  /// Number of uniform spans of the fitted curve. Sway and bob shorter than two spans are smoothed
  /// away and so stay in the frames. 0: one span per 30 frames, between 1 and 12.
  int spans = 0;
};

/// A path and the arc length of each frame along it.
struct FittedPath {
  GroundPath path;
  std::vector<double> lengths;
};

/// Fits a path to the centroids of the frames, projected to the ground. It is a least-squares fit
/// by uniform cubic B-splines over chord length, at evenly spaced points of the polyline, so that
/// frames at rest do not get more weight. Throws InputError: fewer than two frames, all centroids
/// at one ground position, a negative number of spans, an `up` without direction. O(frames +
/// spans). Source: [Xu2007], section 6.
FittedPath fit_path(const Points& centres, const PathOptions& options = {});

/// How arc lengths s on the old path (length L) map to s' on the new path (length L').
enum class PathLengths {
  Absolute,   ///< s' = s: steps keep their length; beyond the end the path continues straight
  Normalised  ///< s' = s L'/L: the whole new path is covered
};

/// Rigid motion of each frame from its local frame on the old path to that on the new path. Offsets
/// beside and above the path are preserved. Two straight paths on the same line with the same start
/// give the identity to 1e-12. O(frames).
std::vector<RigidMotion> path_motions(const FittedPath& from, const GroundPath& to,
                                      PathLengths lengths = PathLengths::Absolute);

}  // namespace batten
