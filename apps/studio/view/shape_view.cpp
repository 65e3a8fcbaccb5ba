// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/studio/view/shape_view.h"

#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkCameraOrientationWidget.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkImplicitPlaneRepresentation.h>
#include <vtkImplicitPlaneWidget2.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkLight.h>
#include <vtkPlane.h>
#include <vtkProperty.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkWidgetRepresentation.h>

#include <QKeyEvent>
#include <QMouseEvent>
#include <QOpenGLContext>
#include <QOpenGLFunctions>
#include <QTimer>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "batten/apps/studio/view/gizmo.h"
#include "batten/apps/studio/view/rendering.h"
#include "batten/apps/studio/view/shape_colours.h"
#include "batten/apps/studio/view/strings.h"

namespace batten::studio {
namespace {

constexpr int kSamples = 4, kStillAfter = 150;  // ms without changes before antialiasing
const Vec3 kFromCorner(1, 1.6, -0.9);           // initial viewing direction
constexpr int kModeFrameMs = 33;                // ms per frame of the animation
constexpr double kModePhaseStep = 0.13;         // phase per frame, radians

void add_light(vtkRenderer& renderer, double x, double y, double z, double intensity) {
  vtkNew<vtkLight> light;
  light->SetLightTypeToCameraLight();
  light->SetPosition(x, y, z);
  light->SetIntensity(intensity);
  renderer.AddLight(light);
}

}  // namespace

ShapeView::ShapeView(QWidget* parent, Hooks hooks)
    : QVTKOpenGLNativeWidget(parent), hooks_(std::move(hooks)) {
  setRenderWindow(window_);
  window_->AddRenderer(renderer_);
  window_->SetMultiSamples(kSamples);
  renderer_->AutomaticLightCreationOff();
  add_light(*renderer_, -0.6, 0.8, 1, 0.8);
  add_light(*renderer_, 0, 0, 1, 0.45);
  add_light(*renderer_, 1, -0.2, 0.4, 0.25);
  add_light(*renderer_, 0.1, -1, 0.3, 0.15);
  renderer_->TwoSidedLightingOn();
  renderer_->GetActiveCamera()->ParallelProjectionOn();
  vtkNew<vtkInteractorStyleTrackballCamera> style;
  window_->GetInteractor()->SetInteractorStyle(style);
  actors_ = std::make_unique<ShapeActors>(renderer_);
  gizmo_ = std::make_unique<Gizmo>(renderer_);
  legend_ = std::make_unique<Legend>(renderer_);
  idle_timer_ = new QTimer(this);
  idle_timer_->setSingleShot(true);
  idle_timer_->setInterval(kStillAfter);
  QObject::connect(idle_timer_, &QTimer::timeout, this, [this] { redraw_antialiased(); });
  swing_ = new QTimer(this);
  swing_->setInterval(kModeFrameMs);
  QObject::connect(swing_, &QTimer::timeout, this, [this] {
    actors_->set_mode_phase(std::sin(kModePhaseStep * ++mode_frame_));
    redraw();
  });
  cube_->SetParentRenderer(renderer_);
  cube_->On();
  look_along(kFromCorner, Vec3::UnitZ());
  setMouseTracking(true);
  setFocusPolicy(Qt::StrongFocus);
  setMinimumSize(320, 240);
}

ShapeView::~ShapeView() = default;

// Mesa renders in software, where multisampling would triple the time per picture.
void ShapeView::initializeGL() {
  QVTKOpenGLNativeWidget::initializeGL();
  const auto* name = context()->functions()->glGetString(GL_RENDERER);
  software_ =
      name && std::string(reinterpret_cast<const char*>(name)).find("pipe") != std::string::npos;
  if (software_) window_->SetMultiSamples(0);
}

// Draws without antialiasing during motion; a still picture is antialiased later.
void ShapeView::redraw() {
  renderer_->ResetCameraClippingRange();
  legend_->set_scale(actors_->scale(), scale_title().toStdString());
  if (software_) {
    renderer_->UseFXAAOff();
    idle_timer_->start();
  }
  window_->Render();
}

void ShapeView::redraw_antialiased() {
  renderer_->UseFXAAOn();
  window_->Render();
}

void ShapeView::refresh(const DocumentWorker::Update& news) {
  const bool other = news.view && (!view_ || view_->document_number != news.view->document_number);
  if (news.view) {
    const bool was_empty = is_empty();
    view_ = news.view;
    if (other || was_empty != is_empty()) show_hint();
    actors_->refresh(*view_);
    if (other) fitted_ = false;
    const bool gone = !painted_name_.empty() && !view_->table({"select", painted_name_});
    if (view_->mesh && gone && !news.busy) painted_.clear();
    if (other) clicked_.reset();
    if (std::exchange(awaits_move_, false)) move_ms_ = since_move_.elapsed();
    if (other) move_ms_ = 0;
  }
  if (news.frame) actors_->refresh(*news.frame);
  if (news.stress) actors_->refresh(news.stress);
  if (!news.view && !news.frame && !news.stress) return;
  const bool anything = !is_empty();
  if (!anything) fitted_ = false;
  // Show the ground plane to draw on.
  if (other && !anything) look_along(kFromCorner, Vec3::UnitZ());
  if (!fitted_ && anything && draft_.empty()) {
    fitted_ = true;
    fit();
  }
  if (news.frame) follow_push();
  if (news.view) {
    show_handle();
    show_line();
    select_created();
    if (!stroke_) show_painted_area();
  }
  redraw();
}

void ShapeView::set_tool(Tool tool) {
  if (tool_ == Tool::Draw && draft_.size() > 1) finish_line();
  cancel_tool();
  tool_ = tool;
  painted_name_.clear();
  painted_.clear();
  const QCursor cursors[] = {Qt::ArrowCursor, Qt::PointingHandCursor, Qt::CrossCursor,
                             Qt::CrossCursor, Qt::CrossCursor,        Qt::CrossCursor,
                             Qt::CrossCursor};
  setCursor(cursors[static_cast<int>(tool)]);
  show_grid();
  show_handle();
  show_line();
  show_hint();
}

// Shows in the status bar what the user can do next.
void ShapeView::show_hint() {
  const bool mesh = view_ && view_->mesh;
  const bool empty = is_empty();
  const char* const hints[] = {mesh    ? kHintSelectMesh
                               : empty ? kHintEmpty
                                       : kHintSelect,
                               kHintPush,
                               kHintFixPoint,
                               view_ && view_->timeline ? kHintPath : kHintDraw,
                               mesh ? kHintPaint : kHintPaintArea,
                               kHintLasso,
                               kHintMeasure};
  hooks_.hint(text(hints[static_cast<int>(tool_)]));
}

void ShapeView::set_plane(DrawPlane plane) {
  plane_ = plane;
  show_grid();
}

// Shows the plane on which curves are drawn.
void ShapeView::show_grid() {
  const Vec3 axes[] = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  const int first = plane_ == DrawPlane::Yz ? 1 : 0, second = plane_ == DrawPlane::Xy ? 1 : 2;
  if (tool_ == Tool::Draw && plane_ != DrawPlane::View)
    actors_->set_grid(std::pair(axes[first], axes[second]));
  else
    actors_->set_grid(std::nullopt);
  redraw();
}

void ShapeView::set_shading(Shading shading) {
  actors_->set_shading(shading);
  redraw();
}

void ShapeView::set_dark(bool dark) {
  const Palette palette = dark ? Palette::dark() : Palette::light();
  actors_->set_palette(palette);
  gizmo_->set_palette(palette);
  legend_->set_palette(palette);
  redraw();
}

void ShapeView::set_section(bool shown) {
  actors_->set_clip_plane(shown ? clip_plane_.Get() : nullptr);
  if (!shown) {
    section_->Off();
    return redraw();
  }
  vtkNew<vtkImplicitPlaneRepresentation> plane;
  const auto [low, high] = actors_->box();
  double bounds[6] = {low.x(), high.x(), low.y(), high.y(), low.z(), high.z()};
  plane->SetPlaceFactor(1.1);
  plane->PlaceWidget(bounds);
  plane->SetOrigin(Vec3(0.5 * (low + high)).data());
  plane->SetNormal(1, 0, 0);
  plane->OutlineTranslationOff();
  plane->ScaleEnabledOff();
  plane->SetDrawOutline(false);
  plane->SetDrawPlane(true);
  plane->GetPlaneProperty()->SetOpacity(0.25);
  section_->SetInteractor(window_->GetInteractor());
  section_->SetRepresentation(plane);
  vtkNew<vtkCallbackCommand> moved;
  moved->SetClientData(this);
  moved->SetCallback([](vtkObject*, unsigned long, void* view, void*) {
    static_cast<ShapeView*>(view)->follow_section();
  });
  section_->AddObserver(vtkCommand::InteractionEvent, moved);
  section_->On();
  follow_section();
}

void ShapeView::follow_section() {
  if (auto* plane = vtkImplicitPlaneRepresentation::SafeDownCast(section_->GetRepresentation()))
    plane->GetPlane(clip_plane_);
  redraw();
}

// Title of the colour scale: the quantity and its unit, and the maximum if the scale is clipped.
QString ShapeView::scale_title() const {
  const Shading shading = actors_->shading();
  const auto [end, largest] = actors_->range();
  const bool mesh = view_ && view_->mesh;
  const QString length = view_ ? shown(view_->unit) : QString();
  const auto with_unit = [](const char* quantity, const QString& unit) {
    return text(quantity) + (unit.isEmpty() ? "" : " (" + unit + ")");
  };
  QString title;
  if (shading == Shading::Displacement)
    title = with_unit(mesh ? kDisplacementSinceRead : kDisplacementSinceOpened, length);
  if (shading == Shading::Strain) title = text(mesh ? kStrainSinceRead : kStrainSinceOpened);
  if (shading == Shading::Curvature)
    title = with_unit(kCurvatureScale, length.isEmpty() ? length : "1/" + length);
  if (shading == Shading::Stress && view_)
    title = with_unit(kStressScale, stress_unit(view_->unit));
  if (shading == Shading::Stress || shading == Shading::Curvature || shading == Shading::Strain)
    if (largest > 1.02 * end)
      title += "\n" + text(kClipped).arg(largest, 0, 'g', 3).arg(end, 0, 'g', 3);
  return title;
}

void ShapeView::set_text(const QString& overlay_text) {
  text_ = overlay_text;
  legend_->set_text(overlay_text.toStdString());
  redraw();
}

void ShapeView::set_paint(const std::string& kind) {
  paint_kind_ = kind;
  // The next stroke then creates an object of this kind.
  if (view_ && !painted_table().kind.empty()) select("");
}

void ShapeView::animate_mode(bool on) {
  mode_frame_ = 0;
  on ? swing_->start() : swing_->stop();
  actors_->set_mode_phase(1);
  redraw();
}

void ShapeView::set_mode(int mode) {
  actors_->set_mode(mode);
  redraw();
}

void ShapeView::set_mesh(bool shown) {
  actors_->set_mesh(shown);
  redraw();
}

void ShapeView::set_perspective(bool on) {
  renderer_->GetActiveCamera()->SetParallelProjection(!on);
  fit();
}

void ShapeView::select(const std::string& name) {
  selected_point_ = -1;
  selected_ = name;
  actors_->select(name);
  show_painted_area();
  show_handle();
  show_line();
  redraw();
}

void ShapeView::fit() {
  const auto [low, high] = actors_->box();
  const double bounds[6] = {low.x(), high.x(), low.y(), high.y(), low.z(), high.z()};
  renderer_->ResetCamera(bounds);
  vtkCamera* camera = renderer_->GetActiveCamera();
  if (camera->GetParallelProjection()) {
    const double aspect = height() > 0 ? static_cast<double>(width()) / height() : 1;
    camera->SetParallelScale(0.56 * (high - low).norm() / std::min(1.0, aspect));
  }
  redraw();
}

void ShapeView::look_along(const Vec3& direction, const Vec3& up) {
  vtkCamera* camera = renderer_->GetActiveCamera();
  const Vec3 focus = Vec3::Map(camera->GetFocalPoint());
  const Vec3 at = focus - direction.normalized() * camera->GetDistance();
  camera->SetPosition(at.x(), at.y(), at.z());
  camera->SetViewUp(up.x(), up.y(), up.z());
  fit();
}

// Mouse and keyboard events.

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
      if (on_axes(static_cast<QMouseEvent*>(event)->pos())) break;
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

// True if the mouse is on the axes widget in the corner, which orbits the view: in the circle that
// its viewport encloses. (The widget's own test picks in the last picture, which may be outdated.)
bool ShapeView::on_axes(const QPoint& at) const {
  vtkRenderer* axes = cube_->GetRepresentation()->GetRenderer();
  const Vec2 origin(axes->GetOrigin()[0], axes->GetOrigin()[1]);
  const Vec2 size(axes->GetSize()[0], axes->GetSize()[1]);
  return (display(at).head<2>() - origin - size / 2).norm() <= size.minCoeff() / 2;
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
        *hit, [this](const PickedPoint& surface_point) { clicked_ = surface_point; });
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
