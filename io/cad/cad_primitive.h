// SPDX-License-Identifier: MPL-2.0
// Recognises planes, cylinders, cones, spheres and tori among the surfaces of CAD files.
#pragma once

#include <Geom_Surface.hxx>
#include <TopoDS_Face.hxx>

#include "batten/skinning/surfaces/fitted_primitive.h"

namespace batten {

/// The primitive of a surface that OpenCASCADE represents as one (Geom_Plane, Geom_CylindricalSurface
/// …); Kind::Free for any other surface.
FittedPrimitive shape_of(const Handle(Geom_Surface) & surface);

/// True if the face lies on a surface of revolution or an extruded surface.
bool is_swept(const TopoDS_Face& face);

/// The primitive of a face, in millimetres: that of its surface or, for a spline, a surface of
/// revolution or an extruded surface, the one that equals the surface within 1e-7 of the face's size.
/// Kind::Free if there is none. `radius` of a cone is its reference radius. Takes up to a
/// millisecond.
FittedPrimitive primitive_of(const TopoDS_Face& face);

}  // namespace batten
