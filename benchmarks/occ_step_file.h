// SPDX-License-Identifier: MPL-2.0
// Wrapper of OpenCASCADE's STEP reader without OpenCASCADE types in its interface: a cross-check of
// the contents of a file, and the peer that writes the same shape as facets or as it was read.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten::bench {

class OccStepFile {
 public:
  /// Reads a file into model units. faces() is 0 if it cannot be read, or in a build without
  /// OpenCASCADE.
  OccStepFile(const std::string& file, double unit_in_metres);
  ~OccStepFile();
  int faces() const;
  bool valid() const;
  /// Points of a face: those of n × n over its parameter rectangle that are inside its trim.
  std::vector<Vec3> points(int face, int n) const;
  /// Its boundary, n points along the pcurve of each edge.
  std::vector<Vec3> rim(int face, int n) const;
  /// Writes the model that was read, as OpenCASCADE's own converters do.
  bool write(const std::string& file) const;

  /// Triangles of OpenCASCADE's mesher within a distance of the faces.
  struct Facets {
    std::vector<Vec3> points;
    std::vector<std::array<int, 3>> triangles;
  };
  Facets facets(double distance) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Writes triangles as a STEP file of planar faces with shared edges: a faceted solid.
bool write_facetted(const std::string& file, const OccStepFile::Facets& facets,
                    double unit_in_metres);

}  // namespace batten::bench
