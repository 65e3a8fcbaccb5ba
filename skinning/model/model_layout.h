// A whole model before it has a shape: regions, the lines that they share, how they join there.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/core/index.h"
#include "batten/fairing/energy.h"
#include "batten/skinning/layout/region_layout.h"
#include "batten/skinning/model/join.h"

namespace batten {

/// A region that has a line: on a run, or embedded.
struct LineSide {
  int region = 0;
  bool embedded = false;
  int index = 0;  ///< index into RegionLayout::runs() or ::embedded()
};

/// A line, once, however many regions have it. All of its sides carry one curve in space.
struct ModelLine {
  std::string name;
  std::vector<LineSide> sides;  ///< runs first, each kind by region
};

/// A place on a model's domain.
struct ModelPoint {
  int region = 0;
  Vec2 uv = Vec2::Zero();  ///< parameters of that region
};

/// What a model of several regions has in common.
struct ModelFrame {
  std::string name;
  double size = 1;       ///< S: length scale of the model, model units
  double tolerance = 0;  ///< tolerance of lines, model units
  Vec3 origin = Vec3::Zero();
  /// Tangent planes at a node that differ by more are no plane: smooth joins end as creases there.
  double most_apart_deg = 0.1;
};

/// Regions that share lines, as one system of unknowns. A single region is a model with one region:
/// its mesh, its numbers, its rows.
///
/// One mesh for all: those of the regions side by side (ParametricMesh::side_by_side), each in its
/// own (u, v), so that everything that works triangle by triangle (stiffness, loads, display) sees
/// one surface. Dofs of one coordinate: 3 for each vertex, region after region, then 1 for each
/// edge, region after region.
///
/// Regions of size s_r are scaled to 1 each; the model's energy is that of the model scaled to size
/// 1, U = u s_r/S, so that a region's bending counts (S/s_r)² in its own (u, v), its stretching 1,
/// an area of its domain (s_r/S)². See domain_scale(), materials().
///
/// Lines are held as each region holds them. Smooth joins are rows on the dofs of both sides
/// (join.h); other lines with several regions are creases: the regions share the line.
///
/// Layouts of regions are shared between copies; an edit replaces those it touches.
class ModelLayout {
 public:
  /// A model with one region.
  ModelLayout(RegionLayout region);  // NOLINT: a region is a model
  /// Join lines name regions by their index. Throws InputError: no region, different elements.
  ModelLayout(ModelFrame frame, std::vector<std::shared_ptr<const RegionLayout>> regions,
              std::vector<JoinPlan> join_lines);

  const std::string& name() const { return frame_.name; }
  double size() const { return frame_.size; }
  double tolerance() const { return frame_.tolerance; }
  /// Dofs are best solved for about this point.
  const Vec3& origin() const { return frame_.origin; }
  int region_count() const { return count_of(regions_); }
  const RegionLayout& region(int r) const { return *regions_[r]; }
  /// Throws InputError, with the nearest name, when there is none.
  int region_named(const std::string& name) const;
  /// Warnings of all regions; of several regions they begin "region 'NAME': …".
  std::vector<std::string> warnings() const;

  const std::shared_ptr<const ParametricMesh>& mesh() const { return mesh_; }
  const std::shared_ptr<const Trim>& trim() const { return trim_; }
  TriangleElement element() const { return region(0).element(); }

  // -- lines --------------------------------------------------------------------------------------
  const std::vector<ModelLine>& lines() const { return lines_; }
  bool has_line(const std::string& name) const;
  /// Throws InputError, with the nearest name, when there is none.
  const ModelLine& model_line(const std::string& name) const;
  /// The curve X(t) of a line, as its first side has it. Throws as above.
  const HermiteCurve& line(const std::string& name) const;
  /// The curve X(t) as a side has it, and c(t) there, over the same parameters.
  const HermiteCurve& curve(const LineSide& side) const;
  HermiteCurve image(const LineSide& side) const;
  /// Whether a side runs against the line.
  bool against(const ModelLine& line, const LineSide& side) const;
  const std::vector<JoinPlan>& join_plans() const { return join_plans_; }
  /// The join line that joins a line smoothly, or null.
  const JoinPlan* join_plan(const std::string& line) const;

