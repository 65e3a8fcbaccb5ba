// OpenCASCADE's filling of closed loops of curves, behind an interface that names none of its
// types. Without OpenCASCADE occ_version() is "".
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/fem/curves/hermite_curve.h"
#include "cases.h"

namespace batten::bench {

std::string occ_version();

/// BRepOffsetAPI_MakeFilling's settings; everything else stays at its default.
struct OccFillingSettings {
  std::string name;
  double tolerance = 1e-4;   ///< Tol3d
  int points_on_curve = 15;  ///< NbPtsOnCur
  int max_segments = 9;      ///< MaxSegments; MaxDeg is 8
};

/// One face over `outline` (head to tail) through `inner` curves, C0.
class OccFilling {
 public:
  OccFilling(const std::vector<Cubic>& outline, const std::vector<Cubic>& inner,
             const OccFillingSettings& settings);
  /// Over loops of curves without corners inside (C1 cubic B-splines), each loop head to tail.
  OccFilling(const std::vector<std::vector<HermiteCurve>>& loops,
             const std::vector<HermiteCurve>& inner, const OccFillingSettings& settings);
  ~OccFilling();
  bool done() const;
  /// What OpenCASCADE had to say when it failed, or "".
  const std::string& error_message() const;
  /// From p to the nearest point of the face's surface.
  double distance(const Vec3& p) const;
  /// Points of the surface along the face's boundary.
  std::vector<Vec3> boundary_points(int an_edge) const;
  /// Points of the face: those of n × n over its box of parameters that are inside.
  std::vector<Vec3> points(int n) const;
  /// Poles of the B-spline surface, u times v.
  std::array<int, 2> poles() const;
  /// The face as a STEP file of millimetres. False in a build without OpenCASCADE's data exchange.
  bool write_step(const std::string& file) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten::bench
