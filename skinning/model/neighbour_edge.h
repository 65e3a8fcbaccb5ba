// SPDX-License-Identifier: MPL-2.0
// Given surfaces beside edges of a model. A face of the model continues such a neighbour with
// tangent planes (G1) or curvature (G2); the neighbour itself never changes.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// A point on the edge of a given surface, with the tangent plane and the curvature there. The
/// values do not depend on the side to which the normal of the surface points.
struct NeighbourSample {
  Vec3 point = Vec3::Zero();
  /// Unit vector in the tangent plane of the surface, perpendicular to the edge, which points into
  /// the surface.
  Vec3 into = Vec3::Zero();
  /// Vector of the normal curvature in the direction `into`: the normal n of the surface times the
  /// second fundamental form II(into, into), 1/length.
  Vec3 curvature = Vec3::Zero();
};

/// How a face of the model meets a given surface.
enum class NeighbourContinuity {
  Automatic,  ///< G1 unless the initial face meets the given surface at a large angle, which is G0
  Position,   ///< G0: a common edge
  Tangent,    ///< G1: common tangent planes
  Curvature   ///< G2: G1, and fairing makes the curvature continuous
};

/// Samples of a given surface along one of its edges, in order. Tangent planes between two samples
/// are interpolated linearly; the error is φ²/8 for planes that differ by the angle φ (radians).
struct NeighbourCurve {
  std::string name;  ///< name of the surface for reports, such as "face 3 of part.step"
  std::vector<NeighbourSample> samples;  ///< at least two; the last of a closed edge is the first
  NeighbourContinuity continuity = NeighbourContinuity::Automatic;
};

/// The given surface along one edge of a model: tangent plane and curvature as functions of the
/// fraction f of the edge's parameter interval, 0 at its start and 1 at its end.
class NeighbourEdge {
 public:
  /// Projects the edge `curve` onto the closest of the curves `neighbours`. Returns null if a point
  /// of `curve` is farther than `tolerance` (model units) from all of them. O(neighbour samples).
  static std::shared_ptr<const NeighbourEdge> along(const HermiteCurve& curve,
                                                    const std::vector<NeighbourCurve>& neighbours,
                                                    double tolerance);

  /// Names of the surfaces along the edge, without repetition, in the direction of the edge.
  const std::vector<std::string>& names() const { return names_; }
  /// The continuity that the first of these surfaces requests.
  NeighbourContinuity continuity() const { return continuity_; }
  /// The tangent plane at fraction f: the unit vector into the given surface that is perpendicular
  /// to `tangent`, the derivative of the edge, which may have any length.
  Vec3 into(double f, const Vec3& tangent) const;
  /// The vector of normal curvature across the edge at fraction f (NeighbourSample::curvature).
  Vec3 curvature(double f) const;
  /// A unit normal of the given surface at the point of the edge closest to `x`; its side is
  /// arbitrary. O(1,000) operations.
  Vec3 normal_near(const Vec3& x) const;
  /// Appends points on the edge of the given surface, one row each, and unit normals there. `left`:
  /// true if the face of the model lies to the left of the edge, seen from the tip of its normal;
  /// the normals then have the side of those of the face.
  void sample(bool left, Points& positions, Points& normals) const;
  /// Largest distance between the edge and the edge of the given surface, model units.
  double distance() const { return distance_; }

 private:
  NeighbourEdge() = default;
  Vec3 along(int i) const;
  Vec3 interpolated(const std::vector<Vec3>& values, double f) const;

  std::vector<std::string> names_;
  NeighbourContinuity continuity_ = NeighbourContinuity::Automatic;
  std::vector<Vec3> points_, into_, curvature_;  // at equal steps of f
  std::vector<Vec3> given_;                      // the nearest samples of the given surface
  double distance_ = 0;
};

}  // namespace batten
