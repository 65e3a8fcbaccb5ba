// What the hand does to a chosen line: its points are moved, added, taken away and faired.
#include <vtkRenderer.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "batten/apps/commands/documents/line_edits.h"
#include "batten/apps/commands/documents/sequence_edits.h"
#include "batten/apps/studio/view/shape_view.h"
#include "batten/apps/studio/view/strings.h"

namespace batten::studio {
namespace {

constexpr double kGrab = 10;              // pixels
constexpr qint64 kFollowsWithinMs = 400;  // ms: a surface that is made faster follows the hand

}  // namespace

// The points of the chosen line that the scene states, as dots; its curvature as a comb.
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

// Where the shown handle goes in all frames, or the path that they follow, and where feet stand.
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

// The stated point under the hand, or -1.
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

// In the plane that lines are drawn on, or on the end of another line.
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

// Whether the surface can follow a dragged point now: it has followed the last move, and fast enough.
bool ShapeView::follows_point() const {
  return !detached_ && !awaits_move_ && view_->surface && move_ms_ < kFollowsWithinMs;
}

// Lines that meet at the point stay together, but with Shift. What came of a drag is one step.
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

// A double click on the chosen line puts a point there.
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
  // Between the stated points that come before and after it along the curve.
  const auto place_of = [&](const Vec3& p, size_t from) {
    size_t best = from;
    for (size_t i = from; i < curve.size(); ++i)
      if ((curve[i] - p).squaredNorm() < (curve[best] - p).squaredNorm()) best = i;
    return best;
  };
  size_t before = 0, place = 0;
  for (size_t i = 0; i + 1 < line_points_.size(); ++i) {
    place = place_of(line_points_[i], place);
    if (place <= nearest) before = i;
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

// As fine as a pixel.
Vec3 ShapeView::rounded_to_pixel(const Vec3& p) const {
  const Vec3 at = to_window(p);
  const double pixel = (from_window(at + Vec3::UnitX()) - from_window(at)).norm();
  constexpr double digits = 1e5;
  return rounded_point(p, digits * pixel);
}

}  // namespace batten::studio
