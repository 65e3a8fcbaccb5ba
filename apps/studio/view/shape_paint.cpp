// Painting where loads and weights act on a surface.
#include <QLineF>
#include <algorithm>
#include <cmath>

#include "batten/apps/commands/documents/line_edits.h"
#include "batten/apps/studio/view/shape_view.h"

namespace batten::studio {
namespace {

constexpr double kBrushRadius = 22;  // pixels
constexpr const char* kPaintedKinds[] = {"load", "weight"};

}  // namespace

// The chosen load or weight, where a brush paints it.
SceneTable ShapeView::painted_table() const {
  const SceneText scene(view_->text);
  for (const char* kind : kPaintedKinds)
    if (!selected_.empty() && is_painted(scene, {kind, selected_})) return {kind, selected_};
  return {};
}

// What is painted of the chosen load or weight has the colour of what is chosen.
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

// Dabs lie half a radius apart; each asks where the surface is without loads, and the stroke ends when
// all answers are there.
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
        *p, [this, stroke = stroke_, radius](const SurfacePoint& surface_point) {
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

}  // namespace batten::studio
