// Writes surfaces, deformed shell meshes and time series as VTK files, for ParaView and other
// programs.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "batten/mesh/shell_mesh.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/skinning/surfaces/surface_model.h"

template <class T>
class vtkSmartPointer;
class vtkPolyData;

namespace batten {

/// A curve of a model with several faces.
struct VtkLine {
  std::string name;
  /// ModelJoin::Kind as a number: 0 free edge, 1 crease, 2 smooth, 3 branching (non-manifold); -1
  /// for a curve inside a face.
  int join = -1;
  double angle_deg = 0;  ///< largest angle between the surface normals across the curve, degrees
};

/// Lists the curves of a network that the model's faces use: boundary curves first, then inner
/// curves.
std::vector<VtkLine> vtk_lines(const CurveNetwork& network, const SurfaceModel& model);

/// An additional point data array: name, number of components, and a function that evaluates it at
/// a location in a face's mesh. The function is called from several threads.
struct VtkField {
  std::string name;
  int components = 1;
  std::function<VecX(int region, const Location& where)> at;
};

/// Options of to_poly_data(), write_vtp() and write_vtu().
struct VtkOptions {
  /// Reference surfaces from which displacements are measured: none, or one per face, on the same
  /// mesh.
  std::vector<const Surface*> references;
  /// Number of facets along each element edge; in a face with embedded curves, along each edge of
  /// its quadratic_elements(). VTP only. 0: 4, or fewer to keep the total at 400,000 facets or
  /// less.
  int facets_per_edge = 0;
  bool curvatures = true;  ///< write the curvature arrays
  std::vector<VtkField> fields = {};
  /// The curves of a model. Each is written once, from the first face that has a curve of its name.
  /// Empty: all curves of each face are written.
  std::vector<VtkLine> lines = {};
};

/// Converts faces to facets, and their curves to polylines through the same points.
/// Facets end exactly at embedded boundaries (skinning/facets/facets.h). Faces that share such a
/// curve have the same points on it.
///
///   point data  Normals (unit, exact, x_u × x_v; zero where the surface is singular),
///               Mean_curvature, Gauss_curvature, K1 ≥ K2 (recovered_curvatures), uv (u, v, 0),
///               Displacement (with references), and options.fields
///   cell data   Face (index), Triangle (element of the face, -1 on curves), Curve (index, -1 on
///               facets); with options.lines also Join (VtkLine::join) and Join_angle (degrees),
///               both -1 on facets
///   field data  Face_names, Curve_names (text; edge-aligned and embedded curves, face after face;
///               or those of options.lines)
///
/// Along a shared curve, each face has its own coincident points, because normals, curvatures and
/// u, v belong to the face.
///
/// Cells are in VTK's order: first the curves, then the facets. Coordinates are doubles. O(facets).
/// Throws InputError: no face, references that do not match, and the errors of facets().
vtkSmartPointer<vtkPolyData> to_poly_data(const std::vector<const SkinnedRegion*>& regions,
                                          const VtkOptions& options = {});

/// Writes to_poly_data() as a .vtp file: XML, binary appended, compressed, written atomically. The
/// output is reproducible bit by bit. Throws InputError as to_poly_data() does, and if the file
/// cannot be written.
void write_vtp(const std::filesystem::path& path, const std::vector<const SkinnedRegion*>& regions,
               const VtkOptions& options = {});

/// Writes the finite elements as a .vtu file. Each element becomes a VTK_QUADRATIC_TRIANGLE, in
/// order. Its nodes are the vertices, then the surface points at the parametric midpoints of the
/// edges 12, 23, 31. Each element edge on a curve becomes a VTK_QUADRATIC_EDGE. The data arrays are
/// those of to_poly_data(). In a face with embedded curves, the elements are its
/// quadratic_elements(), and Triangle is the mesh element at their centre. Throws InputError as
/// write_vtp().
void write_vtu(const std::filesystem::path& path, const std::vector<const SkinnedRegion*>& regions,
               const VtkOptions& options = {});

}  // namespace batten

// Writes VTK XML files.

class vtkDataObject;
class vtkXMLWriter;

namespace batten {

/// Writes `data` with the given writer: binary appended, compressed, atomically. Throws InputError
/// if the file cannot be written.
void write_vtk_xml(vtkXMLWriter& writer, vtkDataObject* data, const std::filesystem::path& path);

// Time series of VTK files.

/// One file of a series, with its parameter value or time, which ParaView shows as its time.
struct SeriesFile {
  double value = 0;
  std::string file;  ///< path relative to the .pvd file
};

/// Writes a .pvd file, with which ParaView opens and plays the series. Values are written with full
/// precision. The file is written atomically. Throws InputError: no files, values that are not
/// finite or not strictly monotonic (ParaView would merge or reorder them), a file that cannot be
/// written.
void write_pvd(const std::filesystem::path& path, const std::vector<SeriesFile>& files);

}  // namespace batten

// Writes deformed shell meshes.

template <class T>
class vtkSmartPointer;
class vtkPolyData;

namespace batten {

/// Result of a deformation for each of the n nodes.
struct DeformedData {
  Points displacement;       ///< displacement of each node, n×3
  std::vector<int> feature;  ///< index into feature_names for each node; -1 for none
  std::vector<std::string> feature_names;
};

/// Converts the shell elements to VTK polygons, in double precision. A second-order element becomes
/// a polygon through all its nodes, in cyclic order.
vtkSmartPointer<vtkPolyData> shell_poly_data(const ShellMesh& shells, const Points& points);

/// Writes the mesh with its nodes at `shells.points` as a .vtp file, with point data Displacement
/// and Feature and field data Feature_names. The file is written atomically. Throws InputError if
/// it cannot be written.
void write_deformed_vtp(const std::filesystem::path& path, const ShellMesh& shells,
                        const DeformedData& data);

}  // namespace batten
