// What the hand does to a mesh: moving its handles, painting and encircling its nodes.
#include <vtkRenderer.h>

#include <QLineF>
#include <QMouseEvent>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "batten/apps/commands/documents/mesh_edits.h"
#include "batten/apps/commands/documents/sequence_edits.h"
#include "batten/apps/studio/view/gizmo.h"
#include "batten/apps/studio/view/shape_view.h"
#include "batten/apps/studio/view/texts.h"

namespace batten::studio {
namespace {

using Verb = DocumentCommand::Verb;
constexpr double kInDegrees = 180 / std::numbers::pi;
constexpr double kBrush = 16;  // pixels

Eigen::AngleAxisd rotation(const Vec3& turn) {
  const double degrees = turn.norm();
  return {degrees / kInDegrees, degrees > 0 ? Vec3(turn / degrees) : Vec3(Vec3::UnitZ())};
}

/// A turn after another one, as vectors along their axes; whole turns about one axis add up.
Vec3 turned_on(const Vec3& first, const Vec3& then) {
  if (first.cross(then).norm() <= 1e-9 * first.norm() * then.norm()) return first + then;
  const Eigen::AngleAxisd both(rotation(then).toRotationMatrix() *
                               rotation(first).toRotationMatrix());
  return both.angle() * kInDegrees * both.axis();
}

double to_step(double value, double step) {
  return std::stod(number(std::round(value / step) * step));
}

/// Whether a point is inside of a closed polygon.
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

// The chosen handle's, or the first of the last edit.
const DocumentView::Handle* ShapeView::shown_handle() const {
  if (!view_ || (tool_ != Tool::Select && tool_ != Tool::Pin)) return nullptr;
  const DocumentView::Handle* first = nullptr;
  for (const auto& handle : view_->handles) {
    if (!handle.moves) continue;
    if (!first && handle.turns) first = &handle;
    if (handle.name == chosen_ || handle.name.ends_with("." + chosen_)) return &handle;
  }
  return first;
}

void ShapeView::show_handle() {
  if (gizmo_->pressed()) return;
  constexpr double reach = 0.16;  // of the size
  if (const auto* handle = shown_handle())
    gizmo_->show(handle->centre, reach * view_->size, handle->turns);
  else
    gizmo_->hide();
}

bool ShapeView::press_handle(const QPoint& at) {
  const auto* handle = shown_handle();
  if (!handle || !gizmo_->press(display(at).head<2>())) return false;
  held_ = *handle;
  return true;
}

void ShapeView::drag_handle(const QPoint& at) {
  const Gizmo::Motion motion = gizmo_->move(display(at).head<2>());
  const double step = std::pow(10, std::floor(std::log10(std::max(view_->size, 1e-12))) - 4);
  const auto slide = [&](const char* what, int i, double value, double& now) {
    if (value == now) return;
    now = value;
    hooks_.post({.verb = Verb::Slide, .key = held_.name + what + "xyz"[i], .value = value});
  };
  const auto* start = shown_handle();
  if (!start) return;
  const Vec3 shift = start->shift + motion.shift, turn = turned_on(start->turn, motion.turn);
  if (view_->timeline) {  // its frames are made anew when the hand lets go
    for (int i = 0; i < 3; ++i) held_.shift[i] = to_step(shift[i], step);
    for (int i = 0; i < 3; ++i) held_.turn[i] = to_step(turn[i], 0.01);
    return redraw();
  }
  for (int i = 0; i < 3; ++i) {
    if (motion.shift[i] != 0 || held_.shift[i] != start->shift[i])
      slide(".", i, to_step(shift[i], step), held_.shift[i]);
    if (!motion.turn.isZero(0) || held_.turn[i] != start->turn[i])
      slide(".turn.", i, to_step(turn[i], 0.01), held_.turn[i]);
  }
  redraw();
}

void ShapeView::release_handle() {
  gizmo_->release();
  if (!view_->timeline) return hooks_.post({.verb = Verb::Settle});
  for (DocumentCommand& edit : keyframe_edits(SceneText(view_->text), view_->timeline->frame + 1,
                                              held_.name, held_.shift, held_.turn))
    hooks_.post(std::move(edit));
}

// -- painting ---------------------------------------------------------------------------------------

// A painted selection that is chosen goes on, until it is said what it is for.
void ShapeView::start_painting() {
  const auto count = static_cast<size_t>(actors_->point_count());
  const SceneText scene(view_->text);
  const bool goes_on = painted_.size() == count && !painted_name_.empty() &&
                       use_of(scene, painted_name_) == PartUse::Free;
  if (goes_on) return;
  painted_.assign(count, 0);
  painted_name_.clear();
  if (nodes_of(scene, chosen_).empty() || use_of(scene, chosen_) != PartUse::Free) return;
  painted_name_ = chosen_;
  for (const MeshView::Part& part : view_->mesh->parts)
    for (size_t i = 0; part.name == chosen_ && i < part.points.size(); ++i)
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
  const Vec3 hand = display(at);
  const auto p = actors_->surface_at(hand.x(), hand.y());
  if (!p) return;
  const Vec3 side = to_window(*p) + Vec3(kBrush * devicePixelRatioF(), 0, 0);
  for (const int i : actors_->points_within(*p, (from_window(side) - *p).norm()))
    painted_[static_cast<size_t>(i)] = erases ? 0 : 1;
}

// All nodes that the lasso encloses, those behind, too.
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

// What is painted is a selection of the scene; further strokes add to it.
void ShapeView::finish_stroke() {
  std::vector<long> labels;
  for (size_t i = 0; i < painted_.size(); ++i)
    if (painted_[i]) labels.push_back(view_->mesh->labels[i]);
  std::sort(labels.begin(), labels.end());
  labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
  if (labels.empty()) return;
  if (painted_name_.empty()) painted_name_ = view_->free_name("painted");
  hooks_.post(nodes_edit(SceneText(view_->text), painted_name_, labels));
  awaited_ = painted_name_;
}

// What was painted, pinned or drawn is chosen as soon as the scene has it.
void ShapeView::choose_awaited() {
  for (const char* kind : {"select", "constraint", "load", "weight", "line"}) {
    if (awaited_.empty() || !view_->table({kind, awaited_})) continue;
    const std::string name = std::exchange(awaited_, "");
    kind == std::string("line") ? hooks_.chosen(name, "") : hooks_.chosen("", name);
  }
}

}  // namespace batten::studio
