// SPDX-License-Identifier: MPL-2.0
// VTK actors that draw a document: surface, curves, loads, supports and interactive previews.
#pragma once

#include <vtkSmartPointer.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/apps/documents/document_view.h"
#include "batten/apps/studio/view/shape_colours.h"
#include "batten/sculpting/session/session_results.h"

class vtkCellArray;
class vtkFloatArray;
class vtkIntArray;
class vtkPlane;
class vtkLookupTable;
class vtkRenderer;

namespace batten::studio {

struct Layer;

/// Quantity that the surface colours show.
enum class Shading {
  Shaded,
  Regions,
  Zebra,         ///< stripes of equal angle between the normal and a direction
  Contours,      ///< bands of equal height (z)
  Displacement,  ///< distance from the position at the time of meshing
  Curvature,     ///< mean curvature, positive if the surface is concave on the normal's side
  Strain,        ///< principal strain of largest magnitude since meshing
  Stress,        ///< von Mises stress, on the deformed shape
  Modes          ///< selected mode shape, by its displacement
};

/// The actors of one renderer. A new frame costs one copy of its points and normals and, with some
/// shadings, one scalar per point. Facets and lines are rebuilt only if the mesh changes.
class ShapeActors {
 public:
  explicit ShapeActors(vtkRenderer* renderer);
  ~ShapeActors();

  void refresh(const DocumentView& view);
  void refresh(const Frame& frame);
  void refresh(std::shared_ptr<const StressView> stress);
  void set_shading(Shading shading);
  void set_palette(const Palette& palette);
  void set_mesh(bool shown);  ///< shows the mesh edges
  /// Highlights the curve, region or part of a mesh with this name; "": none.
  void select(const std::string& name);
  /// Highlights the facets whose points are all marked, until the next selection.
  void show_painted(const std::vector<char>& points);
  /// Display points whose position on the unloaded surface is within `radius` of `centre`.
  std::vector<int> unloaded_within(const Vec3& centre, double radius) const;
  /// Shows the points of a curve that is being drawn, including one at the mouse position.
  void set_draft(const std::vector<Vec3>& points);
  /// Shows editable points as dots; `selected`: the selected one (-1: none); `joined`: by a
  /// polyline.
  void set_dots(const std::vector<Vec3>& points, int selected, bool joined);
  /// Shows a curvature comb along points of a curve, scaled so that its height is 0.15 of the curve
  /// length.
  void set_comb(const std::vector<Vec3>& curve);
  /// Shows a path through the frames of a sequence; replaces the comb.
  void set_path(const std::vector<Vec3>& path);
  /// Hides everything in front of a plane; null: nothing is hidden.
  void set_clip_plane(vtkPlane* plane);
  /// Shows a grid through the origin along two axes, with a spacing of a power of ten; empty: none.
  void set_grid(const std::optional<std::pair<Vec3, Vec3>>& axes);
  /// Selects the mode shape to draw, 0-based, and its phase, -1 to 1.
  void set_mode(int mode);
  void set_mode_phase(double swing);
  int mode() const { return mode_; }
  const StressView* stress() const { return stress_.get(); }
  /// Shows an arrow for a load that is being dragged; empty: none.
  void set_push(const std::optional<std::pair<Vec3, Vec3>>& from_to);

  // Picking: what is shown at a point of the window, in renderer coordinates (origin at the lower
  // left).
  std::optional<Vec3> surface_at(double x, double y) const;
  std::string line_at(double x, double y) const;    ///< "": no curve is near
  std::string region_at(double x, double y) const;  ///< or a part of a mesh
  std::vector<int> points_within(const Vec3& centre, double radius) const;
  int point_count() const;
  /// True if the colours show a scalar field.
  bool has_scalar_field() const;
  /// Lookup table of the scalar field; null: none is shown.
  vtkLookupTable* scale() const;
  /// Value of the scalar field at a point of the surface.
  std::optional<double> value_at(const Vec3& p) const;
  Shading shading() const { return shading_; }
  /// Value at the end of the colour scale, and the largest magnitude; both 0 if there is no scale.
  std::array<double, 2> range() const { return range_; }
  /// Index of the display point closest to a point.
  int point_near(const Vec3& p) const;
  /// Position of a display point in the last frame.
  Vec3 point(int number) const;
  /// Positions at which loads, forces, normal constraints and point supports are drawn.
  std::vector<Vec3> mark_points() const;
  bool has_surface() const { return pattern_ != nullptr; }
  std::array<Vec3, 2> box() const;

 private:
  void make_facets();
  void make_lines();
  void make_roles();
  void select_facets();
  void select_within(const std::vector<char>& points);
  void shade();
  void shade_facets(vtkIntArray* values, vtkLookupTable* table);
  void shade_points();
  vtkSmartPointer<vtkLookupTable> table_of(const float* value, size_t n);
  void measure_curvature(float* value) const;
  void measure_strain(float* value) const;
  void place_points();
  bool shows_stress() const;
  const std::vector<float>* mode_shape() const;
  void take_marks(const DocumentView& view);
  void find_marks();
  void place_marks();
  void show_supports();
  /// Cells of the lines whose names satisfy the predicate.
  vtkSmartPointer<vtkCellArray> cells_of_lines(
      const std::function<bool(const std::string&)>& has) const;
  bool mesh_is_drawn() const;
  void colour();
  struct NearLine {
    Vec2 pixel;
    std::optional<Vec3> surface;  // point of the surface under the mouse
    double least;
    std::string name;
  };
  void look_for(NearLine& near, const Layer& layer, const std::vector<std::string>& names) const;
  int facet_at(double x, double y) const;
  std::string part_of(int facet) const;
  std::unique_ptr<Layer> facets_, lines_, guides_, selection_layer_, draft_, push_, grid_, dots_,
      dot_, comb_, marks_, fixed_points_layer_, normals_layer_, supports_;
  vtkSmartPointer<vtkFloatArray> points_, normals_, scalars_;
  vtkSmartPointer<vtkIntArray> facet_regions_, roles_;
  vtkRenderer* renderer_;
  std::shared_ptr<const DisplayTopology> pattern_;
  std::vector<float> reference_;         // points at the time of meshing
  std::vector<std::string> line_names_;  // name of each cell of lines_
  std::vector<DocumentView::Polyline> polylines_;
  std::vector<std::string> regions_, shown_lines_;
  std::shared_ptr<const MeshView> mesh_;
  std::shared_ptr<const std::vector<float>> unloaded_;
  std::vector<std::pair<int, DocumentView::Mark>> marked_;  // with the index of their display point
  std::vector<DocumentView::Mark> stated_marks_;
  std::vector<Vec3> fixed_points_;
  std::vector<std::string> supported_;
  double size_ = 0, swing_ = 0;
  int mode_ = 0;
  std::vector<int> selected_facets_;
  std::vector<float> frame_points_;  // before loads or modes displace it
  std::shared_ptr<const StressView> stress_;
  std::array<double, 2> range_{};
  vtkSmartPointer<vtkLookupTable> table_;
  bool surface_ = false;
  Shading shading_ = Shading::Shaded;
  Palette palette_;
  std::string selected_name_;
};

}  // namespace batten::studio
