// SPDX-License-Identifier: MPL-2.0
// Writes surfaces, deformed shell meshes and time series as VTK files, for example for ParaView.
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

/// A curve of a model, as it is written to VTK files.
struct VtkLine {
  std::string name;
  /// Type of edge that the curve forms (ModelJoin::Kind): 0 free edge, 1 crease, 2 smooth edge, 3
  /// non-manifold edge; -1: curve inside a face.
  int join = -1;
  double angle_deg = 0;  ///< largest angle between the normals of the adjacent faces, degrees
};

/// Lists the curves of a network that bound or cross faces of the model: boundary curves first,
/// then curves inside faces.
std::vector<VtkLine> vtk_lines(const CurveNetwork& network, const SurfaceModel& model);

/// An additional point-data array of VTK files: name, number of components, and a function that
/// evaluates it at a location in the mesh of a face. The function is called from several threads.
struct VtkField {
  std::string name;
  int components = 1;
  std::function<VecX(int region, const Location& where)> at;
};

/// Options for converting faces to VTK data and for writing .vtp and .vtu files.
struct VtkOptions {
  /// Reference surfaces, one per face and on the mesh of the face, from which the array
  /// Displacement is computed. Empty: no array Displacement.
  std::vector<const Surface*> references;
  /// VTP only: number of facets along each element edge (in a face with embedded curves, along each
  /// edge of its quadratic_elements()). 0: four, or fewer if there would be more than 400,000
  /// facets.
  int facets_per_edge = 0;
  bool curvatures = true;  ///< true: write the mean, Gaussian and principal curvatures
  std::vector<VtkField> fields = {};
  /// The curves to write. Each curve is written once, from the first face that contains a curve of
  /// this name. Empty: all curves of each face are written.
  std::vector<VtkLine> lines = {};
};

/// Converts faces of a model to flat facets, and the curves of the faces to polylines through facet
/// vertices. Facets end exactly at embedded boundary curves (skinning/facets/facets.h). Faces that
/// share such a curve have coincident points on it.
///
///   point data  Normals (exact unit normals x_u × x_v; zero where the surface is singular),
///               Mean_curvature, Gauss_curvature, K1 ≥ K2 (recovered_curvatures()), uv (u, v, 0),
///               Displacement (if there are references), and the arrays of options.fields
///   cell data   Face (index), Triangle (index of the element in its face; -1 on curves), Curve
///               (index; -1 on facets); if options.lines is set, also Join (VtkLine::join) and
///               Join_angle (degrees), both -1 on facets
///   field data  Face_names and Curve_names (text). Curve_names contains the edge-aligned and
///               embedded curves of each face in turn, or the names of options.lines.
///
/// The faces have separate, coincident points along a shared curve, because normals, curvatures and
/// u, v differ between faces.
///
/// Cells have VTK's order: curves, then facets. Coordinates are doubles. O(facets). Throws
/// InputError if there is no face, a reference does not match its face, or facets() fails.
vtkSmartPointer<vtkPolyData> to_poly_data(const std::vector<const SkinnedRegion*>& regions,
                                          const VtkOptions& options = {});

/// Writes faces of a model, as converted by to_poly_data(), to a .vtp file (XML with compressed,
/// appended binary data). The file is written atomically, and the same input always gives the same
/// bytes. Throws InputError as to_poly_data() does, and if the file cannot be written.
void write_vtp(const std::filesystem::path& path, const std::vector<const SkinnedRegion*>& regions,
               const VtkOptions& options = {});

/// Writes the finite elements of faces of a model to a .vtu file. Each element becomes a
/// VTK_QUADRATIC_TRIANGLE, in the order of the mesh, with its vertices 1, 2, 3 as nodes, followed
/// by the surface points at the parametric midpoints of the edges 12, 23, 31. Each element edge on
/// a curve becomes a VTK_QUADRATIC_EDGE. The data arrays are those of to_poly_data(). A face with
/// embedded curves is written as its quadratic_elements(); the array Triangle then gives the mesh
/// element at the centre of each quadratic element. Throws InputError as write_vtp() does.
void write_vtu(const std::filesystem::path& path, const std::vector<const SkinnedRegion*>& regions,
               const VtkOptions& options = {});

}  // namespace batten

// Writes VTK XML files.

class vtkDataObject;
class vtkXMLWriter;

namespace batten {

/// Makes the filters of VTK use only the thread that calls them, for the whole process. They fail
/// if the system does not provide their threads, and in a forked process wait for them.
void use_vtk_on_calling_thread();

/// Writes a VTK data object to a file with the given writer, atomically, as XML with compressed,
/// appended binary data. Throws InputError if the file cannot be written.
void write_vtk_xml(vtkXMLWriter& writer, vtkDataObject* data, const std::filesystem::path& path);

// Time series of VTK files.

/// One file of a series of VTK files, and the value of the file (a time or a parameter value),
/// which ParaView shows as the time.
struct SeriesFile {
  double value = 0;
  std::string file;  ///< path relative to the folder of the .pvd file
};

/// Writes a .pvd file, which lists the files of a series of VTK files and their values; ParaView
/// opens it as an animation. Values are written with full precision. The file is written
/// atomically. Throws InputError if there are no files, if values are not finite or not strictly
/// monotonic (ParaView would merge or reorder them), or if the file cannot be written.
void write_pvd(const std::filesystem::path& path, const std::vector<SeriesFile>& files);

}  // namespace batten

// VTK files of deformed shell meshes.

template <class T>
class vtkSmartPointer;
class vtkPolyData;

namespace batten {

/// Displacement and feature of each of the n nodes of a deformed mesh.
struct DeformedData {
  Points displacement;       ///< displacement vector of each node, n×3
  std::vector<int> feature;  ///< index in feature_names of the feature of each node; -1: none
  std::vector<std::string> feature_names;
};

/// Converts shell elements to VTK polygons with node positions `points`, in double precision. A
/// second-order element becomes a polygon through all its nodes, in cyclic order.
vtkSmartPointer<vtkPolyData> shell_poly_data(const ShellMesh& shells, const Points& points);

/// Writes a deformed mesh with the node positions `shells.points` to a .vtp file, with the point
/// data Displacement and Feature and the field data Feature_names. The file is written atomically.
/// Throws InputError if the file cannot be written.
void write_deformed_vtp(const std::filesystem::path& path, const ShellMesh& shells,
                        const DeformedData& data);

}  // namespace batten
