// Colour tables for fields, and the ranges of values that they cover. Internal.
#pragma once

#include <vtkSmartPointer.h>

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
