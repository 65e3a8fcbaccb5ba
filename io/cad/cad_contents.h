// What is in a CAD file: products and their places, names, colours, layers, unit, counts.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/pn_triangle_mesh.h"
#include "batten/mesh/shell_mesh.h"

namespace batten {

/// One place of a product: an assembly, a part of it, or a shape that stands alone. A product that
/// is used three times is there three times.
struct CadProduct {
  std::string name;           ///< of the product; "" for none
  std::string instance_name;  ///< the name of this instance where it has another one
  int level = 0;              ///< how deep it is in the assembly, 0 at the top
  bool assembly = false;
  Vec3 translation = Vec3::Zero();        ///< where its origin lies in the whole, the file's unit
  double rotation_deg = 0;                ///< by how much it is turned in the whole
  std::string colour;                     ///< its own, "#rrggbb"; "" for none
  int solids = 0, faces = 0, curves = 0;  ///< 0 of an assembly
};

/// A name, colour or layer, and what has it.
struct CadAttribute {
  std::string name;
  int products = 0;  ///< of a layer
  int solids = 0;    ///< solids and shells within a product
  int faces = 0;
  int edges = 0;   ///< edges of faces
  int curves = 0;  ///< edges that belong to no face
};

/// What is in a CAD file. Lengths are in the file's own unit; instances count each.
struct CadContents {
  std::string format;            ///< "STEP AP214", "IGES", "BREP", …
  double unit_in_metres = 1e-3;  ///< of the lengths in the file
  bool unit_stated = false;      ///< whether the file says it
  std::vector<std::string> notes;
  std::vector<CadProduct> products;
  std::vector<CadAttribute> names;    ///< of all but products, in the file's order
  std::vector<CadAttribute> colours;  ///< "#rrggbb" as faces and curves have it, own or inherited
  std::vector<CadAttribute> layers;
  int solids = 0, shells = 0, faces = 0, edges = 0;
  int closed_shells = 0;  ///< shells without a rim
  int curves = 0;         ///< edges that belong to no face
  double area = 0;
  double trim_uncertainty_area =
      0;              ///< lengths of edges times their tolerances: by so much trims are not known
  double volume = 0;  ///< of all solids, unit³
  double size = 0;    ///< diagonal of the box around all
};


// Triangles of CAD faces, and what was measured on them.

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
