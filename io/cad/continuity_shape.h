// How the faces of a shape meet. Internal.
#pragma once

#include <TopoDS_Shape.hxx>

#include "batten/io/cad/continuity_report.h"

namespace batten {

/// Measures a shape as measure_continuity() does a file, without sewing, in the shape's own unit and on
/// all threads. `size`: the diagonal of the box around its edges.
ContinuityReport shape_continuity(const TopoDS_Shape& shape, double size,
                                  const ContinuityOptions& options = {});

}  // namespace batten
