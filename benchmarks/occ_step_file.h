// A STEP file as OpenCASCADE reads it, behind an interface that names none of its types: the witness of
// what is in a file, and the peer that writes the same shape as facets, or as it read it.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten::bench {

class OccStepFile {
 public:
  /// Reads a file into model units. faces() is 0 where it cannot be read, or in a build without
  /// OpenCASCADE.
  OccStepFile(const std::string& file, double unit_in_metres);
  ~OccStepFile();
  int faces() const;
  bool valid() const;
  /// Points of a face: those of n × n over its box of parameters that are inside of its trim.
  std::vector<Vec3> points(int face, int n) const;
  /// Its rim and n points along each edge's line on the face.
  std::vector<Vec3> rim(int face, int n) const;
  /// Writes what was read, as OpenCASCADE's own converters do.
  bool write(const std::string& file) const;

  /// Triangles within a distance of the faces, as OpenCASCADE's mesher makes them.
  struct Facets {
    std::vector<Vec3> points;
    std::vector<std::array<int, 3>> triangles;
  };
  Facets facets(double distance) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Writes triangles as a STEP file, a plane face each, with common edges: what a facetted solid is.
bool write_facetted(const std::string& file, const OccStepFile::Facets& facets,
                    double unit_in_metres);

}  // namespace batten::bench
