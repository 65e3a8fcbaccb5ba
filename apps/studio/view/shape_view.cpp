#include "batten/apps/studio/view/shape_view.h"

#include <vtkCamera.h>
#include <vtkCameraOrientationWidget.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkLight.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>

#include <QKeyEvent>
#include <QMouseEvent>
#include <algorithm>
#include <cmath>

#include "batten/apps/studio/texts.h"

namespace batten::studio {
namespace {

using Verb = DocumentCommand::Verb;
constexpr int kClick = 4;     // a press that moves by fewer pixels is a click
constexpr double kSnap = 12;  // pixels

void add_light(vtkRenderer& renderer, double x, double y, double z, double intensity) {
  vtkNew<vtkLight> light;
  light->SetLightTypeToCameraLight();
  light->SetPosition(x, y, z);
  light->SetIntensity(intensity);
  renderer.AddLight(light);
}

std::string vector_word(const Vec3& v) {
  return "[" + SceneText::word(v.x()) + ", " + SceneText::word(v.y()) + ", " +
         SceneText::word(v.z()) + "]";
}

/// As many digits as the hand can mean: a millionth of the size.
Vec3 rounded(const Vec3& p, double size) {
  const double step = std::pow(10, std::floor(std::log10(std::max(size, 1e-12))) - 5);
  Vec3 r;
  for (int i = 0; i < 3; ++i) r[i] = std::stod(number(std::round(p[i] / step) * step));
  return r;
}

}  // namespace

ShapeView::ShapeView(QWidget* parent, Hooks hooks)
    : QVTKOpenGLNativeWidget(parent), hooks_(std::move(hooks)) {
  setRenderWindow(window_);
  window_->AddRenderer(renderer_);
  window_->SetMultiSamples(4);
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
  cube_->SetParentRenderer(renderer_);
  cube_->On();
  look({1, 1.6, -0.9}, Vec3::UnitZ());
  setMouseTracking(true);
  setFocusPolicy(Qt::StrongFocus);
  setMinimumSize(320, 240);
}

ShapeView::~ShapeView() = default;

void ShapeView::redraw() { window_->Render(); }

void ShapeView::take(const DocumentWorker::News& news) {
  if (news.view) {
    const bool other = !view_ || view_->title != news.view->title;
    view_ = news.view;
    actors_->take(*view_);
    if (other) fitted_ = false;
  }
  if (news.frame) actors_->take(*news.frame);
  if (!news.view && !news.frame) return;
  if (!fitted_ && view_ && !view_->lines.empty() && draft_.empty()) {
    fitted_ = true;
    fit();
  }
  if (news.frame) follow_push();
  redraw();
}

void ShapeView::set_tool(Tool tool) {
  cancel_tool();
  tool_ = tool;
  const QCursor cursors[] = {Qt::ArrowCursor, Qt::PointingHandCursor, Qt::CrossCursor};
  setCursor(cursors[static_cast<int>(tool)]);
  const char* const hints[] = {kHintSelect, kHintPush, kHintDraw};
  hooks_.hint(text(hints[static_cast<int>(tool)]));
}

void ShapeView::set_plane(DrawPlane plane) { plane_ = plane; }

void ShapeView::set_shading(Shading shading) {
  actors_->set_shading(shading);
  redraw();
}

void ShapeView::set_dark(bool dark) {
  actors_->set_palette(dark ? Palette::dark() : Palette::light());
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

void ShapeView::choose(const std::string& line) {
  actors_->choose(line);
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

void ShapeView::look(const Vec3& direction, const Vec3& up) {
  vtkCamera* camera = renderer_->GetActiveCamera();
  const Vec3 focus = Vec3::Map(camera->GetFocalPoint());
  const Vec3 at = focus - direction.normalized() * camera->GetDistance();
  camera->SetPosition(at.x(), at.y(), at.z());
  camera->SetViewUp(up.x(), up.y(), up.z());
  fit();
}

// -- the mouse --------------------------------------------------------------------------------------

Vec3 ShapeView::display(const QPoint& at) const {
  const double ratio = devicePixelRatioF();
  return {at.x() * ratio, (height() - 1 - at.y()) * ratio, 0};
}

Vec3 ShapeView::to_window(const Vec3& p) const {
  renderer_->SetWorldPoint(p.x(), p.y(), p.z(), 1);
  renderer_->WorldToDisplay();
  Vec3 window;
  renderer_->GetDisplayPoint(window.data());
  return window;
}

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
      }
      break;
    case QEvent::KeyPress:
      taken = key(static_cast<QKeyEvent*>(event)->key());
      break;
    default:
      break;
  }
  return taken || QVTKOpenGLNativeWidget::event(event);
}

bool ShapeView::press(QMouseEvent* event) {
  setFocus();
  if (event->button() != Qt::LeftButton) return false;
  pressed_ = event->pos();
  left_ = true;
  moved_ = false;
  if (tool_ != Tool::Push) return false;
  const Vec3 at = display(event->pos());
  if (!actors_->surface_at(at.x(), at.y())) return false;
  start_push(event->pos());
  return true;
}

