// Surfaces as VTK's files, for ParaView and everything that reads them.
#pragma once

#include <filesystem>
#include <vector>

#include "batten/skinning/region.h"

template <class T>
class vtkSmartPointer;
class vtkPolyData;

namespace batten {

struct VtkOptions {
  /// Surfaces that displacements are measured from: none, or one for each region, on the same mesh.
  std::vector<const Surface*> references;
  /// Facets along each edge of elements (of a region with embedded lines: of its own triangles,
  /// quadratic_facets), 1 or more (VTP only).
  int facets_per_edge = 4;
};

/// The regions as facets and their character lines as polylines through the same points. Facets
/// end exactly at embedded boundaries (skinning/facets.h); regions that share such a line share its
/// points there.
///
///   point data  Normals (unit, exact, x_u × x_v; zero where the surface is singular),
///               Mean_curvature, Gauss_curvature, K1 ≥ K2 (recovered_curvatures), uv (u, v, 0),
///               Displacement (with references)
///   cell data   Region (index), Triangle (element of the region, -1 on lines), Line (index, -1 on
///               facets)
///   field data  Region_names, Line_names (text; runs and embedded lines, region after region)
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
