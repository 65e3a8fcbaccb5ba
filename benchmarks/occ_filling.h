// OpenCASCADE's filling of a closed loop of cubics, behind an interface that names none of its
// types. Without OpenCASCADE occ_version() is "".
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten::bench {

std::string occ_version();

using Cubic = std::array<Vec3, 4>;  ///< Bézier control points

inline Vec3 cubic_point(const Cubic& c, double t) {
  const double s = 1 - t;
  return s * s * s * c[0] + 3 * s * s * t * c[1] + 3 * s * t * t * c[2] + t * t * t * c[3];
}

/// BRepOffsetAPI_MakeFilling's settings; everything else stays at its default.
struct FillingSettings {
  std::string name;
  double tolerance = 1e-4;   ///< Tol3d
  int points_on_curve = 15;  ///< NbPtsOnCur
  int max_segments = 9;      ///< MaxSegments; MaxDeg is 8
};

/// One face over `outline` (head to tail) through `inner` curves, C0.
class Filling {
 public:
  Filling(const std::vector<Cubic>& outline, const std::vector<Cubic>& inner,
          const FillingSettings& settings);
  ~Filling();
  bool done() const;
  /// From p to the nearest point of the face's surface.
  double distance(const Vec3& p) const;
  /// Points of the surface along the face's boundary.
  std::vector<Vec3> boundary_points(int an_edge) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten::bench
