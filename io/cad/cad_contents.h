// Summary of a CAD file (product structure, names, colours, layers, unit, counts) and its triangle
// mesh.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/pn_triangle_mesh.h"
#include "batten/mesh/shell_mesh.h"

namespace batten {

/// One instance in the product structure: an assembly, a part of one, or a free shape. A product
/// that is used three times is listed three times.
struct CadProduct {
  std::string name;           ///< product name; "" if it has none
  std::string instance_name;  ///< name of this instance if it differs from `name`, else ""
  int level = 0;              ///< depth in the assembly tree, 0 at the top
  bool assembly = false;
  Vec3 translation = Vec3::Zero();        ///< global position of its origin, in the file's unit
  double rotation_deg = 0;                ///< rotation angle of its global placement, ≥ 0
  std::string colour;                     ///< own colour as "#rrggbb"; "" if it has none
  int solids = 0, faces = 0, curves = 0;  ///< counts within the part; 0 for an assembly
};

/// A name, colour or layer, and the number of entities of each kind that have it.
struct CadAttribute {
  std::string name;
  int products = 0;  ///< products on this layer; used for layers only
  int solids = 0;    ///< solids and shells within a product
  int faces = 0;
  int edges = 0;   ///< edges of faces
  int curves = 0;  ///< edges that belong to no face
};

/// Summary of a CAD file. Lengths are in the file's own unit. Every instance of a shape is counted.
struct CadContents {
  std::string format;            ///< "STEP AP214", "IGES", "BREP", …
  double unit_in_metres = 1e-3;  ///< length unit of the file
  bool unit_stated = false;      ///< true if the file declares its unit
  std::vector<std::string> notes;
  std::vector<CadProduct> products;
  std::vector<CadAttribute> names;    ///< names of everything but products, in file order
  std::vector<CadAttribute> colours;  ///< "#rrggbb", own or inherited colours of faces and curves
  std::vector<CadAttribute> layers;
  int solids = 0, shells = 0, faces = 0, edges = 0;
  int closed_shells = 0;  ///< shells without free edges
  int curves = 0;         ///< edges that belong to no face
  double area = 0;
  /// Sum over all edges of length × edge tolerance: the uncertainty of `area` due to trimming.
  double trim_uncertainty_area = 0;
  double volume = 0;  ///< total volume of all solids, unit³
  double size = 0;    ///< diagonal of the bounding box
};

// Triangle mesh of the faces of a CAD file.

/// The triangles of all faces with the same name and colour.
struct FacetGroup {
  /// Name of the face, else of its solid, else of its part, else "part 1", "part 2" …
  std::string name;
  std::string colour;  ///< "#rrggbb"; "" if it has none
  std::vector<int> triangles;
};

/// Triangle mesh of all faces of a file, with quality measures. Lengths are in the requested unit.
struct CadFacets {
  ShellMesh mesh;  ///< triangles, oriented like the faces of the file (outwards for a solid)
  /// Unit surface normals at the corners of each triangle; only if curved triangles were requested.
  std::vector<PnTriangle::Corners> normals;
  std::vector<int> faces;  ///< 0-based face index of each triangle
  std::vector<FacetGroup> groups;
  CadContents contents;  ///< summary of the file, in its own unit
  double unit_in_metres = 1e-3;
  double size = 0, chord = 0;
  /// Largest measured distance between mesh and model. It is sampled at seven points per triangle
  /// (on the curved triangle if requested) against the surface of the face, and at three points per
  /// chord along each edge.
  double deviation = 0;
  int shells = 0;      ///< shells (connected sets of faces) of the file, after sewing
  int free_edges = 0;  ///< mesh edges with one triangle that lie on free edges of the model
  int cracks = 0;      ///< all other mesh edges with one triangle; should be 0
  int unmeshed = 0;    ///< faces that could not be meshed
};

}  // namespace batten
