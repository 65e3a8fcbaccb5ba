// The path of a sequence over the ground, and what takes its frames along another one.
#pragma once

#include <vector>

#include "batten/mesh/sequence/trajectories/keyframe_weights.h"
#include "batten/mesh/sequence/trajectories/rigid_motion.h"

namespace batten {

/// A C2 curve in the plane through the origin across `up`, by its length; beyond its ends it goes
/// straight on. A value.
class GroundPath {
 public:
  /// Through points, projected to the ground: the cubic spline of least ∫ |x''|² over chord
  /// lengths. Throws InputError: fewer than two points, two in a row in one place of the ground, a
  /// coordinate that is not finite, no `up`.
  static GroundPath through(const std::vector<Vec3>& points, const Vec3& up = Vec3::UnitZ());
  /// A curve that is in the plane already, and the unit vector across that.
  GroundPath(PiecewiseCubic curve, const Vec3& up);

  double length() const { return lengths_.back(); }
  const Vec3& up() const { return up_; }
  Vec3 at(double s) const;
  /// The local frame: turn has the columns tangent, up × tangent, up; shift is at(s). A Frenet
  /// normal would not be defined on straights, and turn over at inflections.
  RigidMotion frame(double s) const;
  /// Length of the curve from its start to a parameter of it, to about 1e-10 of the whole; and
  /// back.
  double length_to(double u) const;
  double parameter(double s) const;

 private:
  PiecewiseCubic curve_;
  Vec3 up_;
  std::vector<double> u_, lengths_;  // at several places of each piece
};

struct PathOptions {
  Vec3 up = Vec3::UnitZ();
  /// Even pieces of the fitted curve. Sway and bob that are shorter than two pieces are smoothed
  /// away, so that they stay in the frames. 0: one for 30 frames, 1 to 12.
  int spans = 0;
};

/// A path and how far along it each frame is.
struct FittedPath {
  GroundPath path;
  std::vector<double> lengths;
};

/// The path of the frames' centroids, projected to the ground: least squares by uniform cubic
/// B-splines over the chord length, at even places of the polyline, so that frames that stand still
/// do not count for more. Throws InputError: fewer than two frames, centroids in one place of the
/// ground, fewer than 0 pieces, no `up`. O(frames + pieces). Source: Xu et al. 2007, section 6.
FittedPath fit_path(const Points& centres, const PathOptions& options = {});

enum class PathLengths {
  Absolute,   ///< s' = s: steps keep their length; past the end the way goes straight on
  Normalised  ///< s' = s L'/L: the whole new path is gone along
};

/// Of each frame the rigid motion from its local frame on the old path to that on the new one: what
/// a frame was beside and above the old path, it is beside and above the new one. One straight path
/// to another on the same line, from the same start, gives the identity to 1e-12. O(frames).
std::vector<RigidMotion> path_motions(const FittedPath& from, const GroundPath& to,
                                      PathLengths lengths = PathLengths::Absolute);

}  // namespace batten