  // -- rows and numbers ---------------------------------------------------------------------------
  /// Rows that hold every line in every region, and those of smooth joins: uncoupled, named after
  /// the lines, "smooth line NAME".
  ConstraintSet line_constraints() const;
  /// Rows that hold the corners of all regions only, and keep regions together along lines that
  /// they share: "corner 1" (of several regions "REGION corner 1"), "joined line NAME", and those
  /// of smooth joins. Throws InputError for a model without corners.
  ConstraintSet corner_constraints() const;
  /// A vector with 1 at position dofs and 0 elsewhere.
  VecX position_dofs() const;
  /// A fill-reducing order of all dofs; empty where joins tie regions together, and an order is
  /// better found from the matrix.
  std::vector<int> dof_order() const;
  /// Factor (s_r/S)² of each triangle; empty when it is 1 everywhere.
  const VecX& domain_scale() const { return domain_scale_; }
  /// One material for each triangle, in its region's (u, v), of materials on the model scaled to
  /// size 1: one for all, or one a triangle. One for a model that needs no more.
  std::vector<SurfaceStiffness> on_regions(std::vector<SurfaceStiffness> materials) const;
  /// Which number a region's dof, triangle or location has in the model.
  const RegionNumbers& numbers(int r) const { return numbers_[r]; }
  int first_triangle(int r) const { return first_triangle_[r]; }
  /// A vector of all dofs with a region's own numbers at its dofs, 0 elsewhere.
  VecX spread(int r, const VecX& own) const;
  int region_of(int triangle) const;
  Location in_model(int r, Location where) const;

  // -- shapes -------------------------------------------------------------------------------------
  Points region_dofs(int r, const Points& all) const;
  Points all_dofs(const std::vector<Points>& of_regions) const;
  /// All regions as one surface: good for jets, not for (u, v).
  Surface surface(Points all) const;
  SkinnedRegion skinned(int r, const Points& all) const;
  /// The shape of least energy that has the lines, absolute coordinates. One factor. Throws
  /// ConflictError, NoSolutionError.
  Points least_energy(const SurfaceStiffness& material) const;

  // -- edits: each throws before it has changed anything ---------------------------------------
  /// Halves marked triangles and so many others that regions stay conforming, inside and along the
  /// lines that they share. False when nothing is marked. plan_joins() is due when lines with a
  /// join are embedded.
  bool refine(const std::vector<char>& marked);
  /// Another shape of a line over the same CurveMesh, in all regions that have it.
  void set_line(const std::string& name, const HermiteCurve& curve);
  /// An inner line more, in the region that is nearest to it: RegionLayout::add_inner().
  void add_inner(const CharacterLine& line, const Points& shape);
  void remove_inner(const std::string& name);
  /// γ and δ of all smooth joins again, from a shape on this layout. Joins that turn out impossible
  /// are given up (JoinPlan::why_not). O(join lines).
  void plan_joins(const Points& shape);
  /// How far γ (in shares) and δ at the ends of smooth joins would be others if they were
  /// planned from this shape; infinite where one opens or is impossible. plan_joins() is then due.
  double join_misfit(const Points& shape) const;

 private:
  void number();
  std::vector<const RegionLayout*> layouts() const;
  std::vector<Points> of_regions(const Points& all) const;
  ConstraintSet gathered(ConstraintSet (RegionLayout::*rows)() const, bool name_regions) const;

  ModelFrame frame_;
  std::vector<std::shared_ptr<const RegionLayout>> regions_;
  std::vector<JoinPlan> join_plans_;
  // Made from these by number():
  std::shared_ptr<const ParametricMesh> mesh_;
  std::shared_ptr<const Trim> trim_;
  std::vector<RegionNumbers> numbers_;
  std::vector<int> first_triangle_;  // and behind the last
  VecX domain_scale_;
  std::vector<ModelLine> lines_;
};

}  // namespace batten
