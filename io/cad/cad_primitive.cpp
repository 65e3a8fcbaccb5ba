// SPDX-License-Identifier: MPL-2.0
#include "batten/io/cad/cad_primitive.h"

#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <GeomConvert.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_SweptSurface.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <Precision.hxx>
#include <ShapeCustom_Surface.hxx>
#include <Standard_Failure.hxx>
#include <algorithm>
#include <cmath>
#include <gp_Ax3.hxx>

#include "batten/core/geometry.h"
#include "batten/io/cad/occ_settings.h"

namespace batten {

FittedPrimitive shape_of(const Handle(Geom_Surface) & surface) {
  FittedPrimitive shape;
  const auto take = [&](const gp_Ax3& frame, FittedPrimitive::Kind kind) {
    shape.kind = kind;
    shape.origin = from_occ(frame.Location());
    shape.axis = from_occ(frame.Direction().XYZ());
  };
  if (const auto plane = Handle(Geom_Plane)::DownCast(surface); !plane.IsNull()) {
    take(plane->Position(), FittedPrimitive::Kind::Plane);
  } else if (const auto cylinder = Handle(Geom_CylindricalSurface)::DownCast(surface);
             !cylinder.IsNull()) {
    take(cylinder->Position(), FittedPrimitive::Kind::Cylinder);
    shape.radius = cylinder->Radius();
  } else if (const auto sphere = Handle(Geom_SphericalSurface)::DownCast(surface);
             !sphere.IsNull()) {
    take(sphere->Position(), FittedPrimitive::Kind::Sphere);
    shape.radius = sphere->Radius();
  } else if (const auto cone = Handle(Geom_ConicalSurface)::DownCast(surface); !cone.IsNull()) {
    take(cone->Position(), FittedPrimitive::Kind::Cone);
    shape.half_angle = std::abs(cone->SemiAngle());
    shape.radius = cone->RefRadius();
    shape.origin = from_occ(cone->Apex());
    if (cone->SemiAngle() < 0) shape.axis = -shape.axis;
  } else if (const auto torus = Handle(Geom_ToroidalSurface)::DownCast(surface); !torus.IsNull()) {
    take(torus->Position(), FittedPrimitive::Kind::Torus);
    shape.radius = torus->MinorRadius();
    shape.major_radius = torus->MajorRadius();
  }
  return shape;
}

namespace {

Handle(Geom_Surface) whole_surface(const TopoDS_Face& face) {
  Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
  while (!surface.IsNull() && surface->IsKind(STANDARD_TYPE(Geom_RectangularTrimmedSurface)))
    surface = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface)->BasisSurface();
  return surface;
}

/// The analytic surface that a free-form surface equals within a tolerance; null if there is none.
Handle(Geom_Surface) analytic_form(const Handle(Geom_Surface) & surface, const Vec2& low,
                                   const Vec2& high, double tolerance) {
  try {
    const Handle(Geom_Surface) part = new Geom_RectangularTrimmedSurface(
        surface, low.x(), high.x(), low.y(), high.y(), true, true);
    return ShapeCustom_Surface(GeomConvert::SurfaceToBSplineSurface(part))
        .ConvertToAnalytical(tolerance, false);
  } catch (const Standard_Failure&) {
    return {};
  }
}

}  // namespace

bool is_swept(const TopoDS_Face& face) {
  const Handle(Geom_Surface) surface = whole_surface(face);
  return !surface.IsNull() && surface->IsKind(STANDARD_TYPE(Geom_SweptSurface));
}

FittedPrimitive primitive_of(const TopoDS_Face& face) {
  const Handle(Geom_Surface) surface = whole_surface(face);
  if (surface.IsNull()) return {};
  Vec2 low, high;
  BRepTools::UVBounds(face, low.x(), high.x(), low.y(), high.y());
  if (!low.allFinite() || !high.allFinite() || Precision::IsInfinite(high.x() - low.x()) ||
      Precision::IsInfinite(high.y() - low.y()))
    return {};
  constexpr int samples = 4;
  constexpr double same = 1e-7;
  Box3 box;
  std::vector<Vec3> points;
  for (int i = 0; i <= samples; ++i)
    for (int j = 0; j <= samples; ++j) {
      const Vec2 uv = low + Vec2(double(i) / samples, double(j) / samples).cwiseProduct(high - low);
      points.push_back(from_occ(surface->Value(uv.x(), uv.y()).XYZ()));
      box.extend(points.back());
    }
  const double tolerance = same * box.diagonal().norm();
  FittedPrimitive shape = shape_of(surface);
  if (shape.kind == FittedPrimitive::Kind::Free && tolerance > 0)
    if (const Handle(Geom_Surface) form = analytic_form(surface, low, high, tolerance);
        !form.IsNull())
      shape = shape_of(form);
  if (shape.kind == FittedPrimitive::Kind::Cone) {  // the nappe on which the face lies
    double side = 0;
    for (const Vec3& p : points) side += (p - shape.origin).dot(shape.axis);
    if (side < 0) shape.axis = -shape.axis;
  }
  const bool near = std::all_of(points.begin(), points.end(), [&](const Vec3& p) {
    return std::abs(shape.distance(p)) <= 10 * tolerance;
  });
  return near ? shape : FittedPrimitive{};
}

}  // namespace batten
