// OpenCASCADE as a peer for lofts: surfaces of CAD files, sections cut from them, and what
// BRepOffsetAPI_ThruSections makes of the sections.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten::bench {

/// One face of an IGES file. Without OpenCASCADE there are none.
class IgesFace {
 public:
  static std::vector<IgesFace> read(const std::filesystem::path& file);
  Vec3 low() const;  ///< the corners of its box
  Vec3 high() const;
  /// Points of the section at x, evenly by length from one end to the other; none where it is not
  /// one open curve.
  std::vector<Vec3> section(double x, int count) const;
  double distance(const Vec3& p) const;

  struct Data;

 private:
  std::shared_ptr<Data> data_;
};

/// Points of the loft through interpolated sections, n by n on each of its faces; none where it
/// fails. Sections whose first point is repeated at the end are closed wires.
std::vector<Vec3> loft_points(const std::vector<std::vector<Vec3>>& sections, int n);

}  // namespace batten::bench
