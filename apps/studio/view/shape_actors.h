// Draws a document: its moving surface, its lines, and what the hand is about to do.
#pragma once

#include <vtkSmartPointer.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/apps/commands/documents/document_view.h"
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

/// What the colours of the surface say.
enum class Shading {
  Shaded,
  Regions,
  Zebra,         ///< stripes of equal angle between the normal and a direction
  Contours,      ///< bands of equal height
  Displacement,  ///< distance from where the surface was when its mesh was made
  Curvature,     ///< mean curvature, positive where the normal's side is hollow
  Strain,        ///< largest strain since the mesh was made
  Stress,        ///< equivalent stress, on the shape as the loads bend it
  Modes          ///< how the shell swings: the chosen natural mode, where it moves most
};

/// The actors of one renderer. A frame costs one copy of its points and normals and, with a shading
/// that needs it, one number for each point; facets and lines are made anew only where the mesh is.
class ShapeActors {
 public:
  explicit ShapeActors(vtkRenderer* renderer);
  ~ShapeActors();

  void refresh(const DocumentView& view);
  void refresh(const Frame& frame);
  void refresh(std::shared_ptr<const StressView> stress);
  void set_shading(Shading shading);
  void set_palette(const Palette& palette);
  void set_mesh(bool shown);  ///< the edges of the facets
  /// A name of a line, region or part of a mesh: it is drawn in the colour of what is chosen. "": none.
  void select(const std::string& name);
  /// Facets whose points are all marked are drawn so until the next choice.
  void show_painted(const std::vector<char>& points);
  /// The points within so far of a place of the surface without loads.
  std::vector<int> unloaded_within(const Vec3& centre, double radius) const;
  /// The points of a line that is being drawn; with one more where the hand is.
  void set_draft(const std::vector<Vec3>& points);
  /// Dots of points that can be moved, one of them chosen (-1: none); `joined` by lines.
  void set_dots(const std::vector<Vec3>& points, int selected, bool joined);
  /// A comb of the curvature along points of a curve; as high as a tenth of the size at most.
  void set_comb(const std::vector<Vec3>& curve);
  /// The way of something through a sequence's frames, in the place of a comb.
  void set_path(const std::vector<Vec3>& way);
  /// What lies before a plane is not drawn; null: everything is.
  void set_clip_plane(vtkPlane* plane);
  /// A grid through the origin along two axes, in round steps.
  void set_grid(const std::optional<std::pair<Vec3, Vec3>>& axes);
  /// The natural mode that is shown, counted from 0, and where in its swing it is, -1 to 1.
  void set_mode(int mode);
  void set_mode_phase(double swing);
  int mode() const { return mode_; }
  const StressView* stress() const { return stress_.get(); }
  /// An arrow of a load that is being pushed.
  void set_push(const std::optional<std::pair<Vec3, Vec3>>& from_to);

  // What a point of the window shows; the renderer's coordinates, from the lower left corner.
  std::optional<Vec3> surface_at(double x, double y) const;
  std::string line_at(double x, double y) const;    ///< "" where there is none near
  std::string region_at(double x, double y) const;  ///< or the part of a mesh
  std::vector<int> points_within(const Vec3& centre, double radius) const;
  int point_count() const;
  /// Whether colours stand for numbers, and which one at a place.
  bool has_scalar_field() const;
  /// The table of the numbers' colours; null where they say none.
  vtkLookupTable* scale() const;
  std::optional<double> value_at(const Vec3& p) const;
  Shading shading() const { return shading_; }
  /// The number at the end of the colours, and the largest magnitude; both 0 where they say none.
  std::array<double, 2> range() const { return range_; }
  /// Number of the display point nearest to a place, and its position in the last frame.
  int point_near(const Vec3& p) const;
  Vec3 point(int number) const;
  /// Where loads, forces, normals and point supports are drawn.
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
  /// The drawn pieces of lines whose names are meant.
  vtkSmartPointer<vtkCellArray> cells_of_lines(
      const std::function<bool(const std::string&)>& has) const;
  bool mesh_is_drawn() const;
  void colour();
  struct NearLine {
    Vec2 pixel;
    std::optional<Vec3> surface;  // that the hand is on
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
  std::vector<float> reference_;         // points when the mesh was made
  std::vector<std::string> line_names_;  // of each cell of lines_
  std::vector<DocumentView::Polyline> polylines_;
  std::vector<std::string> regions_, shown_lines_;
  std::shared_ptr<const MeshView> mesh_;
  std::shared_ptr<const std::vector<float>> unloaded_;
  std::vector<std::pair<int, DocumentView::Mark>> marked_;  // by the display points where they are
  std::vector<DocumentView::Mark> stated_marks_;
  std::vector<Vec3> fixed_points_;
  std::vector<std::string> supported_;
  double size_ = 0, swing_ = 0;
  int mode_ = 0;
  std::vector<int> selected_facets_;
  std::vector<float> frame_points_;  // before loads bend it
  std::shared_ptr<const StressView> stress_;
  std::array<double, 2> range_{};
  vtkSmartPointer<vtkLookupTable> table_;
  bool surface_ = false;
  Shading shading_ = Shading::Shaded;
  Palette palette_;
  std::string selected_name_;
};

}  // namespace batten::studio
