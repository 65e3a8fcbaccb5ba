// SPDX-License-Identifier: MPL-2.0
// Wrapper of OpenCASCADE's approximation of points by a B-spline without OpenCASCADE types in its
// interface. Without OpenCASCADE, occ_curves_version() is "".
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten::bench {

std::string occ_curves_version();

/// Settings of GeomAPI_PointsToBSpline; parameters by chord length, its default.
struct OccCurveFitSettings {
  double tolerance = 1e-3;  ///< Tol3D
  int degree = 3;           ///< DegMin and DegMax; variational: DegMax
  int continuity = 2;       ///< C1 or C2
  /// For the smoothing constructor: its weights of length, curvature and torsion.
  bool variational = false;
  double weights[3] = {1, 1, 1};
};

class OccCurveFit {
 public:
  OccCurveFit(const std::vector<Vec3>& points, const OccCurveFitSettings& settings);
  ~OccCurveFit();
  OccCurveFit(OccCurveFit&&) noexcept;
  /// Also false if OpenCASCADE throws.
  bool done() const;
  std::vector<double> knots() const;
  Vec3 evaluate(double u, int order) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten::bench
