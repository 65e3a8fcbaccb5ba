// What the hand does to the document: pushing the surface, drawing lines.
#include <vtkCamera.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <cmath>

#include "batten/apps/commands/documents/line_edits.h"
#include "batten/apps/commands/documents/sequence_edits.h"
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
  hooks_.query_surface_point(*p, [this, waiting](const SurfacePoint& surface_point) {
    if (waiting.lock()) start_load(surface_point);
  });
}

// The load is there, at 0; one unit of it then shows how far the surface gives way.
void ShapeView::start_load(const SurfacePoint& surface_point) {
  Push& push = *push_;
  push.start = surface_point.present;
  push.normal = surface_point.normal;
  push.unloaded = surface_point.unloaded;
  push.point = actors_->point_near(surface_point.present);
  push.start = actors_->point(push.point);
  push.placed = true;
  push.value = 1;
  hooks_.post({.kind = CommandKind::Add,
               .table = {"load", ""},
               .text = "{ name = " + SceneText::word(push.name) + ", type = \"point\", at = " +
                       point_to_toml(rounded_point(surface_point.unloaded, view_->size)) +
                       ", direction = " + point_to_toml(rounded_point(surface_point.normal, 1)) +
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

// The load goes, and with it what it did.
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

// The place of the surface is held where it is now, or its normal as it is.
void ShapeView::fix_point(const QPoint& at, bool normal) {
  const Vec3 window = display(at);
  for (const auto& handle : view_->handles)  // it is held there: the click means that place
    if (!normal && !handle.can_rotate &&
        (to_window(handle.centre) - window).head<2>().norm() < kSnap * devicePixelRatioF())
      return hooks_.selected("", handle.name);
  const std::optional<Vec3> p = actors_->surface_at(window.x(), window.y());
  if (!p) return;
  hooks_.query_surface_point(*p, [this, normal](const SurfacePoint& surface_point) {
    created_ = view_->free_name(normal ? "normal" : "pin");
    const double size = view_->size;
    const std::string what =
        normal ? "\"normal\", direction = " + point_to_toml(rounded_point(surface_point.normal, 1))
               : "\"point\", to = " + point_to_toml(rounded_point(surface_point.present, size));
    hooks_.post({.kind = CommandKind::Add,
                 .table = {"constraint", ""},
                 .text = "{ name = " + SceneText::word(created_) + ", type = " + what + ", at = " +
                         point_to_toml(rounded_point(surface_point.unloaded, size)) + " }"});
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
  if (view_ && view_->timeline) return rounded_to_pixel(on_plane(at, Vec3::Zero()));  // the ground
  if (const auto p = actors_->surface_at(pixel.x(), pixel.y())) return *p;
  return rounded_to_pixel(on_plane(at, draft_.empty() ? Vec3(Vec3::Zero()) : draft_.front()));
}

// In the plane that lines are drawn on, through a point; where that is seen from its edge, in the one
// that faces the eye.
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

// The distance and how far it goes along x, y and z, in words over the view.
void ShapeView::measure_point(const QPoint& at) {
  if (draft_.size() > 1) draft_.clear();
  draft_.push_back(point_at(at));
  actors_->set_draft(draft_);
  if (draft_.size() > 1) {
    const Vec3 way = draft_[1] - draft_[0];
    const auto digits = [](double x) { return QString::number(x, 'g', 6); };
    set_text(text(kDistance).arg(digits(way.norm()), shown(view_->unit), digits(way.x()),
                                 digits(way.y()), digits(way.z())));
  }
  redraw();
}

void ShapeView::finish_line() {
  std::vector<Vec3> points = std::move(draft_);
  draft_.clear();
  actors_->set_draft({});
  redraw();
  if (points.size() < 2) return;
  fitted_ = true;  // the view stays while a hand draws
  if (view_->timeline) return hooks_.post(path_edit(SceneText(view_->text), points));
  created_ = view_->free_name("line");
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

}  // namespace batten::studio
