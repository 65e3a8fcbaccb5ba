// The 3-D view and what the mouse does in it.
#pragma once

#include <QVTKOpenGLNativeWidget.h>
#include <vtkNew.h>
#include <QElapsedTimer>

#include <functional>
#include <memory>
#include <optional>

#include "batten/apps/commands/documents/document_worker.h"
#include "batten/apps/commands/documents/line_edits.h"
#include "batten/apps/commands/documents/load_edits.h"
#include "batten/apps/studio/view/shape_actors.h"

class QMouseEvent;
class QTimer;
class vtkGenericOpenGLRenderWindow;
class vtkRenderer;
class vtkCameraOrientationWidget;
class vtkImplicitPlaneWidget2;
class vtkPlane;

namespace batten::studio {

class Gizmo;
class Legend;

/// What the left button does.
enum class Tool {
  Select,  ///< a click chooses a line or region, a drag turns the view
  Push,  ///< a press on the surface is a point load along the normal: the surface follows the hand
  FixPoint,  ///< a click on the surface holds it there; arrows then move the place
  Draw,      ///< clicks are points of a line; a double click or Enter ends it
  Paint,  ///< a brush, with Shift one that takes away: nodes of a mesh, or where a load or weight acts
  Lasso,   ///< the same with a line around them
  Measure  ///< two clicks: how far it is from one to the other
};

/// The plane that lines are drawn on, through the first point of the line or the origin.
enum class DrawPlane { Xy, Xz, Yz, View };

/// Draws a document and turns the mouse into commands. Everything that it does to the document goes
/// through `Hooks::post`.
class ShapeView : public QVTKOpenGLNativeWidget {
 public:
  struct Hooks {
    std::function<void(DocumentCommand)> post;
    std::function<void(const Vec3&, std::function<void(const SurfacePoint&)>)> query_surface_point;
    std::function<void(const std::string& line, const std::string& region)> selected;
    std::function<void(const QString&)> hint;  ///< what can be done next, for the status bar
  };
  ShapeView(QWidget* parent, Hooks hooks);
  ~ShapeView() override;

  void refresh(const DocumentWorker::Update& news);
  void set_tool(Tool tool);
  void show_hint();  ///< what can be done next
  Tool tool() const { return tool_; }
  void set_plane(DrawPlane plane);
  void set_shading(Shading shading);
  void set_dark(bool dark);
  void set_mesh(bool shown);
  void set_perspective(bool on);
  /// What a brush makes where no load or weight is chosen: "pressure", "alpha" or "beta".
  void set_paint(const std::string& kind);
  /// Lets the natural mode swing that is shown, or stand at its largest.
  void animate_mode(bool on);
  void set_mode(int mode);
  /// The curvature of the chosen line as a comb.
  void set_combs(bool shown);
  /// A plane that cuts away what is before it, with an arrow and a face to move it by.
  void set_section(bool shown);
  /// Words over the view.
  void set_text(const QString& overlay_text);
  const QString& overlay_text() const { return text_; }
  /// The chosen point of the chosen line, counted from 0; -1: none.
  int selected_point() const { return selected_point_; }
  /// The place of the surface that was clicked last; none before.
  const std::optional<SurfacePoint>& clicked() const { return clicked_; }
  /// Takes the chosen point out of its line; false where there is none.
  bool remove_point();
  /// A line, region or part of a mesh.
  void select(const std::string& name);
  /// Shows all, from the direction in which the camera looks.
  void fit();
  void look_along(const Vec3& direction, const Vec3& up);
  void finish_line();
  /// Takes back what the hand has begun and not ended: a push, the last point of a line; false where
  /// there is no such thing.
  bool undo_pending();
  void cancel_tool();

  /// The point of the window, Qt's logical pixels, that shows a place: for tests and tours.
  QPoint pixel_of(const Vec3& p) const;
  const ShapeActors& actors() const { return *actors_; }
  const Gizmo& gizmo() const { return *gizmo_; }

 protected:
  bool event(QEvent* event) override;
  void initializeGL() override;

