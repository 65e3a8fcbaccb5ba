// Writes surfaces as VTK's files, for ParaView and other programs that read them.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "batten/skinning/region/skinned_region.h"
#include "batten/skinning/surfaces/surface_model.h"
#include "batten/mesh/shell_mesh.h"

template <class T>
class vtkSmartPointer;
class vtkPolyData;

namespace batten {

/// A line of a model of several regions.
struct VtkLine {
  std::string name;
  /// ModelJoin::Kind as a number: 0 rim, 1 crease, 2 smooth, 3 branching; -1 for a line inside of a
  /// region.
  int join = -1;
  double angle_deg = 0;  ///< largest angle between the normals across it
};

/// The lines of a network that its regions have: those of loops, then inner ones.
std::vector<VtkLine> vtk_lines(const CurveNetwork& network, const SurfaceModel& model);

/// Further data of points: a name, so many numbers, and their values at places of a region's mesh.
/// It is asked on several threads.
struct VtkField {
  std::string name;
  int components = 1;
  std::function<VecX(int region, const Location& where)> at;
};

struct VtkOptions {
  /// Surfaces from which displacements are measured: none, or one for each region, on the same
  /// mesh.
  std::vector<const Surface*> references;
  /// Facets along each edge of an element or, in a region with embedded lines, of its
  /// quadratic_elements; VTP only. 0: 4, or fewer so that there are at most 400,000 facets.
  int facets_per_edge = 0;
  bool curvatures = true;  ///< whether the arrays of curvatures are written
  std::vector<VtkField> fields = {};
  /// The lines of a model, each written once, from the first region that has a line of its name.
  /// None: the lines of each region are written.
  std::vector<VtkLine> lines = {};
};

/// The regions as facets, and their character lines as polylines through the same points. Facets
/// end exactly at embedded boundaries (skinning/facets/facets.h); regions that share such a line
/// share its points there.
///
///   point data  Normals (unit, exact, x_u × x_v; zero where the surface is singular),
///               Mean_curvature, Gauss_curvature, K1 ≥ K2 (recovered_curvatures), uv (u, v, 0),
///               Displacement (with references), and options.fields
///   cell data   Region (index), Triangle (element of the region, -1 on lines), Line (index, -1 on
///               facets); with options.lines also Join (VtkLine::join) and Join_angle (degrees),
///               both -1 on facets
///   field data  Region_names, Line_names (text; runs and embedded lines, region after region; or
///               those of options.lines)
///
/// Along a line that regions share, each has points of its own at the same places, because normals,
/// curvatures and u, v belong to the region.
///
/// Cells are in VTK's order: first the lines, then the facets. Points are doubles. O(facets).
/// Throws InputError: no region, references that do not match, and what facets() throws.
vtkSmartPointer<vtkPolyData> to_poly_data(const std::vector<const SkinnedRegion*>& regions,
                                          const VtkOptions& options = {});

/// Writes to_poly_data() as a .vtp file: XML, binary appended, compressed. It appears whole or not
/// at all. The same regions give the same bytes. Throws InputError as to_poly_data() does, and when
/// the file cannot be written.
void write_vtp(const std::filesystem::path& path, const std::vector<const SkinnedRegion*>& regions,
               const VtkOptions& options = {});

/// Writes the finite elements as a .vtu file: one VTK_QUADRATIC_TRIANGLE for each element, in their
/// order (nodes: vertices, then the surface's points at the parametric midpoints of the edges 12,
/// 23, 31), then one VTK_QUADRATIC_EDGE for each element edge of a line. The data are those of
/// to_poly_data(). A region with embedded lines has its quadratic_elements as elements; Triangle is
/// the element at their middles. Throws InputError as write_vtp().
void write_vtu(const std::filesystem::path& path, const std::vector<const SkinnedRegion*>& regions,
               const VtkOptions& options = {});

}  // namespace batten

// Writes VTK's XML files. Internal.

class vtkDataObject;
class vtkXMLWriter;

namespace batten {

/// Writes `data` with the writer: binary appended, compressed. The file appears whole or not at
/// all. Throws InputError when it cannot be written.
void write_vtk_xml(vtkXMLWriter& writer, vtkDataObject* data, const std::filesystem::path& path);


// Writes series of VTK files: one shape for each value of a parameter, or for each moment.

/// One file of a series and the number that it stands for, which ParaView shows as its time.
struct SeriesFile {
  double value = 0;
  std::string file;  ///< path relative to the .pvd file
};

/// Writes a .pvd file, by which ParaView opens and plays the whole series. Values have all their
/// digits. The file appears whole or not at all. Throws InputError: no files, values that are not
/// finite or do not ascend or descend strictly (ParaView would merge or reorder them), a file that
/// cannot be written.
void write_pvd(const std::filesystem::path& path, const std::vector<SeriesFile>& files);

}  // namespace batten

// Writes deformed shell meshes as VTK's files.

template <class T>
class vtkSmartPointer;
class vtkPolyData;

namespace batten {

/// What a deformation did to each of the n nodes.
struct DeformedData {
  Points displacement;       ///< displacement of each node, n×3
  std::vector<int> feature;  ///< index of each node's feature in feature_names, -1 for none
  std::vector<std::string> feature_names;
};

/// The faces as polygons in VTK's data, in double precision. A face of second order is a polygon
/// through all its nodes, in the order in which they lie around it.
vtkSmartPointer<vtkPolyData> shell_poly_data(const ShellMesh& shells, const Points& points);

/// Writes the mesh, its nodes at `shells.points`, as a .vtp file with point data Displacement and
/// Feature and field data Feature_names. It appears whole or not at all. Throws InputError when it
/// cannot be written.
void write_deformed_vtp(const std::filesystem::path& path, const ShellMesh& shells,
                        const DeformedData& data);

}  // namespace batten
