// SPDX-License-Identifier: MPL-2.0
// Wrapper of OpenCASCADE's filling of closed loops of curves without OpenCASCADE types in its
// interface. Without OpenCASCADE, occ_version() is "".
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/fem/curves/hermite_curve.h"
#include "cases.h"

namespace batten::bench {

std::string occ_version();

/// Settings of BRepOffsetAPI_MakeFilling; all others have their defaults.
struct OccFillingSettings {
  std::string name;
  double tolerance = 1e-4;   ///< Tol3d
  int points_on_curve = 15;  ///< NbPtsOnCur
  int max_segments = 9;      ///< MaxSegments; MaxDeg is 8
};

/// One C0 face over `outline` (head to tail) through `inner` curves.
class OccFilling {
 public:
  OccFilling(const std::vector<Cubic>& outline, const std::vector<Cubic>& inner,
             const OccFillingSettings& settings);
  /// Faces over loops of curves without inner corners (C1 cubic B-splines), each loop head to tail.
  OccFilling(const std::vector<std::vector<HermiteCurve>>& loops,
             const std::vector<HermiteCurve>& inner, const OccFillingSettings& settings);
  ~OccFilling();
  bool done() const;
  /// OpenCASCADE's message after a failure, or "".
  const std::string& error_message() const;
  /// Distance from p to the face's surface.
  double distance(const Vec3& p) const;
  /// Points of the surface along the boundary of the face.
  std::vector<Vec3> boundary_points(int an_edge) const;
  /// Points of the face: those of n × n over its parameter rectangle that are inside.
  std::vector<Vec3> points(int n) const;
  /// Number of poles of the B-spline surface, u times v.
  std::array<int, 2> poles() const;
  /// Writes the face as a STEP file in millimetres. False in a build without OpenCASCADE's data
  /// exchange.
  bool write_step(const std::string& file) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten::bench
