// A piecewise cubic Hermite curve in space.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Nodes at parameters u_0 < u_1 < … with position and derivative dX/du: C1 everywhere.
/// u is in model units when the curve was fitted by arc length.
class HermiteCurve {
 public:
  struct Closest {
    double u = 0;
    double distance = 0;
  };

  HermiteCurve() = default;
  /// Throws InputError: fewer than two nodes, parameters not strictly increasing, numbers not
  /// finite, counts that differ.
  HermiteCurve(std::vector<double> parameters, Points positions, Points derivatives);

  int node_count() const { return static_cast<int>(parameters_.size()); }
  const std::vector<double>& parameters() const { return parameters_; }
  const Points& positions() const { return positions_; }
  const Points& derivatives() const { return derivatives_; }
  double start() const { return parameters_.front(); }
  double end() const { return parameters_.back(); }

  /// Position (order 0) or derivative of order 1 to 3 with respect to u. u is clamped to the curve;
  /// at a node, the segment that begins there answers.
  Vec3 evaluate(double u, int order = 0) const;
  /// 1/length; 0 on a straight piece.
  double curvature(double u) const;
  double length() const;
  /// The nearest point of the curve. O(segments), about 1e-12 of the curve's size.
  Closest closest_point(const Vec3& p) const;

 private:
  int segment(double u) const;
  std::vector<double> parameters_;
  Points positions_, derivatives_;
};

}  // namespace batten