 private:
  struct Push {
    std::string name;
    Vec3 unloaded, normal, start;
    int point = -1;         // of the display
    double value = 0;       // that the load has
    double compliance = 0;  // of the point along the normal; 0: not known yet
    double wanted = 0;      // displacement
    QPoint from;
    bool placed = false;
  };
  bool press(QMouseEvent* event);
  bool move(QMouseEvent* event);
  bool release(QMouseEvent* event);
  bool on_axes(const QPoint& at) const;
  bool press_brush(QMouseEvent* event);
  bool key(int key);
  void click(const QPoint& at, bool shift);
  void show_value(const QPoint& at);
  void start_push(const QPoint& at);
  void start_load(const SurfacePoint& place);
  void follow_push();
  void fix_point(const QPoint& at, bool normal);
  void end_push();
  void cancel_push();
  void draw_point(const QPoint& at);
  void measure_point(const QPoint& at);
  Vec3 point_at(const QPoint& at) const;
  std::optional<Vec3> snapped(const QPoint& at) const;
  const DocumentView::Handle* shown_handle() const;
  void show_handle();
  bool press_handle(const QPoint& at);
  void drag_handle(const QPoint& at);
  void release_handle();
  void start_painting();
  void paint(const QPoint& at, bool erases);
  void dab(const QPoint& at, bool erases);
  void draw_lasso(const QPoint& at);
  void close_lasso(bool erases);
  void finish_stroke();
  void select_created();
  struct Stroke {
    SceneTable table;  // that it is painted of; none: a new one
    bool erases = false, ended = false;
    int asked = 0;  // of dabs
    std::vector<BrushDab> dabs;
  };
  SceneTable painted_table() const;
  void show_painted_area();
  void mark_near(const Vec3& unloaded, double radius, bool on);
  void start_stroke(bool erases);
  void paint_area(const QPoint& at);
  void end_stroke();
  void take_stroke(const Stroke& stroke);
  void show_line();
  void show_dots();
  void show_path();
  int point_under(const QPoint& at) const;
  bool press_point(const QPoint& at, bool detached);
  void drag_point(const QPoint& at);
  void release_point();
  bool follows_point() const;
  Vec3 on_plane(const QPoint& at, const Vec3& through) const;
  bool add_point(const QPoint& at);
  Vec3 rounded_to_pixel(const Vec3& p) const;
  Vec3 to_window(const Vec3& p) const;  // renderer's pixels and depth
  Vec3 from_window(const Vec3& window) const;
  Vec3 display(const QPoint& at) const;
  void show_grid();
  QString scale_title() const;
  bool is_empty() const { return !view_ || (view_->lines.empty() && !view_->surface); }
  void follow_section();
  void redraw();
  void redraw_antialiased();

  Hooks hooks_;
  vtkNew<vtkGenericOpenGLRenderWindow> window_;
  vtkNew<vtkRenderer> renderer_;
  vtkNew<vtkCameraOrientationWidget> cube_;
  vtkNew<vtkImplicitPlaneWidget2> section_;
  vtkNew<vtkPlane> clip_plane_;
  std::unique_ptr<ShapeActors> actors_;
  std::shared_ptr<const DocumentView> view_;
  Tool tool_ = Tool::Select;
  DrawPlane plane_ = DrawPlane::Xy;
  std::vector<Vec3> draft_;
  std::vector<bool> snapped_;
  std::shared_ptr<Push> push_;
  std::unique_ptr<Gizmo> gizmo_;
  std::unique_ptr<Legend> legend_;
  DocumentView::Handle dragged_handle_;  // what the hand has moved the shown handle to
  std::vector<char> painted_;            // of each display point
  std::string painted_name_;             // of the selection that strokes add to
  std::vector<QPoint> lasso_;
  std::shared_ptr<Stroke> stroke_;
  std::string paint_kind_ = "pressure";
  std::optional<SurfacePoint> clicked_;
  QTimer* swing_ = nullptr;
  int mode_frame_ = 0;             // pictures since a mode began to swing
  std::vector<Vec3> line_points_;  // that the scene states of the chosen line
  LineKey line_key_ = LineKey::None;
  int selected_point_ = -1, moved_point_ = -1;
  Vec3 point_before_ = Vec3::Zero();  // where the moved one was
  bool detached_ = false;             // it moves without lines that meet there
  bool awaits_move_ = false;          // the surface has not followed yet
  QElapsedTimer since_move_;
  qint64 move_ms_ = 0;  // that the surface took to follow the last time
  bool combs_ = false;
  QString text_;
  std::string selected_, created_;
  std::string defining_line_;  // the [[line]] that the chosen one is or is a piece of
  QPoint pressed_, brushed_;
  QTimer* idle_timer_ = nullptr;
  bool software_ = false;  // OpenGL on the processor
  bool left_ = false, moved_ = false, fitted_ = false, brushing_ = false;
};

}  // namespace batten::studio
