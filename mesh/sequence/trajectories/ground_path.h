// SPDX-License-Identifier: MPL-2.0
// Ground paths: the path of a sequence over the ground, and the motions that move its frames to
// another path.
#pragma once

#include <vector>

#include "batten/fem/curves/cubic.h"
#include "batten/mesh/sequence/trajectories/keyframe_weights.h"
#include "batten/mesh/sequence/trajectories/rigid_motion.h"

namespace batten {

/// A C2 curve in the ground plane (the plane through the origin perpendicular to `up`),
/// parametrised by arc length s. The curve is extended by straight lines beyond both ends. It has
/// value semantics.
class GroundPath {
 public:
  /// Interpolates points, projected to the ground plane, by the natural cubic spline over chord
  /// length, which minimises ∫ |x''|². Throws InputError if there are fewer than two points,
  /// consecutive points have the same projection, a coordinate is not finite, or `up` is zero.
  static GroundPath through(const std::vector<Vec3>& points, const Vec3& up = Vec3::UnitZ());
  /// Creates a path from a curve in the ground plane. `up`: unit normal of this plane.
  GroundPath(PiecewiseCubic curve, const Vec3& up);

  double length() const { return lengths_.back(); }
  const Vec3& up() const { return up_; }
  /// Point of the path at arc length s.
  Vec3 at(double s) const;
  /// Local coordinate frame at arc length s: the columns of RigidMotion::rotation are the tangent,
  /// up × tangent and up; RigidMotion::translation is at(s). Unlike the Frenet frame, this frame is
  /// defined on straight parts and does not flip at inflections.
  RigidMotion frame(double s) const;
  /// Arc length from the start of the path to the curve parameter u, accurate to about 1e-10 of the
  /// total length.
  double length_to(double u) const;
  /// Curve parameter at arc length s from the start of the path; the inverse of length_to().
  double parameter(double s) const;

 private:
  PiecewiseCubic curve_;
  Vec3 up_;
  std::vector<double> u_, lengths_;  // at several parameters of each span
};

/// Options of fit_path().
struct PathOptions {
  Vec3 up = Vec3::UnitZ();
  /// Number of uniform spans of the fitted curve; 0: one span per 30 frames, between 1 and 12. The
  /// path does not follow oscillations (the sway of a walk) that are shorter than two spans; such
  /// oscillations remain motions relative to the path.
  int spans = 0;
};

/// A path that was fitted to a sequence, and the arc length of each frame along the path.
struct FittedPath {
  GroundPath path;
  std::vector<double> lengths;
};

/// Fits a path to the frames of a sequence. `centres`: centroid of each frame (F×3); they are
/// projected to the ground plane and connected by a polyline. The path is a least-squares fit of
/// this polyline at evenly spaced points by uniform cubic B-splines over chord length, so frames at
/// rest do not get additional weight. Throws InputError if there are fewer than two frames, all
/// centroids have the same projection, the number of spans is negative, or `up` is zero. O(frames +
/// spans). Reference: [Xu2007], section 6.
FittedPath fit_path(const Points& centres, const PathOptions& options = {});

/// How the position of a frame on the old path is mapped to a position on the new path.
enum class PathLengths {
  Absolute,   ///< equal arc length: steps keep their length; a short path is extended straight
  Normalised  ///< equal fraction of the path length: the frames cover the whole new path
};

/// Rigid motions that move the frames of a sequence from path `from` to path `to`, one per frame.
/// Each motion maps the local coordinate frame of the old path to that of the new path (see
/// GroundPath::frame()), which preserves offsets beside and above the path. If both paths are
/// straight, on the same line, and have the same start, all motions are the identity to 1e-12.
/// O(frames).
std::vector<RigidMotion> path_motions(const FittedPath& from, const GroundPath& to,
                                      PathLengths lengths = PathLengths::Absolute);

}  // namespace batten
