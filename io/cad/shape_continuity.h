// How the faces of a shape meet. Internal.
#pragma once

#include <TopoDS_Shape.hxx>

#include <vector>

#include "batten/io/cad/continuity_report.h"

namespace batten {

/// The areas of the faces of a shape, in their order, by OpenCASCADE, on all threads: integrals over the
/// knots of each.
std::vector<double> face_areas(const TopoDS_Shape& shape);

/// Measures a shape as measure_continuity() does a file, without sewing, in the shape's own unit and on
/// all threads. `size`: the diagonal of the box around its edges.
ContinuityReport shape_continuity(const TopoDS_Shape& shape, double size,
                                  const ContinuityOptions& options = {});

}  // namespace batten
