// SPDX-License-Identifier: MPL-2.0
// Lines, facets and colour tables of pictures, as VTK data.
#pragma once

#include <vtkSmartPointer.h>
#include <utility>
#include <vector>

#include "batten/skinning/region/skinned_region.h"

class vtkCellArray;
class vtkPolyData;

namespace batten::detail {

/// Lowest and highest value.
using Range = std::pair<double, double>;
/// The range of a list of values.
Range range_of(const std::vector<double>& values);

/// The points of VTK data, in its order.
std::vector<Vec3> points_of(vtkPolyData& data);
/// Sets the normals of points at which the surface is singular, from the surrounding facets.
void complete_normals(vtkPolyData& data, const std::vector<Vec3>& points);
/// The subset of `data` with these lines or facets; points and point data are shared.
vtkSmartPointer<vtkPolyData> extract_cells(vtkPolyData& data, vtkCellArray* lines,
                                           vtkCellArray* facets);
/// Edges of facets at which the angle between the facets exceeds 30 degrees, and free edges.
vtkSmartPointer<vtkPolyData> feature_edges(vtkPolyData& facets);
/// The edges of all elements inside the trim, as polylines with `tessellation` segments per edge.
vtkSmartPointer<vtkPolyData> element_edges(const std::vector<const SkinnedRegion*>& regions,
                                           int tessellation);
/// `count` contour lines, evenly spaced inside the range. `values`: one per point.
vtkSmartPointer<vtkPolyData> iso_lines(vtkPolyData& facets, const std::vector<double>& values,
                                       const Range& range, int count);
/// The curves as polylines, with 12 pieces per curve segment.
vtkSmartPointer<vtkPolyData> polylines(const std::vector<HermiteCurve>& curves);

}  // namespace batten::detail

// Colour tables for fields, and the value ranges that they cover.

class vtkDataArray;
class vtkLookupTable;

namespace batten::detail {

/// Colour table from −limit to limit: blue below 0, grey at 0, red above.
vtkSmartPointer<vtkLookupTable> diverging_colours(double limit);
/// Colour table from 0 to the limit, from light grey over yellow and red to dark violet. The
/// lightness decreases linearly, so that equal steps of the value look equal.
vtkSmartPointer<vtkLookupTable> sequential_colours(double limit);
/// Colour table from `low` to `high` with alternating light and dark stripes, which change at from
/// + k · width.
vtkSmartPointer<vtkLookupTable> striped_colours(double low, double high, double from, double width);
/// Limit of a field's colour scale: the largest magnitude between the 2nd and the 98th percentile
/// of its finite values, rounded by rounded_up(); 1 if that is 0. Cost: O(n log n).
double field_limit(vtkDataArray& values);
/// Range of the finite values; (0, 0) if there are none.
Range finite_range(vtkDataArray& values);
/// The smallest of 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8 times a power of ten that is ≥ x; x > 0.
double rounded_up(double x);
/// The largest of 1, 2, 5 times a power of ten that is ≤ x; x > 0.
double round_step(double x);

}  // namespace batten::detail
