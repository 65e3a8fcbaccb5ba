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

// Colour tables for fields, and the ranges of values that they cover. Internal.

class vtkDataArray;
class vtkLookupTable;

namespace batten::detail {

/// A table from -limit to limit: blue below 0, grey at 0, red above.
vtkSmartPointer<vtkLookupTable> diverging_colours(double limit);
/// A table from 0 to the limit: from light to dark blue.
vtkSmartPointer<vtkLookupTable> sequential_colours(double limit);
/// A table from 0 to the limit: from blue over green and yellow to red, lighter in the middle.
vtkSmartPointer<vtkLookupTable> heat_colours(double limit);
/// A table from `low` to `high` of light and dark stripes in turn. They change at from + k · width.
vtkSmartPointer<vtkLookupTable> striped_colours(double low, double high, double from, double width);
/// The limit of a field's colours: the largest magnitude between the 2nd and the 98th percentile of
/// its finite values, rounded_up(); 1 when that is 0. O(n log n).
double field_limit(vtkDataArray& values);
/// The smallest number of two digits that is not below x > 0.
double rounded_up(double x);
/// The largest of 1, 2, 5 times a power of ten that is not above x > 0.
double round_step(double x);

}  // namespace batten::detail
