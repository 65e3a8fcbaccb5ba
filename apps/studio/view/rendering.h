// SPDX-License-Identifier: MPL-2.0
// Drawing with VTK: actors with their geometry, conversions between model coordinates and pixels.
#pragma once

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "batten/apps/studio/view/shape_colours.h"
#include "batten/core/eigen.h"

namespace batten::studio {

/// Polygon offset that draws a layer in front of everything else.
inline constexpr double kInFront = -66000;

/// A set of VTK cells and the actor that draws them.
struct Layer {
  /// Adds an actor to the renderer.
  ///
  /// `order`: polygon offset; at equal depth, lower values are drawn in front. `width`: line width
  /// in pixels; 0: facets, with lighting.
  Layer(vtkRenderer* renderer, double order, double width) {
    mapper->SetInputData(data);
    mapper->SetResolveCoincidentTopologyToPolygonOffset();
    mapper->SetRelativeCoincidentTopologyPolygonOffsetParameters(0, order);
    mapper->SetRelativeCoincidentTopologyLineOffsetParameters(0, order);
    mapper->SetRelativeCoincidentTopologyPointOffsetParameter(order);
    mapper->ScalarVisibilityOff();
    actor->SetMapper(mapper);
    actor->GetProperty()->SetLineWidth(static_cast<float>(width));
    actor->GetProperty()->SetRenderPointsAsSpheres(true);
    if (width > 0) actor->GetProperty()->LightingOff();
    renderer->AddActor(actor);
  }
  void set_colour(const Rgb& c) { actor->GetProperty()->SetColor(c[0], c[1], c[2]); }
  void set_polylines(const std::vector<std::vector<Vec3>>& lines) {
    vtkNew<vtkPoints> points;
    vtkNew<vtkCellArray> cells;
    for (const auto& line : lines) {
      cells->InsertNextCell(static_cast<int>(line.size()));
      for (const Vec3& p : line) cells->InsertCellPoint(points->InsertNextPoint(p.data()));
    }
    data->SetPoints(points);
    data->SetLines(cells);
    data->Modified();
  }
  /// Shows points as dots of `size` pixels, joined by a polyline if `joined`.
  void set_dots(const std::vector<Vec3>& points, bool joined, double size) {
    set_polylines(joined && points.size() > 1 ? std::vector<std::vector<Vec3>>{points}
                                              : std::vector<std::vector<Vec3>>{});
    vtkNew<vtkPoints> dots;
    vtkNew<vtkCellArray> vertices;
    for (const Vec3& p : points) {
      const vtkIdType id = dots->InsertNextPoint(p.data());
      vertices->InsertNextCell(1, &id);
    }
    data->SetPoints(dots);
    data->SetVerts(vertices);
    data->Modified();
    actor->GetProperty()->SetPointSize(static_cast<float>(size));
  }
  vtkNew<vtkPolyData> data;
  vtkNew<vtkPolyDataMapper> mapper;
  vtkNew<vtkActor> actor;
};

// Model coordinates and pixels.

/// Position of a model point in the renderer's pixels (origin at the lower left), and its depth.
inline Vec3 to_display(vtkRenderer& renderer, const Vec3& p) {
  renderer.SetWorldPoint(p.x(), p.y(), p.z(), 1);
  renderer.WorldToDisplay();
  Vec3 window;
  renderer.GetDisplayPoint(window.data());
  return window;
}
/// The same without the depth.
inline Vec2 to_screen(vtkRenderer& renderer, const Vec3& p) {
  return to_display(renderer, p).head<2>();
}
/// Inverse of to_display(): the model point at a pixel and depth.
inline Vec3 to_world(vtkRenderer& renderer, const Vec3& window) {
  double world[4];
  renderer.SetDisplayPoint(window.data());
  renderer.DisplayToWorld();
  renderer.GetWorldPoint(world);
  return Vec3(world[0], world[1], world[2]) / world[3];
}

/// Distance of a point from a segment, and the parameter of the closest point on it, 0 to 1.
inline std::pair<double, double> distance_to_segment(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 along = b - a;
  const double length = along.squaredNorm();
  const double parameter = length > 0 ? std::clamp((p - a).dot(along) / length, 0.0, 1.0) : 0;
  return {(p - a - parameter * along).norm(), parameter};
}

}  // namespace batten::studio
