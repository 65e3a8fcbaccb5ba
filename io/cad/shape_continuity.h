// Measures the continuity between the faces of an OpenCASCADE shape.
#pragma once

#include <TopoDS_Shape.hxx>

#include <vector>

#include "batten/io/cad/continuity_report.h"

namespace batten {

/// The area of each face of a shape, in order. OpenCASCADE integrates between the knots of each
/// face. Uses all threads.
std::vector<double> face_areas(const TopoDS_Shape& shape);

/// Measures a shape as measure_continuity() does a file, but without sewing and in the shape's own
/// unit. `size`: diagonal of the bounding box of its edges. Uses all threads.
ContinuityReport shape_continuity(const TopoDS_Shape& shape, double size,
                                  const ContinuityOptions& options = {});

}  // namespace batten
