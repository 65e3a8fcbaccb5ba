// SPDX-License-Identifier: MPL-2.0
// A scalar field that a file gives at points, such as a pressure of a flow simulation.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "batten/core/eigen.h"

namespace batten {

/// Values at the points of a table, or on the cells of a VTK file, evaluated at the closest point:
///
///     .csv .txt .dat     the value of the nearest point. A header names the columns: x, y and z (or
///                        Points:0, Points:1, Points:2 as ParaView writes them) and the values; units
///                        in brackets are ignored. Without a header, there are four columns
///     .vtu .vtp .vtk     the value at the closest point of the cells, interpolated between their nodes
///                        (point data), or that of the cell (cell data); without cells as in a table
///
/// Copies share their data. at() may be called by one thread at a time.
class PointField {
 public:
  /// `array`: name of the column or data array; empty: the only one. Throws InputError for a file that
  /// cannot be read, an array that does not exist or is no scalar, and numbers that are not finite.
  PointField(const std::filesystem::path& file, const std::string& array);

  /// The value at the closest point. Throws InputError if x is outside of the bounding box of the field
  /// by more than a tenth of its size.
  double at(const Vec3& x) const;
  /// Diagonal of the bounding box.
  double size() const;

 private:
  class Data;
  std::shared_ptr<Data> data_;
};

}  // namespace batten