bool ShapeView::move(QMouseEvent* event) {
  if (left_ && (event->pos() - pressed_).manhattanLength() > kClick) moved_ = true;
  if (push_) {
    const Vec3 from = to_window(push_->start);
    const Vec3 along = to_window(push_->start + push_->normal) - from;
    const Vec3 hand = display(event->pos()) - display(push_->from);
    const Vec2 axis = along.head<2>();
    // Towards the eye a normal is a point in the window: up then is out.
    const double scale = renderer_->GetActiveCamera()->GetParallelScale() * 2 / height();
    constexpr double short_axis = 0.25;
    push_->wanted = axis.norm() * scale > short_axis ? axis.dot(hand.head<2>()) / axis.squaredNorm()
                                                     : hand.y() * scale;
    follow_push();
    return true;
  }
  if (tool_ == Tool::Draw && !left_ && !draft_.empty()) {
    std::vector<Vec3> shown = draft_;
    shown.push_back(point_at(event->pos()));
    actors_->set_draft(shown);
    redraw();
  }
  return false;
}

bool ShapeView::release(QMouseEvent* event) {
  if (event->button() != Qt::LeftButton) return false;
  left_ = false;
  if (push_) {
    end_push();
    return true;
  }
  if (!moved_) click(event->pos());
  return false;
}

void ShapeView::click(const QPoint& at) {
  if (tool_ == Tool::Draw) return draw_point(at);
  const Vec3 p = display(at);
  const std::string line = actors_->line_at(p.x(), p.y());
  const std::string region = line.empty() ? actors_->region_at(p.x(), p.y()) : "";
  choose(line);
  hooks_.chosen(line, region);
}

bool ShapeView::key(int key) {
  if (key == Qt::Key_Escape) {
    cancel_tool();
    return true;
  }
  if (tool_ != Tool::Draw) return false;
  if (key == Qt::Key_Return || key == Qt::Key_Enter) {
    finish_line();
    return true;
  }
  if (key == Qt::Key_Backspace && !draft_.empty()) {
    draft_.pop_back();
    actors_->set_draft(draft_);
    redraw();
    return true;
  }
  return false;
}

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
  hooks_.ask_place(*p, [this, waiting](const Document::Place& place) {
    if (waiting.lock()) place_push(place);
  });
}

// The load is there, at 0; one unit of it then shows how far the surface gives way.
void ShapeView::place_push(const Document::Place& place) {
  Push& push = *push_;
  push.start = place.present;
  push.normal = place.normal;
  push.held = place.held;
  push.point = actors_->point_near(place.present);
  push.start = actors_->point(push.point);
  push.placed = true;
  push.value = 1;
  hooks_.post({.verb = Verb::Add,
               .table = {"load", ""},
               .text = "{ name = " + SceneText::word(push.name) +
                       ", type = \"point\", at = " + vector_word(rounded(place.held, view_->size)) +
                       ", direction = " + vector_word(rounded(place.normal, 1)) + ", value = 0 }"});
  hooks_.post({.verb = Verb::Slide, .key = push.name, .value = push.value});
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
  const double value = std::stod(number(push.wanted / push.compliance));
  if (value == push.value) return;
  push.value = value;
  hooks_.post({.verb = Verb::Slide, .key = push.name, .value = value});
}

void ShapeView::end_push() {
  const bool placed = push_->placed;
  push_.reset();
  actors_->set_push(std::nullopt);
  if (placed) hooks_.post({.verb = Verb::Settle});
}

// -- drawing ----------------------------------------------------------------------------------------

std::optional<Vec3> ShapeView::snapped(const QPoint& at) const {
  const Vec3 hand = display(at);
  double least = kSnap * devicePixelRatioF();
  std::optional<Vec3> best;
  const auto offer = [&](const Vec3& p) {
    const double d = (to_window(p) - hand).head<2>().norm();
    if (d >= least) return;
    least = d;
    best = p;
  };
  if (view_)
    for (const auto& line : view_->lines) {
      offer(line.points.front());
      offer(line.points.back());
    }
  if (draft_.size() > 1) offer(draft_.front());
  return best;
}

Vec3 ShapeView::point_at(const QPoint& at) const {
  if (const auto end = snapped(at)) return *end;
  const Vec3 hand = display(at);
  if (const auto p = actors_->surface_at(hand.x(), hand.y())) return *p;
  const auto world = [&](double depth) {
    double w[4];
    renderer_->SetDisplayPoint(hand.x(), hand.y(), depth);
    renderer_->DisplayToWorld();
    renderer_->GetWorldPoint(w);
    return Vec3(w[0] / w[3], w[1] / w[3], w[2] / w[3]);
  };
  const Vec3 near = world(0), along = (world(1) - near).normalized();
  Vec3 normal = plane_ == DrawPlane::Xy   ? Vec3::UnitZ()
                : plane_ == DrawPlane::Xz ? Vec3::UnitY()
                : plane_ == DrawPlane::Yz ? Vec3::UnitX()
                                          : along;
  constexpr double grazing = 0.05;
  if (std::abs(normal.dot(along)) < grazing) normal = along;
  const Vec3 through = draft_.empty() ? Vec3(Vec3::Zero()) : draft_.front();
  const Vec3 p = near + along * ((through - near).dot(normal) / along.dot(normal));
  const auto [low, high] = actors_->box();
  return rounded(p, (high - low).norm());
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

void ShapeView::finish_line() {
  std::vector<Vec3> points = std::move(draft_);
  draft_.clear();
  actors_->set_draft({});
  redraw();
  if (points.size() < 2) return;
  std::string list;
  for (const Vec3& p : points) list += (list.empty() ? "" : ", ") + vector_word(p);
  hooks_.post({.verb = Verb::Add,
               .table = {"line", ""},
               .text = "{ name = " + SceneText::word(view_->free_name("line")) + ", points = [" +
                       list + "] }"});
  hooks_.hint(text(kHintDraw));
}

void ShapeView::cancel_tool() {
  draft_.clear();
  actors_->set_draft({});
  if (push_) end_push();
  redraw();
}

}  // namespace batten::studio
