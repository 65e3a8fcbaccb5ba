// SPDX-License-Identifier: MPL-2.0
// OpenCASCADE as a peer for lofts: faces of CAD files, sections cut from them, and lofts of the
// sections by BRepOffsetAPI_ThruSections.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten::bench {

/// One face of an IGES file; none without OpenCASCADE.
class IgesFace {
 public:
  static std::vector<IgesFace> read(const std::filesystem::path& file);
  Vec3 low() const;  ///< corners of its bounding box
  Vec3 high() const;
  /// Points of the section at x, uniform in arc length; none if it is not one open curve.
  std::vector<Vec3> section(double x, int count) const;
  double distance(const Vec3& p) const;

  struct Data;

 private:
  std::shared_ptr<Data> data_;
};

/// n × n points on each face of the loft through interpolated sections; none if it fails. Sections
/// whose first point is repeated at the end are closed wires.
std::vector<Vec3> loft_points(const std::vector<std::vector<Vec3>>& sections, int n);

}  // namespace batten::bench
