// Picking: which objects are shown at a point of the window.
#include <vtkCamera.h>
#include <vtkCellPicker.h>
#include <vtkFloatArray.h>

#include <algorithm>
#include <limits>

#include "batten/apps/studio/view/layer.h"
#include "batten/apps/studio/view/screen_points.h"
#include "batten/apps/studio/view/shape_actors.h"

namespace batten::studio {
namespace {

constexpr double kNearLine = 7;   // pixels
constexpr double kBehind = 0.01;  // of the size: lines farther behind the surface are hidden

}  // namespace

std::optional<Vec3> ShapeActors::surface_at(double x, double y) const {
  if (!pattern_) return std::nullopt;
  vtkNew<vtkCellPicker> picker;
  picker->SetTolerance(0);
  picker->PickFromListOn();
  picker->AddPickList(facets_->actor);
  if (!picker->Pick(x, y, 0, renderer_)) return std::nullopt;
  Vec3 p;
  picker->GetPickPosition(p.data());
  return p;
}

// Name of the nearest line in the window that the surface does not hide. Lines on the surface take
// precedence over lines beside it.
std::string ShapeActors::line_at(double x, double y) const {
  const std::optional<Vec3> surface = surface_at(x, y);
  NearLine near{{x, y}, surface, kNearLine, ""};
  look_for(near, *lines_, line_names_);
  if (near.name.empty()) {
    std::vector<std::string> names;
    for (const auto& line : polylines_) names.push_back(line.line);
    look_for(near, *guides_, names);
  }
  return near.name;
}

void ShapeActors::look_for(NearLine& near, const Layer& layer,
                           const std::vector<std::string>& names) const {
  const Vec3 eye = -Vec3::Map(renderer_->GetActiveCamera()->GetDirectionOfProjection());
  const auto [low, high] = box();
  const double behind = kBehind * (high - low).norm();
  vtkCellArray* cells = layer.data->GetLines();
  vtkPoints* points = layer.data->GetPoints();
  const vtkIdType cell_count = cells && points ? cells->GetNumberOfCells() : 0;
  for (vtkIdType i = 0; i < cell_count && i < static_cast<vtkIdType>(names.size()); ++i) {
    const std::string& name = names[static_cast<size_t>(i)];
    vtkIdType count = 0;
    const vtkIdType* of = nullptr;
    cells->GetCellAtId(i, count, of);
    Vec3 before = Vec3::Zero();
    Vec2 before_at = Vec2::Zero();
    for (vtkIdType k = 0; k < count && !name.empty(); ++k) {
      const Vec3 p = Vec3::Map(points->GetPoint(of[k]));
      const Vec2 at = to_screen(*renderer_, p);
      const auto [distance, parameter] =
          distance_to_segment(near.pixel, k > 0 ? before_at : at, at);
      const Vec3 found = k > 0 ? Vec3(before + parameter * (p - before)) : p;
      if (distance < near.least && !(near.surface && (*near.surface - found).dot(eye) > behind)) {
        near.least = distance;
        near.name = name;
      }
      before = p;
      before_at = at;
    }
  }
}

int ShapeActors::facet_at(double x, double y) const {
  if (!pattern_) return -1;
  vtkNew<vtkCellPicker> picker;
  picker->SetTolerance(0);
  picker->PickFromListOn();
  picker->AddPickList(facets_->actor);
  return picker->Pick(x, y, 0, renderer_) ? static_cast<int>(picker->GetCellId()) : -1;
}

std::string ShapeActors::region_at(double x, double y) const {
  const int facet = facet_at(x, y);
  if (facet < 0) return "";
  if (mesh_) return part_of(facet);
  const auto& first = pattern_->first_facet;
  const auto behind = std::upper_bound(first.begin(), first.end(), facet);
  const auto region = static_cast<size_t>(behind - first.begin());
  return region > 0 && region <= regions_.size() ? regions_[region - 1] : "";
}

// The smallest part of the mesh that contains all corners of a facet.
std::string ShapeActors::part_of(int facet) const {
  const auto& corners = pattern_->facets[static_cast<size_t>(facet)];
  const MeshView::Part* best = nullptr;
  for (const MeshView::Part& part : mesh_->parts) {
    if (best && best->points.size() <= part.points.size()) continue;
    if (std::all_of(corners.begin(), corners.end(), [&](int p) {
          return std::find(part.points.begin(), part.points.end(), p) != part.points.end();
        }))
      best = &part;
  }
  return best ? best->name : "";
}

std::vector<int> ShapeActors::points_within(const Vec3& centre, double radius) const {
  std::vector<int> found;
  for (int i = 0; i < static_cast<int>(points_->GetNumberOfTuples()); ++i)
    if ((point(i) - centre).squaredNorm() <= radius * radius) found.push_back(i);
  return found;
}

int ShapeActors::point_near(const Vec3& p) const {
  int best = -1;
  double least = std::numeric_limits<double>::max();
  for (vtkIdType i = 0; i < points_->GetNumberOfTuples(); ++i) {
    const double d = (point(static_cast<int>(i)) - p).squaredNorm();
    if (d < least) {
      least = d;
      best = static_cast<int>(i);
    }
  }
  return best;
}

int ShapeActors::point_count() const { return static_cast<int>(points_->GetNumberOfTuples()); }

Vec3 ShapeActors::point(int number) const {
  const float* x = points_->GetPointer(3 * static_cast<vtkIdType>(number));
  return {x[0], x[1], x[2]};
}

std::array<Vec3, 2> ShapeActors::box() const {
  std::array<Vec3, 2> box{Vec3::Constant(1e300), Vec3::Constant(-1e300)};
  for (const auto& line : polylines_)
    for (const Vec3& p : line.points) {
      box[0] = box[0].cwiseMin(p);
      box[1] = box[1].cwiseMax(p);
    }
  for (vtkIdType i = 0; pattern_ && i < points_->GetNumberOfTuples(); ++i) {
    const Vec3 p = point(static_cast<int>(i));
    box[0] = box[0].cwiseMin(p);
    box[1] = box[1].cwiseMax(p);
  }
  if (box[0].x() > box[1].x()) return {Vec3::Constant(-100), Vec3::Constant(100)};
  return box;
}

}  // namespace batten::studio
