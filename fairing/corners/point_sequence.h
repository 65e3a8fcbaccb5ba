// SPDX-License-Identifier: MPL-2.0
// Cleaned-up input of curve fits and of fairing: distinct points in order, with chord lengths and
// corners.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/core/containers.h"
#include "batten/fairing/curves/curve_options.h"
#include "batten/fem/curves/curve_mesh.h"

namespace batten {

/// What the caller knows about the noise of the points, in model units; 0: unknown.
struct NoiseLevel {
  double size = 0;        ///< RMS of the noise across the curve
  double wavelength = 0;  ///< waves shorter than this are noise
};

/// Points of one curve in order, without coincident neighbours, with chord lengths and corners. The
/// list of a closed curve does not repeat its first point.
struct PointSequence {
  std::vector<Vec3> points;
  std::vector<int> index;  ///< index in `points` of each input point; -1: outlier
  /// Chord length from the first point; closed: one more entry, the total.
  std::vector<double> chord;
  std::vector<int> corners;  ///< indices in `points`, ascending; without the ends of an open curve
  bool closed = false;
  double size = 0;  ///< diagonal of the bounding box

  enum class Outliers { Keep, Drop };  ///< Drop: removes find_outliers(), but keeps given corners

  /// `chord`, or, if steps are mostly noise, the length along averaged points:
  /// averaged_chord_length().
  std::vector<double> averaged_chord() const;
  double length() const { return chord.back(); }
  int count() const { return isize(points); }
  /// Curvature of the circle through point i and its two neighbours; 0 at the ends of an open
  /// curve.
  double curvature(int i) const;

  /// Prepares the points of the curve `name` (used in messages only).
  ///
  /// `corner_angle`: degrees, see find_corners(). `given_corners`: input indices of the corners; if
  /// it is set, corners are not searched. `is_closed`: if it is not set, the curve is closed when
  /// its last point equals its first. `known`: where the points zigzag and this noise exceeds the
  /// estimate from neighbours (correlated noise), corners are searched among averaged points.
  /// Throws InputError under the same conditions as fit_points().
  PointSequence(const std::string& name, const std::vector<Vec3>& given, double corner_angle,
                const std::optional<std::vector<int>>& given_corners, std::optional<bool> is_closed,
                Outliers outliers = Outliers::Keep, const NoiseLevel& known = {});

 private:
  int block_size(const NoiseLevel& known) const;
  void reject_outliers(const std::optional<std::vector<int>>& given_corners);
};

/// Throws InputError unless `tolerance` is a finite length above 0.
void check_tolerance(const std::string& name, double tolerance);
/// Implements fit_points() for a prepared sequence. The returned parameters are those of its
/// points, not of the input points.
CurveFit fit_point_sequence(const std::string& name, PointSequence sequence,
                            const FitOptions& options);

/// Largest permitted distance of a curve from the chord between two adjacent points.
///
/// It is 1.5 times the sagitta of the circular arc of this `curvature` over the chord; the factor
/// allows for a stronger bend in between. `curvature`: the larger of the curvatures at both points,
/// 1/length.
double sagitta_bound(double chord, double curvature);
/// number of equal parts per gap between points at which the curve is checked
constexpr int kSamplesPerGap = 8;
/// Contribution of one curve point to Deviation::between: by how much `x` is farther from the chord
/// a b than `sagitta`; at least 0.
double chord_excess(const Vec3& x, const Vec3& a, const Vec3& b, double sagitta);

/// Measures the deviation of a curve from a sequence. t[i] is the curve parameter of point i.
Deviation deviation_of(const HermiteCurve& curve, const PointSequence& sequence,
                       const std::vector<double>& t);

// Node placement for fair_points().

/// Mesh of a curve to be faired.
struct KnotPlacement {
  CurveMesh mesh;                ///< nodes over [0, length]
  std::vector<int> corner_node;  ///< node of each corner of the sequence
};

/// Places the nodes of a curve to be faired: one at every parameter of `forced`, and one at every
/// point that is not too close to another node.
///
/// If there are more than `max_knots` points, only every second (third, …) point gets a node. If
/// there are fewer, the midpoints between them get nodes too. `u`: parameters of the points, in [0,
/// length]. `mirrored`: the nodes of the second half are the mirror images of those of the first
/// half.
KnotPlacement place_knots(const PointSequence& sequence, const std::vector<double>& u,
                          double length, std::vector<double> forced, bool mirrored, int max_knots);

}  // namespace batten
