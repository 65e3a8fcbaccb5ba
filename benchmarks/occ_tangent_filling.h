// SPDX-License-Identifier: MPL-2.0
// OpenCASCADE's filling of a hole in a given face, tangent to the face or with its curvature
// (BRepOffsetAPI_MakeFilling, the plate surfaces of GeomPlate; FreeCAD's Surface_Filling calls the
// same function). No OpenCASCADE types in the interface.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten::bench {

/// One face that fills a hole.
class OccTangentFilling {
 public:
  /// `grid`: points of the given surface, `columns` per row, which a bicubic spline interpolates.
  /// `sides`: points along the sides of the hole on this surface, in order. `order`: 0, 1 or 2 for
  /// G0, G1, G2.
  OccTangentFilling(const std::vector<Vec3>& grid, int columns,
                    const std::vector<std::vector<Vec3>>& sides, int order);
  ~OccTangentFilling();
  /// OpenCASCADE's message after a failure, or "". All else requires success.
  const std::string& error_message() const;
  /// Points of the face inside its boundary, of n × n over its parameter rectangle.
  std::vector<Vec3> points(int n) const;
  /// Largest and mean angle, degrees, between the face and the given one, along the sides.
  double max_deg() const;
  double mean_deg() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten::bench
