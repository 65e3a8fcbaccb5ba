// Triangles of CAD faces, and what was measured on them.
#pragma once

#include <string>
#include <vector>

#include "batten/io/cad/cad_contents.h"
#include "batten/mesh/pn_triangle.h"
#include "batten/mesh/shell_mesh.h"

namespace batten {

/// The triangles of the faces that have this name and colour.
struct FacetGroup {
  std::string name;    ///< of the faces, else of their solid, of their part, "part 1" …
  std::string colour;  ///< "#rrggbb"; "" for none
  std::vector<int> triangles;
};

/// Triangles of all faces of a file, and what was measured on them. Lengths are in the unit asked
/// for.
struct CadFacets {
  ShellMesh mesh;  ///< triangles; normals outwards where the file's faces have them so
  /// Where curved ones were asked for: the faces' unit normals at the corners of each triangle.
  std::vector<PnTriangle::Corners> normals;
  std::vector<int> faces;  ///< the face of each triangle, numbered from 0
  std::vector<FacetGroup> groups;
  CadContents contents;  ///< of the file, in its own unit
  double unit_in_metres = 1e-3;
  double size = 0, chord = 0;
  /// Largest distance found: of seven points of each triangle, curved where these were asked for, from
  /// its face's surface, and of three points of an edge's curve from each chord along it.
  double deviation = 0;
  int shells = 0;      ///< what hangs together by edges, in the file once its faces are sewn
  int free_edges = 0;  ///< edges of one triangle: along the rims of open shapes
  int cracks = 0;      ///< those elsewhere: there should be none
  int unmeshed = 0;    ///< faces that got no triangle
};

}  // namespace batten
