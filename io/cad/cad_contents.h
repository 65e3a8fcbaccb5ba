// SPDX-License-Identifier: MPL-2.0
// Summary of a CAD file (product structure, names, colours, layers, unit, counts) and its triangle
// mesh.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/pn_triangle_mesh.h"
#include "batten/mesh/shell_mesh.h"
#include "batten/skinning/surfaces/fitted_primitive.h"

namespace batten {

/// One instance in the product structure: an assembly, a component of an assembly, or a shape
/// outside all assemblies. A product that is used three times is listed three times.
struct CadProduct {
  std::string name;           ///< name of the product; "" if the product has no name
  std::string instance_name;  ///< name of the instance if it differs from `name`; otherwise ""
  int level = 0;              ///< depth of the instance in the assembly tree; 0 at the top level
  bool assembly = false;
  /// Global position of the origin of the instance, in the unit of the file.
  Vec3 translation = Vec3::Zero();
  double rotation_deg = 0;  ///< rotation angle of the global placement, degrees, ≥ 0
  std::string colour;       ///< colour assigned to the instance, "#rrggbb"; "": none
  int solids = 0, faces = 0, curves = 0;  ///< numbers of shapes in a part; 0 for an assembly
};

/// A name, colour or layer that occurs in a CAD file, with the numbers of entities that have this
/// name, have this colour or are on this layer.
struct CadAttribute {
  std::string name;
  int products = 0;  ///< number of products on the layer; 0 for names and colours
  int solids = 0;    ///< number of solids and shells inside products
  int faces = 0;
  int edges = 0;   ///< number of edges that bound faces
  int curves = 0;  ///< number of edges that belong to no face
};

/// Summary of a CAD file. Lengths are in the unit of the file. Shapes are counted once per
/// instance.
struct CadContents {
  std::string format;            ///< format of the file: "STEP AP214", "IGES", "BREP", …
  double unit_in_metres = 1e-3;  ///< length unit of the file, in metres
  bool unit_stated = false;      ///< true if the file declares its unit
  std::vector<std::string> notes;
  std::vector<CadProduct> products;
  std::vector<CadAttribute> names;  ///< names of shapes other than products, in file order
  /// Colours ("#rrggbb") of faces and curves, including inherited colours.
  std::vector<CadAttribute> colours;
  std::vector<CadAttribute> layers;
  int solids = 0, shells = 0, faces = 0, edges = 0;
  int closed_shells = 0;  ///< number of shells without free edges
  int curves = 0;         ///< number of edges that belong to no face
  double area = 0;
  /// Uncertainty of `area` due to inexact trimming: the sum of length × tolerance over all edges.
  double trim_uncertainty_area = 0;
  double volume = 0;  ///< total volume of all solids, in the cubed unit of the file
  double size = 0;    ///< diagonal of the bounding box of the model
};

// Triangle mesh of the faces of a CAD file.

/// A group of triangles: those of all CAD faces with the same name and colour.
struct FacetGroup {
  /// Name of the CAD faces; without a name, that of the solid or part, or else "part 1", "part 2" …
  std::string name;
  std::string colour;  ///< colour of the faces, "#rrggbb"; "": no colour
  std::vector<int> triangles;
};

/// Triangle mesh of all faces of a CAD file, with measures of its accuracy. Lengths are in the unit
/// that was requested for the mesh.
struct CadFacets {
  ShellMesh mesh;  ///< the triangles, oriented like the CAD faces (outwards on solids)
  /// Unit surface normals at the corners of each triangle; empty unless curved triangles were
  /// requested.
  std::vector<PnTriangle::Corners> normals;
  std::vector<int> faces;  ///< 0-based index of the CAD face of each triangle
  /// The primitive of each CAD face, Kind::Free if it has none; empty unless curved triangles were
  /// requested.
  std::vector<FittedPrimitive> primitives;
  /// For each CAD face, 1 if it lies on a surface of revolution or an extruded surface, else 0; empty
  /// as `primitives`.
  std::vector<char> swept;
  std::vector<FacetGroup> groups;
  CadContents contents;  ///< summary of the CAD file, in the unit of the file
  double unit_in_metres = 1e-3;
  double size = 0, chord = 0;
  /// Largest measured distance between the mesh and the CAD model. The distance is measured from
  /// seven points of each triangle (of the curved triangle, if requested) to the CAD face, and at
  /// three points per chord along each CAD edge.
  double deviation = 0;
  int shells = 0;      ///< number of shells (connected sets of CAD faces) after sewing
  int free_edges = 0;  ///< number of mesh edges with one triangle on free CAD edges
  int cracks = 0;      ///< number of mesh edges with one triangle elsewhere; should be 0
  int unmeshed = 0;    ///< number of CAD faces that could not be meshed
};

}  // namespace batten
