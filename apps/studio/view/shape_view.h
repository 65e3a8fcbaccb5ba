// SPDX-License-Identifier: MPL-2.0
// The 3-D view of a document, and its mouse tools.
#pragma once

#include <QVTKOpenGLNativeWidget.h>
#include <vtkNew.h>
#include <QElapsedTimer>

#include <functional>
#include <memory>
#include <optional>

#include "batten/apps/documents/document_worker.h"
#include "batten/apps/documents/line_edits.h"
#include "batten/apps/documents/load_edits.h"
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

/// Tools of the left mouse button.
enum class Tool {
  Select,  ///< a click selects a curve or region, a drag orbits the view
  /// A drag on the surface applies a point load along the normal: the surface follows the mouse.
  Push,
  FixPoint,  ///< a click on the surface adds a position constraint, which arrows then move
  Draw,      ///< clicks add points of a curve; a double click or Enter ends it
  /// A brush for nodes of a mesh, or for the area of a load or stiffness field; Shift erases.
  Paint,
  Lasso,   ///< the same with a closed curve around the nodes
  Measure  ///< two clicks measure a distance
};

/// Plane on which curves are drawn, through the first point of the curve or the origin.
enum class DrawPlane { Xy, Xz, Yz, View };

/// Draws a document and converts mouse and key events to commands. All changes of the document go
/// through `Hooks::post`.
class ShapeView : public QVTKOpenGLNativeWidget {
 public:
  /// Callbacks to the main window.
  struct Hooks {
    std::function<void(DocumentCommand)> post;
    std::function<void(const Vec3&, std::function<void(const PickedPoint&)>)> query_surface_point;
    std::function<void(const std::string& line, const std::string& region)> selected;
    /// Shows in the status bar what the user can do next.
    std::function<void(const QString&)> hint;
  };
  ShapeView(QWidget* parent, Hooks hooks);
  ~ShapeView() override;

  void refresh(const DocumentWorker::Update& news);
  void set_tool(Tool tool);
  void show_hint();  ///< shows what the user can do next
  Tool tool() const { return tool_; }
  void set_plane(DrawPlane plane);
  void set_shading(Shading shading);
  void set_dark(bool dark);
  void set_mesh(bool shown);
  void set_perspective(bool on);
  /// Kind of the object that the brush creates if no load or stiffness field is selected:
  /// "pressure", "alpha" or "beta".
  void set_paint(const std::string& kind);
  /// Animates the mode shape, or shows it at its largest amplitude.
  void animate_mode(bool on);
  void set_mode(int mode);
  /// Shows the curvature comb of the selected curve.
  void set_combs(bool shown);
  /// Shows a section plane that hides everything in front of it, with handles to move it.
  void set_section(bool shown);
  /// Shows a text over the view.
  void set_text(const QString& overlay_text);
  const QString& overlay_text() const { return text_; }
  /// Selected point of the selected curve, 0-based; -1: none.
  int selected_point() const { return selected_point_; }
  /// Point of the surface that was clicked last; empty: none.
  const std::optional<PickedPoint>& clicked() const { return clicked_; }
  /// Removes the selected point from its curve. Returns false if there is none.
  bool remove_point();
  /// Selects a curve, region or part of a mesh by name.
  void select(const std::string& name);
  /// Zooms to fit; keeps the viewing direction.
  void fit();
  void look_along(const Vec3& direction, const Vec3& up);
  void finish_line();
  /// Cancels an unfinished action: a load being dragged, or the last point of a curve being drawn.
  /// Returns false if there is none.
  bool undo_pending();
  void cancel_tool();

  /// Pixel (Qt logical pixels) at which a model point is shown; for tests and tours.
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
    int point = -1;         // index of the display point
    double value = 0;       // current value of the load
    double compliance = 0;  // displacement along the normal per unit of load; 0: unknown
    double wanted = 0;      // displacement at the mouse position
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
  void start_load(const PickedPoint& place);
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
    SceneTable table;  // load or stiffness field that is painted; empty: a new one
    bool erases = false, ended = false;
    int asked = 0;  // number of brush dabs requested
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
  DocumentView::Handle dragged_handle_;  // current pose of the handle during a drag
  std::vector<char> painted_;            // by display point
  std::string painted_name_;             // selection to which strokes are added
  std::vector<QPoint> lasso_;
  std::shared_ptr<Stroke> stroke_;
  std::string paint_kind_ = "pressure";
  std::optional<PickedPoint> clicked_;
  QTimer* swing_ = nullptr;
  int mode_frame_ = 0;             // frames since the animation started
  std::vector<Vec3> line_points_;  // points of the selected curve, as defined in the scene
  LineKey line_key_ = LineKey::None;
  int selected_point_ = -1, moved_point_ = -1;
  Vec3 point_before_ = Vec3::Zero();  // position of the dragged point before
  bool detached_ = false;             // curves that meet there do not move along
  bool awaits_move_ = false;          // the surface has not followed the last move yet
  QElapsedTimer since_move_;
  qint64 move_ms_ = 0;  // time that the surface needed to follow the last move
  bool combs_ = false;
  QString text_;
  std::string selected_, created_;
  // The [[curve]] that defines the selected curve, or of which it is a segment.
  std::string defining_line_;
  QPoint pressed_, brushed_;
  QTimer* idle_timer_ = nullptr;
  bool software_ = false;  // OpenGL is emulated in software
  bool left_ = false, moved_ = false, fitted_ = false, brushing_ = false;
};

}  // namespace batten::studio
