// SPDX-License-Identifier: MPL-2.0
// Tools of the 3-D view. For shapes: pushing the surface, fixing points, drawing and editing curves,
// painting. For meshes: moving handles, painting and encircling nodes.

#include <vtkCamera.h>
#include <vtkRenderer.h>

#include <QLineF>
#include <QMouseEvent>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "batten/apps/documents/line_edits.h"
#include "batten/apps/documents/mesh_edits.h"
#include "batten/apps/studio/view/gizmo.h"
#include "batten/apps/studio/view/shape_view.h"
#include "batten/apps/studio/view/strings.h"

namespace batten::studio {
namespace {

using CommandKind = DocumentCommand::CommandKind;
constexpr double kSnap = 12;  // pixels

}  // namespace

// -- pushing ----------------------------------------------------------------------------------------

void ShapeView::start_push(const QPoint& at) {
  const Vec3 window = display(at);
  const std::optional<Vec3> p = actors_->surface_at(window.x(), window.y());
  auto push = std::make_shared<Push>();
  push->from = at;
  push->start = *p;
  push->normal = Vec3::UnitZ();
  push->name = view_->free_name("push");
  push_ = push;
  const std::weak_ptr<Push> waiting = push;
  hooks_.query_surface_point(*p, [this, waiting](const PickedPoint& surface_point) {
    if (waiting.lock()) start_load(surface_point);
  });
}

// Adds the load with value 0, then sets it to 1 to measure the compliance of the surface.
void ShapeView::start_load(const PickedPoint& surface_point) {
  Push& push = *push_;
  push.start = surface_point.present;
  push.normal = surface_point.normal;
  push.unloaded = surface_point.unloaded;
  push.point = actors_->point_near(surface_point.present);
  push.start = actors_->point(push.point);
  push.placed = true;
  push.value = 1;
  hooks_.post(
      {.kind = CommandKind::Add,
       .table = {"load", ""},
       .text = "{ name = " + SceneText::toml_value(push.name) + ", type = \"point\", at = " +
               SceneText::toml_value(rounded_point(surface_point.unloaded, view_->size)) +
               ", direction = " + SceneText::toml_value(rounded_point(surface_point.normal, 1)) +
               ", value = 0 }"});
  hooks_.post({.kind = CommandKind::SetSlider, .key = push.name, .value = push.value});
}

void ShapeView::follow_push() {
  if (!push_ || !push_->placed) return;
  Push& push = *push_;
  const Vec3 now = actors_->point(push.point);
  const double gone = (now - push.start).dot(push.normal);
  actors_->set_push(std::pair(push.start, now));
  if (push.compliance == 0 && std::abs(gone) > 1e-9 * view_->size)
    push.compliance = gone / push.value;
  if (push.compliance == 0) return;
  const double value = std::stod(format_number(push.wanted / push.compliance));
  if (value == push.value) return;
  push.value = value;
  hooks_.post({.kind = CommandKind::SetSlider, .key = push.name, .value = value});
}

// Removes the load, and thus its effect.
void ShapeView::cancel_push() {
  const bool placed = push_->placed;
  const std::string name = push_->name;
  end_push();
  if (placed) hooks_.post({.kind = CommandKind::Remove, .table = {"load", name}});
}

void ShapeView::end_push() {
  const bool placed = push_->placed;
  push_.reset();
  actors_->set_push(std::nullopt);
  if (placed) hooks_.post({.kind = CommandKind::SolveToEquilibrium});
}

// Fixes a point of the surface at its present position, or its present normal.
void ShapeView::fix_point(const QPoint& at, bool normal) {
  const Vec3 window = display(at);
  for (const auto& handle : view_->handles)  // fixed already: select that constraint
    if (!normal && !handle.can_rotate &&
        (to_window(handle.centre) - window).head<2>().norm() < kSnap * devicePixelRatioF())
      return hooks_.selected("", handle.name);
  const std::optional<Vec3> p = actors_->surface_at(window.x(), window.y());
  if (!p) return;
  hooks_.query_surface_point(*p, [this, normal](const PickedPoint& surface_point) {
    created_ = view_->free_name(normal ? "normal" : "point");
    const double size = view_->size;
    const std::string what =
        normal ? "\"normal\", direction = " +
                     SceneText::toml_value(rounded_point(surface_point.normal, 1))
               : "\"point\", to = " +
                     SceneText::toml_value(rounded_point(surface_point.present, size));
    hooks_.post(
        {.kind = CommandKind::Add,
         .table = {"constraint", ""},
         .text = "{ name = " + SceneText::toml_value(created_) + ", type = " + what + ", at = " +
                 SceneText::toml_value(rounded_point(surface_point.unloaded, size)) + " }"});
  });
}

// -- drawing ----------------------------------------------------------------------------------------

std::optional<Vec3> ShapeView::snapped(const QPoint& at) const {
  const Vec3 pixel = display(at);
  double least = kSnap * devicePixelRatioF();
  std::optional<Vec3> best;
  const auto offer = [&](const Vec3& p) {
    const double d = (to_window(p) - pixel).head<2>().norm();
    if (d >= least) return;
    least = d;
    best = p;
  };
  if (view_)
    for (const auto& line : view_->lines) {
      if (line.line == defining_line_ && tool_ == Tool::Select) continue;
      offer(line.points.front());
      offer(line.points.back());
    }
  if (draft_.size() > 1) offer(draft_.front());
  return best;
}

Vec3 ShapeView::point_at(const QPoint& at) const {
  if (const auto end = snapped(at)) return *end;
  const Vec3 pixel = display(at);
  // Ground plane.
  if (view_ && view_->timeline) return rounded_to_pixel(on_plane(at, Vec3::Zero()));
  if (const auto p = actors_->surface_at(pixel.x(), pixel.y())) return *p;
  return rounded_to_pixel(on_plane(at, draft_.empty() ? Vec3(Vec3::Zero()) : draft_.front()));
}

// Intersects the view ray with the drawing plane through a point. If that plane is seen edge-on,
// the view plane is used.
Vec3 ShapeView::on_plane(const QPoint& at, const Vec3& through) const {
  const Vec3 pixel = display(at), near = from_window(pixel);
  const Vec3 along = (from_window(pixel + Vec3::UnitZ()) - near).normalized();
  Vec3 normal = plane_ == DrawPlane::Xy   ? Vec3::UnitZ()
                : plane_ == DrawPlane::Xz ? Vec3::UnitY()
                : plane_ == DrawPlane::Yz ? Vec3::UnitX()
                                          : along;
  constexpr double grazing = 0.05;
  if (std::abs(normal.dot(along)) < grazing) normal = along;
  return near + along * ((through - near).dot(normal) / along.dot(normal));
}

void ShapeView::draw_point(const QPoint& at) {
  const Vec3 p = point_at(at);
  if (!draft_.empty() && p == draft_.back()) return;
  const bool ends = !draft_.empty() && snapped(at).has_value();
  draft_.push_back(p);
  actors_->set_draft(draft_);
  redraw();
  if (ends) return finish_line();
  hooks_.hint(text(kHintDrawing));
}

// Shows the distance, and its components along x, y and z, over the view.
void ShapeView::measure_point(const QPoint& at) {
  if (draft_.size() > 1) draft_.clear();
  draft_.push_back(point_at(at));
  actors_->set_draft(draft_);
  if (draft_.size() > 1) {
    const Vec3 offset = draft_[1] - draft_[0];
    const auto digits = [](double x) { return QString::number(x, 'g', 6); };
    set_text(text(kDistance).arg(digits(offset.norm()), shown(view_->unit), digits(offset.x()),
                                 digits(offset.y()), digits(offset.z())));
  }
  redraw();
}

void ShapeView::finish_line() {
  std::vector<Vec3> points = std::move(draft_);
  draft_.clear();
  actors_->set_draft({});
  redraw();
  if (points.size() < 2) return;
  fitted_ = true;  // keep the view while the user is drawing
  if (view_->timeline) return hooks_.post(path_edit(SceneText(view_->text), points));
  created_ = view_->free_name("curve");
  hooks_.post(line_command(created_, points));
  hooks_.hint(text(kHintDraw));
}

void ShapeView::cancel_tool() {
  draft_.clear();
  actors_->set_draft({});
  if (tool_ == Tool::Measure) set_text("");
  if (push_) end_push();
  redraw();
}

// Editing of the selected curve: moving, adding, removing and fairing points.

namespace {

constexpr double kGrab = 10;  // pixels
// Ms: the surface follows a drag only if it is computed faster.
constexpr qint64 kFollowsWithinMs = 400;

}  // namespace

// Shows the defining points of the selected curve as dots, and its curvature as a comb.
void ShapeView::show_line() {
  if (moved_point_ >= 0) return;
  line_points_.clear();
  const bool shape = view_ && !view_->mesh && tool_ == Tool::Select;
  if (shape) {
    const SceneText scene(view_->text);
    defining_line_ = defining_line(scene, selected_);
    line_points_ = defining_points(scene, defining_line_);
    line_key_ = line_key(scene, defining_line_);
  }
  if (selected_point_ >= static_cast<int>(line_points_.size())) selected_point_ = -1;
  show_dots();
  std::vector<Vec3> line;
  for (size_t i = 0; shape && combs_ && i < view_->lines.size(); ++i)
    if (view_->lines[i].line == (defining_line_.empty() ? selected_ : defining_line_))
      line = view_->lines[i].points;
  actors_->set_comb(line);
  if (view_ && view_->timeline) show_path();
}

// Control points are joined by their polygon.
void ShapeView::show_dots() {
  actors_->set_dots(line_points_, selected_point_, line_key_ == LineKey::Bezier);
}

// Shows the path of the current handle over all frames (or the path that the sequence follows), and
// the foot contacts.
void ShapeView::show_path() {
  actors_->set_dots(view_->timeline->footprints, -1, false);
  const auto* handle = shown_handle();
  actors_->set_path(handle ? handle->path : path_of(SceneText(view_->text)));
}

void ShapeView::set_combs(bool shown) {
  combs_ = shown;
  show_line();
  redraw();
}

// Index of the defining point under the mouse; -1: none.
int ShapeView::point_under(const QPoint& at) const {
  const Vec3 pixel = display(at);
  double least = kGrab * devicePixelRatioF();
  int best = -1;
  for (size_t i = 0; i < line_points_.size(); ++i) {
    const double d = (to_window(line_points_[i]) - pixel).head<2>().norm();
    if (d >= least) continue;
    least = d;
    best = static_cast<int>(i);
  }
  return best;
}

bool ShapeView::press_point(const QPoint& at, bool detached) {
  if (tool_ != Tool::Select) return false;
  moved_point_ = point_under(at);
  if (moved_point_ < 0) return false;
  selected_point_ = moved_point_;
  detached_ = detached;
  awaits_move_ = false;
  point_before_ = line_points_[static_cast<size_t>(moved_point_)];
  show_dots();
  redraw();
  return true;
}

// Moves a point in the drawing plane, or snaps it to the end of another curve.
void ShapeView::drag_point(const QPoint& at) {
  Vec3& p = line_points_[static_cast<size_t>(moved_point_)];
  const auto end = snapped(at);
  p = end ? *end : rounded_to_pixel(on_plane(at, point_before_));
  show_dots();
  actors_->set_draft(line_points_);
  hooks_.hint(text(kPointAt).arg(p.x()).arg(p.y()).arg(p.z()));
  redraw();
  if (!follows_point()) return;
  fitted_ = true;
  awaits_move_ = true;
  since_move_.start();
  hooks_.post(move_point_command(point_before_, p));
}

// True if the surface has followed the last move, and fast enough, so that it can follow the next
// one.
bool ShapeView::follows_point() const {
  return !detached_ && !awaits_move_ && view_->surface && move_ms_ < kFollowsWithinMs;
}

// Curves that meet at the point stay joined, unless Shift is pressed. The whole drag is one undo
// step.
void ShapeView::release_point() {
  const Vec3 now = line_points_[static_cast<size_t>(std::exchange(moved_point_, -1))];
  actors_->set_draft({});
  fitted_ = true;
  if (now == point_before_ && !since_move_.isValid()) return;
  since_move_.invalidate();
  awaits_move_ = false;
  hooks_.post(detached_ ? points_edit(defining_line_, line_points_, line_key_)
                        : move_point_command(point_before_, now));
  hooks_.post({.kind = DocumentCommand::CommandKind::SolveToEquilibrium});
}

// Inserts a point in the selected curve, after a double click on it.
bool ShapeView::add_point(const QPoint& at) {
  if (tool_ != Tool::Select || line_points_.size() < 2 || line_key_ != LineKey::Points)
    return false;
  const auto found = std::find_if(view_->lines.begin(), view_->lines.end(),
                                  [&](const auto& line) { return line.line == defining_line_; });
  if (found == view_->lines.end()) return false;
  const Vec3 pixel = display(at);
  const std::vector<Vec3>& curve = found->points;
  size_t nearest = 0;
  const auto distance = [&](size_t i) { return (to_window(curve[i]) - pixel).head<2>().norm(); };
  for (size_t i = 0; i < curve.size(); ++i)
    if (distance(i) < distance(nearest)) nearest = i;
  if (distance(nearest) > 2 * kGrab) return false;
  // Insert it between the defining points before and after it along the curve.
  const auto nearest_from = [&](const Vec3& p, size_t from) {
    size_t best = from;
    for (size_t i = from; i < curve.size(); ++i)
      if ((curve[i] - p).squaredNorm() < (curve[best] - p).squaredNorm()) best = i;
    return best;
  };
  size_t before = 0, at_curve = 0;
  for (size_t i = 0; i + 1 < line_points_.size(); ++i) {
    at_curve = nearest_from(line_points_[i], at_curve);
    if (at_curve <= nearest) before = i;
  }
  selected_point_ = static_cast<int>(before) + 1;
  std::vector<Vec3> points = line_points_;
  points.insert(points.begin() + selected_point_, rounded_to_pixel(curve[nearest]));
  fitted_ = true;
  hooks_.post(points_edit(defining_line_, points));
  return true;
}

bool ShapeView::remove_point() {
  if (selected_point_ < 0 || line_points_.size() < 3 || line_key_ != LineKey::Points) return false;
  std::vector<Vec3> points = line_points_;
  points.erase(points.begin() + selected_point_);
  selected_point_ = -1;
  fitted_ = true;
  hooks_.post(points_edit(defining_line_, points));
  return true;
}

// Rounds coordinates to about the size of a pixel.
Vec3 ShapeView::rounded_to_pixel(const Vec3& p) const {
  const Vec3 at = to_window(p);
  const double pixel = (from_window(at + Vec3::UnitX()) - from_window(at)).norm();
  constexpr double digits = 1e5;
  return rounded_point(p, digits * pixel);
}

// Painting the area of loads and stiffness fields on a surface.

namespace {

constexpr double kBrushRadius = 22;  // pixels
constexpr const char* kPaintedKinds[] = {"load", "stiffness"};

}  // namespace

// The selected load or stiffness field, if its area is painted.
SceneTable ShapeView::painted_table() const {
  const SceneText scene(view_->text);
  for (const char* kind : kPaintedKinds)
    if (!selected_.empty() && is_painted(scene, {kind, selected_})) return {kind, selected_};
  return {};
}

// Highlights the painted area of the selected load or stiffness field.
void ShapeView::show_painted_area() {
  if (!view_ || view_->mesh) return;
  const SceneTable table = painted_table();
  if (table.kind.empty()) return;
  painted_.assign(static_cast<size_t>(actors_->point_count()), 0);
  for (const BrushDab& dab : painted_dabs(SceneText(view_->text), table))
    mark_near(dab.at, dab.radius, true);
  actors_->show_painted(painted_);
}

void ShapeView::mark_near(const Vec3& unloaded, double radius, bool on) {
  for (const int i : actors_->unloaded_within(unloaded, radius))
    if (static_cast<size_t>(i) < painted_.size()) painted_[static_cast<size_t>(i)] = on ? 1 : 0;
}

void ShapeView::start_stroke(bool erases) {
  stroke_ = std::make_shared<Stroke>();
  stroke_->table = painted_table();
  stroke_->erases = erases;
  if (painted_.size() != static_cast<size_t>(actors_->point_count()) || stroke_->table.kind.empty())
    painted_.assign(static_cast<size_t>(actors_->point_count()), 0);
}

// Adds brush dabs, half a radius apart. Each one requests its position on the unloaded surface; the
// stroke is complete when all responses have arrived.
void ShapeView::paint_area(const QPoint& at) {
  const double far = QLineF(brushed_, at).length();
  if (stroke_->asked > 0 && far < kBrushRadius / 2) return;
  const int steps = std::max(1, static_cast<int>(std::floor(2 * far / kBrushRadius)));
  for (int i = 1; i <= steps; ++i) {
    const Vec3 pixel = display(brushed_ + (at - brushed_) * i / steps);
    const auto p = actors_->surface_at(pixel.x(), pixel.y());
    if (!p) continue;
    const Vec3 side = to_window(*p) + Vec3(kBrushRadius * devicePixelRatioF(), 0, 0);
    const double radius = (from_window(side) - *p).norm();
    ++stroke_->asked;
    hooks_.query_surface_point(
        *p, [this, stroke = stroke_, radius](const PickedPoint& surface_point) {
          stroke->dabs.push_back({rounded_point(surface_point.unloaded, view_->size),
                                  rounded_point({radius, 0, 0}, view_->size).x()});
          mark_near(surface_point.unloaded, radius, !stroke->erases);
          actors_->show_painted(painted_);
          redraw();
          if (stroke->ended && static_cast<int>(stroke->dabs.size()) == stroke->asked)
            take_stroke(*stroke);
        });
  }
  brushed_ = at;
}

void ShapeView::end_stroke() {
  const std::shared_ptr<Stroke> stroke = std::exchange(stroke_, nullptr);
  stroke->ended = true;
  if (stroke->asked > 0 && static_cast<int>(stroke->dabs.size()) == stroke->asked)
    take_stroke(*stroke);
}

void ShapeView::take_stroke(const Stroke& stroke) {
  if (!stroke.table.kind.empty()) {
    created_ = stroke.table.name;
    for (DocumentCommand& edit :
         paint_edits(SceneText(view_->text), stroke.table, stroke.dabs, stroke.erases))
      hooks_.post(std::move(edit));
  } else if (!stroke.erases) {
    created_ = view_->free_name("painted");
    hooks_.post(new_paint(created_, paint_kind_, stroke.dabs));
    hooks_.post({.kind = DocumentCommand::CommandKind::SolveToEquilibrium});  // a step of its own
  }
}

namespace {

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
