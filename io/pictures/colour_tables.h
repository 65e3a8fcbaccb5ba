// Colours for values, and the values that they span. Internal.
#pragma once

#include <vtkSmartPointer.h>

class vtkDataArray;
class vtkLookupTable;

namespace batten::canvas {

/// Blue below 0, red above.
vtkSmartPointer<vtkLookupTable> diverging_colours(double limit);
/// Light to dark from 0 to the limit.
vtkSmartPointer<vtkLookupTable> sequential_colours(double limit);
/// Light and dark by turns from `low` to `high`, a change at every multiple of `width` above
/// `from`.
vtkSmartPointer<vtkLookupTable> striped_colours(double low, double high, double from, double width);
/// Largest magnitude between the 2nd and the 98th percentile, rounded up.
double field_limit(vtkDataArray& values);
/// The smallest number of two digits that is not below x > 0.
double rounded_up(double x);
/// The largest of 1, 2, 5 times a power of ten that is not above x > 0.
double round_step(double x);

}  // namespace batten::canvas
