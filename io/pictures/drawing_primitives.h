// Lines and facets of surfaces that pictures draw, as VTK data. Internal.
#pragma once

#include <vtkSmartPointer.h>

#include <utility>
#include <vector>

#include "batten/skinning/region/skinned_region.h"

class vtkCellArray;
class vtkPolyData;

namespace batten::detail {

/// The lowest and the highest value.
using Range = std::pair<double, double>;
Range range_of(const std::vector<double>& values);

/// Sets the normals of points at which the surface is singular and has none: for the light, the
/// facets around give one.
void complete_normals(vtkPolyData& data, const std::vector<Vec3>& points);
/// The part of `data` with these lines or facets; points and their data are shared.
vtkSmartPointer<vtkPolyData> extract_cells(vtkPolyData& data, vtkCellArray* lines,
                                           vtkCellArray* facets);
/// The edges of all elements as polylines of so many pieces, as far as they are inside the trim.
vtkSmartPointer<vtkPolyData> element_edges(const std::vector<const SkinnedRegion*>& regions,
                                           int tessellation);
/// `count` lines of equal value, evenly spaced inside the range; `values`: one at each point.
vtkSmartPointer<vtkPolyData> iso_lines(vtkPolyData& facets, const std::vector<double>& values,
                                       const Range& range, int count);
/// The curves as polylines, 12 pieces a segment.
vtkSmartPointer<vtkPolyData> polylines(const std::vector<HermiteCurve>& curves);

}  // namespace batten::detail
