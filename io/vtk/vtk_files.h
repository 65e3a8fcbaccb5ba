// Surfaces as VTK's files, for ParaView and everything that reads them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/skinning/region/region.h"
#include "batten/skinning/surfaces/surface_model.h"

template <class T>
class vtkSmartPointer;
class vtkPolyData;

namespace batten {

/// A line of a model of several regions.
struct VtkLine {
  std::string name;
  /// ModelJoin::Kind as a number: 0 rim, 1 crease, 2 smooth, 3 branching; -1: inside of a region.
  int join = -1;
  double angle_deg = 0;  ///< largest angle between the normals across it
};

/// The lines of a network that its regions have: of loops, then inner ones.
std::vector<VtkLine> vtk_lines(const CharacterLineNetwork& network, const SurfaceModel& model);

struct VtkOptions {
  /// Surfaces that displacements are measured from: none, or one for each region, on the same mesh.
  std::vector<const Surface*> references;
  /// Facets along each edge of elements (of a region with embedded lines: of its own triangles,
  /// quadratic_facets), 1 or more (VTP only). 0: 4, or fewer, so that it stays at 400,000 facets.
  int facets_per_edge = 0;
  bool curvatures = true;  ///< false: without the arrays of curvatures
  /// Of a model: each of these lines is written once, from the first region that has a line of its
  /// name. None: the lines of each region.
  std::vector<VtkLine> lines = {};
};

/// The regions as facets and their character lines as polylines through the same points. Facets
/// end exactly at embedded boundaries (skinning/facets/facets.h); regions that share such a line share its
/// points there.
///
///   point data  Normals (unit, exact, x_u × x_v; zero where the surface is singular),
///               Mean_curvature, Gauss_curvature, K1 ≥ K2 (recovered_curvatures), uv (u, v, 0),
///               Displacement (with references)
///   cell data   Region (index), Triangle (element of the region, -1 on lines), Line (index, -1 on
///               facets); with options.lines also Join (VtkLine::join) and Join_angle (degrees),
///               both -1 on facets
///   field data  Region_names, Line_names (text; runs and embedded lines, region after region; or
///               those of options.lines)
///
/// Regions keep points of their own along a line that they share (at the same places), because
/// normals, curvatures and u, v are those of the region.
///
/// VTK's order of cells: first the lines, then the facets. Points are doubles. O(facets).
/// Throws InputError: no region, references that do not match, and what facets() throws.
vtkSmartPointer<vtkPolyData> to_poly_data(const std::vector<const SkinnedRegion*>& regions,
                                          const VtkOptions& options = {});

/// to_poly_data() as a .vtp file: XML, binary appended, compressed. Whole or not at all. The same
/// regions give the same bytes. Throws InputError.
void write_vtp(const std::filesystem::path& path, const std::vector<const SkinnedRegion*>& regions,
               const VtkOptions& options = {});

/// The finite elements themselves, as a .vtu file: one VTK_QUADRATIC_TRIANGLE for each element, in
/// their order (nodes: vertices, then the surface's points at the parametric midpoints of the edges
/// 12, 23, 31), then one VTK_QUADRATIC_EDGE for each element edge of a line. Same data as above. A
/// region with embedded lines gives its quadratic_facets; Triangle is the element at their middles.
void write_vtu(const std::filesystem::path& path, const std::vector<const SkinnedRegion*>& regions,
               const VtkOptions& options = {});

}  // namespace batten
