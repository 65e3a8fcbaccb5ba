// Mesh tools: moving handles, painting and encircling nodes.
#include <vtkRenderer.h>

#include <QLineF>
#include <QMouseEvent>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "batten/apps/commands/documents/mesh_edits.h"
#include "batten/apps/studio/view/gizmo.h"
#include "batten/apps/studio/view/shape_view.h"
#include "batten/apps/studio/view/strings.h"

namespace batten::studio {
namespace {

using CommandKind = DocumentCommand::CommandKind;
constexpr double kInDegrees = 180 / std::numbers::pi;
constexpr double kBrush = 16;  // pixels

Eigen::AngleAxisd angle_axis(const Vec3& rotation_vector) {
  const double degrees = rotation_vector.norm();
  return {degrees / kInDegrees,
          degrees > 0 ? Vec3(rotation_vector / degrees) : Vec3(Vec3::UnitZ())};
}

/// Composes two rotation vectors (degrees); rotations about one axis add up, including full turns.
Vec3 composed_rotation(const Vec3& first, const Vec3& then) {
  if (first.cross(then).norm() <= 1e-9 * first.norm() * then.norm()) return first + then;
  const Eigen::AngleAxisd both(angle_axis(then).toRotationMatrix() *
                               angle_axis(first).toRotationMatrix());
  return both.angle() * kInDegrees * both.axis();
}

double to_step(double value, double step) {
  return std::stod(format_number(std::round(value / step) * step));
}

/// True if a point is inside a closed polygon.
bool inside(const std::vector<Vec2>& polygon, const Vec2& p) {
  bool in = false;
  for (size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Vec2 &a = polygon[i], &b = polygon[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x())
      in = !in;
  }
  return in;
}

}  // namespace

// -- handles ----------------------------------------------------------------------------------------

// The handle of the selected object, or the first one that can be rotated.
const DocumentView::Handle* ShapeView::shown_handle() const {
  if (!view_ || (tool_ != Tool::Select && tool_ != Tool::FixPoint)) return nullptr;
  const DocumentView::Handle* first = nullptr;
  for (const auto& handle : view_->handles) {
    if (!handle.moves) continue;
    if (!first && handle.can_rotate) first = &handle;
    if (handle.name == selected_ || handle.name.ends_with("." + selected_)) return &handle;
  }
  return first;
}

void ShapeView::show_handle() {
  if (gizmo_->pressed()) return;
  constexpr double arrow_length = 0.16;  // of the size
  if (const auto* handle = shown_handle())
    gizmo_->show(handle->centre, arrow_length * view_->size, handle->can_rotate);
  else
    gizmo_->hide();
}

bool ShapeView::press_handle(const QPoint& at) {
  const auto* handle = shown_handle();
  if (!handle || !gizmo_->press(display(at).head<2>())) return false;
  dragged_handle_ = *handle;
  return true;
}

void ShapeView::drag_handle(const QPoint& at) {
  const Gizmo::Motion motion = gizmo_->move(display(at).head<2>());
  const double step = std::pow(10, std::floor(std::log10(std::max(view_->size, 1e-12))) - 4);
  const auto set_slider = [&](const char* what, int i, double value, double& now) {
    if (value == now) return;
    now = value;
    hooks_.post({.kind = CommandKind::SetSlider,
                 .key = dragged_handle_.name + what + "xyz"[i],
                 .value = value});
  };
  const auto* start = shown_handle();
  if (!start) return;
  const Vec3 shift = start->shift + motion.shift,
             rotation_vector = composed_rotation(start->rotation_vector, motion.rotation_vector);
  if (view_->timeline) {  // frames are computed only after the release
    for (int i = 0; i < 3; ++i) dragged_handle_.shift[i] = to_step(shift[i], step);
    for (int i = 0; i < 3; ++i)
      dragged_handle_.rotation_vector[i] = to_step(rotation_vector[i], 0.01);
    return redraw();
  }
  for (int i = 0; i < 3; ++i) {
    if (motion.shift[i] != 0 || dragged_handle_.shift[i] != start->shift[i])
      set_slider(".", i, to_step(shift[i], step), dragged_handle_.shift[i]);
    if (!motion.rotation_vector.isZero(0) ||
        dragged_handle_.rotation_vector[i] != start->rotation_vector[i])
      set_slider(".rotation.", i, to_step(rotation_vector[i], 0.01),
                 dragged_handle_.rotation_vector[i]);
  }
  redraw();
}

void ShapeView::release_handle() {
  gizmo_->release();
  if (!view_->timeline) return hooks_.post({.kind = CommandKind::SolveToEquilibrium});
  for (DocumentCommand& edit :
       keyframe_edits(SceneText(view_->text), view_->timeline->frame + 1, dragged_handle_.name,
                      dragged_handle_.shift, dragged_handle_.rotation_vector))
    hooks_.post(std::move(edit));
}

// -- painting ---------------------------------------------------------------------------------------

// Starts painting. A painted selection that is selected is continued, unless it has got a role.
void ShapeView::start_painting() {
  const auto count = static_cast<size_t>(actors_->point_count());
  const SceneText scene(view_->text);
  const bool goes_on = painted_.size() == count && !painted_name_.empty() &&
                       use_of(scene, painted_name_) == PartUse::Free;
  if (goes_on) return;
  painted_.assign(count, 0);
  painted_name_.clear();
  if (nodes_of(scene, selected_).empty() || use_of(scene, selected_) != PartUse::Free) return;
  painted_name_ = selected_;
  for (const MeshView::Part& part : view_->mesh->parts)
    for (size_t i = 0; part.name == selected_ && i < part.points.size(); ++i)
      painted_[static_cast<size_t>(part.points[i])] = 1;
}

void ShapeView::paint(const QPoint& at, bool erases) {
  const double far = QLineF(brushed_, at).length();
  const int steps = std::max(1, static_cast<int>(std::ceil(2 * far / kBrush)));
  for (int i = 1; i <= steps; ++i) dab(brushed_ + (at - brushed_) * i / steps, erases);
  brushed_ = at;
  actors_->show_painted(painted_);
  redraw();
}

void ShapeView::dab(const QPoint& at, bool erases) {
  const Vec3 pixel = display(at);
  const auto p = actors_->surface_at(pixel.x(), pixel.y());
  if (!p) return;
  const Vec3 side = to_window(*p) + Vec3(kBrush * devicePixelRatioF(), 0, 0);
  for (const int i : actors_->points_within(*p, (from_window(side) - *p).norm()))
    painted_[static_cast<size_t>(i)] = erases ? 0 : 1;
}

// Marks or erases all nodes inside the lasso, including hidden ones.
void ShapeView::close_lasso(bool erases) {
  std::vector<Vec2> polygon;
  for (const QPoint& at : lasso_) polygon.push_back(display(at).head<2>());
  lasso_.clear();
  actors_->set_draft({});
  if (polygon.size() < 3) return;
  for (size_t i = 0; i < painted_.size(); ++i)
    if (inside(polygon, to_window(actors_->point(static_cast<int>(i))).head<2>()))
      painted_[i] = erases ? 0 : 1;
  actors_->show_painted(painted_);
}

void ShapeView::draw_lasso(const QPoint& at) {
  lasso_.push_back(at);
  std::vector<Vec3> line;
  for (const QPoint& p : lasso_) line.push_back(from_window(display(p) + Vec3(0, 0, 0.001)));
  line.push_back(line.front());
  actors_->set_draft(line);
  redraw();
}

// Stores the painted nodes as a selection of the scene; further strokes add to it.
void ShapeView::finish_stroke() {
  std::vector<long> labels;
  for (size_t i = 0; i < painted_.size(); ++i)
    if (painted_[i]) labels.push_back(view_->mesh->labels[i]);
  std::sort(labels.begin(), labels.end());
  labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
  if (labels.empty()) return;
  if (painted_name_.empty()) painted_name_ = view_->free_name("painted");
  hooks_.post(nodes_edit(SceneText(view_->text), painted_name_, labels));
  created_ = painted_name_;
}

// Selects what was painted, fixed or drawn, as soon as the scene contains it.
void ShapeView::select_created() {
  for (const char* kind : {"select", "constraint", "load", "stiffness", "curve"}) {
    if (created_.empty() || !view_->table({kind, created_})) continue;
    const std::string name = std::exchange(created_, "");
    kind == std::string("curve") ? hooks_.selected(name, "") : hooks_.selected("", name);
  }
}

}  // namespace batten::studio
