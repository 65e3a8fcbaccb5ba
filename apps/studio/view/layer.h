// A VTK actor with its geometry: facets, polylines or points.
#pragma once

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>

#include <string>
#include <vector>

#include "batten/apps/studio/view/shape_colours.h"
#include "batten/core/eigen.h"

namespace batten::studio {

/// Polygon offset that draws a layer in front of everything else.
inline constexpr double kInFront = -66000;

/// True if a drawn line has this name or is a segment of it between nodes ("rim.2").
inline bool is_segment_of(const std::string& line, const std::string& name) {
  if (name.empty() || !line.starts_with(name)) return false;
  const std::string rest = line.substr(name.size());
  return rest.empty() || (rest.size() > 1 && rest[0] == '.' &&
                          rest.find_first_not_of("0123456789", 1) == rest.npos);
}

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

}  // namespace batten::studio
