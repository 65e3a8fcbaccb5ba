// Points in an order: what fits and fairing make of a user's list first. Internal.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/core/containers.h"
#include "batten/fairing/curves/curve_options.h"
#include "batten/fem/curves/curve_mesh.h"

namespace batten {

/// What is known of the points' noise, in model units; 0: nothing.
struct NoiseLevel {
  double size = 0;        ///< root mean square across the line
  double wavelength = 0;  ///< shorter waves are noise
};

/// Distinct neighbours, chord lengths, corners. The list of a closed curve does not repeat its
/// first point.
struct PointSequence {
  std::vector<Vec3> points;
  std::vector<int> index;     ///< place of each given point in `points`; -1: an outlier
  std::vector<double> chord;  ///< from the first point; one more entry when closed: the whole
  std::vector<int> corners;   ///< ascending; ends of an open row not among them
  bool closed = false;
  double size = 0;  ///< diagonal of the bounding box

  enum class Outliers { Keep, Drop };  ///< Drop: as find_outliers(), given corners excepted

  /// `chord`, or where steps are noise rather than progress, the way along means (point_means.h).
  std::vector<double> averaged_chord() const;
  double length() const { return chord.back(); }
  int count() const { return isize(points); }
  /// Curvature of the circle through point i and both neighbours; 0 where there are not both.
  double curvature(int i) const;

  /// Where points run to and fro and their known noise is more than neighbours tell, a tremor,
  /// means of neighbours tell corners. Throws InputError as fit_points() says.
  PointSequence(const std::string& name, const std::vector<Vec3>& given, double corner_angle,
                const std::optional<std::vector<int>>& given_corners, std::optional<bool> is_closed,
                Outliers outliers = Outliers::Keep, const NoiseLevel& known = {});

 private:
  int block_size(const NoiseLevel& known) const;
  void reject_outliers(const std::optional<std::vector<int>>& given_corners);
};

/// Throws InputError when it is not a length above 0.
void check_tolerance(const std::string& name, double tolerance);
/// fit_points() of a row; parameters are those of its points.
CurveFit fit_point_sequence(const std::string& name, PointSequence sequence,
                            const FitOptions& options);

/// How far the curve may be from a chord between two points: as far as the tallest arc between
/// them, and half as much again, for it may bend more there. `curvature`: the larger of the curvatures
/// at both points.
double sagitta_bound(double chord, double curvature);
/// The curve is looked at in so many equal parts of every gap.
constexpr int kSamplesPerGap = 8;
/// Deviation::between at one place of one gap: by how much `x` is farther from the chord a b than
/// `sagitta`.
double chord_excess(const Vec3& x, const Vec3& a, const Vec3& b, double sagitta);

/// Deviation of a curve from a row whose point i belongs to parameter t[i].
Deviation deviation_of(const HermiteCurve& curve, const PointSequence& sequence,
                       const std::vector<double>& t);


// Inside of fair_points: where the faired curve has nodes.

struct KnotPlacement {
  CurveMesh mesh;                ///< over [0, length]
  std::vector<int> corner_node;  ///< of each corner of the row
};

/// A node at every parameter of `forced`, and at every point that is not too near to another node:
/// of more than `max_knots` points at every second, or third, …; of fewer half way between, too.
/// u: of the points, in [0, length]. Where the curve is `mirrored`, its second half has the mirror
/// images of the nodes of the first.
KnotPlacement place_knots(const PointSequence& sequence, const std::vector<double>& u,
                          double length, std::vector<double> forced, bool mirrored, int max_knots);

}  // namespace batten
