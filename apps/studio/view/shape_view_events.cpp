// Mouse and keyboard events of the 3-D view.
#include <vtkCamera.h>
#include <vtkCameraOrientationRepresentation.h>
#include <vtkCameraOrientationWidget.h>
#include <vtkRenderer.h>

#include <QKeyEvent>
#include <QMouseEvent>
#include <cmath>

#include "batten/apps/studio/view/gizmo.h"
#include "batten/apps/studio/view/screen_points.h"
#include "batten/apps/studio/view/shape_colours.h"
#include "batten/apps/studio/view/shape_view.h"
#include "batten/apps/studio/view/strings.h"

namespace batten::studio {
namespace {

constexpr int kClick = 4;  // pixels: a press with less motion is a click

}  // namespace

Vec3 ShapeView::display(const QPoint& at) const {
  const double ratio = devicePixelRatioF();
  return {at.x() * ratio, (height() - 1 - at.y()) * ratio, 0};
}

Vec3 ShapeView::to_window(const Vec3& p) const { return to_display(*renderer_, p); }
Vec3 ShapeView::from_window(const Vec3& window) const { return to_world(*renderer_, window); }

QPoint ShapeView::pixel_of(const Vec3& p) const {
  const Vec3 window = to_window(p) / devicePixelRatioF();
  return {static_cast<int>(std::lround(window.x())),
          height() - 1 - static_cast<int>(std::lround(window.y()))};
}

bool ShapeView::event(QEvent* event) {
  bool taken = false;
  switch (event->type()) {
    case QEvent::MouseButtonPress:
      taken = press(static_cast<QMouseEvent*>(event));
      break;
    case QEvent::MouseMove:
      taken = move(static_cast<QMouseEvent*>(event));
      break;
    case QEvent::MouseButtonRelease:
      taken = release(static_cast<QMouseEvent*>(event));
      break;
    case QEvent::MouseButtonDblClick:
      if (tool_ == Tool::Draw) {
        finish_line();
        taken = true;
      } else {
        taken = add_point(static_cast<QMouseEvent*>(event)->pos());
      }
      break;
    case QEvent::KeyPress:
      if (key(static_cast<QKeyEvent*>(event)->key())) return true;
      return QOpenGLWidget::event(event);  // letters are shortcuts in VTK
    case QEvent::KeyRelease:
      return QOpenGLWidget::event(event);
    default:
      break;
  }
  return taken || QVTKOpenGLNativeWidget::event(event);
}

bool ShapeView::press(QMouseEvent* event) {
  setFocus();
  if (event->button() != Qt::LeftButton || on_axes(event->pos())) return false;
  pressed_ = event->pos();
  left_ = true;
  moved_ = false;
  if (press_handle(event->pos()) ||
      press_point(event->pos(), event->modifiers().testFlag(Qt::ShiftModifier)))
    return true;
  if (tool_ == Tool::Paint || tool_ == Tool::Lasso) return press_brush(event);
  if (tool_ != Tool::Push) return false;
  const Vec3 at = display(event->pos());
  if (!actors_->surface_at(at.x(), at.y())) return false;
  start_push(event->pos());
  return true;
}

// True if the mouse is on the axes widget in the corner, which orbits the view.
bool ShapeView::on_axes(const QPoint& at) const {
  const Vec3 p = display(at);
  auto* axes = vtkCameraOrientationRepresentation::SafeDownCast(cube_->GetRepresentation());
  return axes &&
         axes->ComputeInteractionState(static_cast<int>(p.x()), static_cast<int>(p.y())) !=
             static_cast<int>(vtkCameraOrientationRepresentation::InteractionStateType::Outside);
}

// Starts a brush stroke. Beside the surface a brush orbits the view instead; a lasso can start
// anywhere.
bool ShapeView::press_brush(QMouseEvent* event) {
  const Vec3 at = display(event->pos());
  if (!view_ || !view_->surface) return false;
  if (tool_ == Tool::Paint && !actors_->surface_at(at.x(), at.y())) return false;
  brushing_ = true;
  brushed_ = event->pos();
  if (!view_->mesh) {
    start_stroke(event->modifiers().testFlag(Qt::ShiftModifier));
    paint_area(event->pos());
    return true;
  }
  start_painting();
  if (tool_ == Tool::Paint)
    paint(event->pos(), event->modifiers().testFlag(Qt::ShiftModifier));
  else
    draw_lasso(event->pos());
  return true;
}

bool ShapeView::move(QMouseEvent* event) {
  if (left_ && (event->pos() - pressed_).manhattanLength() > kClick) moved_ = true;
  if (left_ && gizmo_->pressed()) {
    drag_handle(event->pos());
    return true;
  }
  if (left_ && moved_point_ >= 0) {
    if (moved_) drag_point(event->pos());
    return true;
  }
  if (left_ && brushing_) {
    const bool erases = event->modifiers().testFlag(Qt::ShiftModifier);
    if (stroke_)
      paint_area(event->pos());
    else
      tool_ == Tool::Paint ? paint(event->pos(), erases) : draw_lasso(event->pos());
    return true;
  }
  if (push_) {
    const Vec3 from = to_window(push_->start);
    const Vec3 along = to_window(push_->start + push_->normal) - from;
    const Vec3 pixel = display(event->pos()) - display(push_->from);
    const Vec2 axis = along.head<2>();
    // A normal that points at the viewer is a single point in the window: moving up then means
    // outwards.
    const double scale = renderer_->GetActiveCamera()->GetParallelScale() * 2 / height();
    constexpr double short_axis = 0.25;
    push_->wanted = axis.norm() * scale > short_axis
                        ? axis.dot(pixel.head<2>()) / axis.squaredNorm()
                        : pixel.y() * scale;
    follow_push();
    return true;
  }
  if (tool_ == Tool::Select && event->buttons() == Qt::NoButton) show_value(event->pos());
  if (tool_ == Tool::Draw && !left_ && !draft_.empty()) {
    std::vector<Vec3> shown = draft_;
    shown.push_back(point_at(event->pos()));
    actors_->set_draft(shown);
    redraw();
  }
  return false;
}

bool ShapeView::release(QMouseEvent* event) {
  // The second release of a double click has no press of its own.
  if (event->button() != Qt::LeftButton || !left_) return false;
  left_ = false;
  if (gizmo_->pressed()) {
    release_handle();
    return true;
  }
  if (moved_point_ >= 0) {
    release_point();
    return true;
  }
  if (brushing_) {
    brushing_ = false;
    if (stroke_) {
      end_stroke();
      return true;
    }
    if (tool_ == Tool::Lasso) close_lasso(event->modifiers().testFlag(Qt::ShiftModifier));
    finish_stroke();
    return true;
  }
  if (push_) {
    end_push();
    return true;
  }
  if (!moved_) click(event->pos(), event->modifiers().testFlag(Qt::ShiftModifier));
  return false;
}

// Shows the value of the scalar field under the mouse.
void ShapeView::show_value(const QPoint& at) {
  if (!actors_->has_scalar_field()) return;
  const Vec3 pixel = display(at);
  const auto p = actors_->surface_at(pixel.x(), pixel.y());
  const auto value = p ? actors_->value_at(*p) : std::nullopt;
  hooks_.hint(value ? QString::number(*value, 'g', 4) : QString());
}

void ShapeView::click(const QPoint& at, bool shift) {
  if (tool_ == Tool::Draw) return draw_point(at);
  if (tool_ == Tool::Measure) return measure_point(at);
  if (tool_ == Tool::FixPoint) return fix_point(at, shift);
  const Vec3 p = display(at);
  const std::string line = actors_->line_at(p.x(), p.y());
  const std::string region = line.empty() ? actors_->region_at(p.x(), p.y()) : "";
  select(line.empty() ? region : line);
  if (const auto hit = actors_->surface_at(p.x(), p.y()); hit && !view_->mesh)
    hooks_.query_surface_point(
        *hit, [this](const SurfacePoint& surface_point) { clicked_ = surface_point; });
  hooks_.selected(line, region);
  if (!line.empty() && line_points_.empty() && !view_->mesh) hooks_.hint(text(kHintCurveFromFile));
}

bool ShapeView::key(int key) {
  if (key == Qt::Key_Escape) {
    if (push_) cancel_push();
    cancel_tool();
    return true;
  }
  if (tool_ != Tool::Draw) return false;
  if (key == Qt::Key_Return || key == Qt::Key_Enter) {
    finish_line();
    return true;
  }
  return key == Qt::Key_Backspace && undo_pending();
}

bool ShapeView::undo_pending() {
  if (push_) {
    cancel_push();
    return true;
  }
  if (tool_ == Tool::Draw && !draft_.empty()) {
    draft_.pop_back();
    actors_->set_draft(draft_);
    redraw();
    return true;
  }
  return gizmo_->pressed() || moved_point_ >= 0;  // release these first
}

}  // namespace batten::studio
