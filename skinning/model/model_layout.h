// A whole model before it has a shape: regions, the lines that they share, how they join there.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/core/containers.h"
#include "batten/elements/reference_triangle.h"
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

/// A place is a region and a point of its domain.
struct ModelPoint {
  int region = 0;
  Vec2 uv = Vec2::Zero();  ///< parameters of that region
};

/// What a model of several regions has in common.
struct ModelMetadata {
  std::string name;
  double size = 1;       ///< S: length scale of the model, model units
  double tolerance = 0;  ///< tolerance of lines, model units
  Vec3 origin = Vec3::Zero();
  /// Tangent planes at a node that differ by more are no plane: smooth joins end as creases there.
  double max_plane_angle_deg = 0.1;
  /// Regions rest in the shape that their boundary curves mean (rest_shape.h); else they bend from
  /// nothing.
  bool rest = true;
};

/// Regions that share lines, as one system of unknowns. A single region is a model with one region
/// and has its mesh, numbers and rows.
///
/// The model has one mesh: those of the regions side by side (ParametricMesh::side_by_side), each
/// in its own (u, v), so that everything that works triangle by triangle (stiffness, loads,
/// display) sees one surface. The dofs of one coordinate are 3 for each vertex, region after
/// region, then 1 for each edge, region after region.
///
/// Each region, of size s_r, is scaled to 1. The model's energy is that of the model scaled to size
/// 1, U = u s_r/S. So in its own (u, v) a region's bending counts (S/s_r)² times, its stretching
/// once, an area of its domain (s_r/S)² times. See domain_scale(), scale_to_regions().
///
/// Lines are held as each region holds them. Smooth joins are rows on the dofs of both sides
/// (join.h); other lines with several regions are creases: the regions share the line.
///
/// Layouts of regions are shared between copies; an edit replaces those it touches.
class ModelLayout {
 public:
  /// Makes a model with one region.
  ModelLayout(RegionLayout region);  // NOLINT: a region is a model
  /// Makes a model of regions; join lines name them by their index. Throws InputError: no region,
  /// different elements.
  ModelLayout(ModelMetadata metadata, std::vector<std::shared_ptr<const RegionLayout>> regions,
              std::vector<JoinPlan> join_lines);

  const std::string& name() const { return metadata_.name; }
  bool has_rest() const { return metadata_.rest; }
  double size() const { return metadata_.size; }
  double tolerance() const { return metadata_.tolerance; }
  /// The point relative to which dofs are best solved for.
  const Vec3& origin() const { return metadata_.origin; }
  int region_count() const { return isize(regions_); }
  const RegionLayout& region(int r) const { return *regions_[r]; }
  const std::vector<std::shared_ptr<const RegionLayout>>& regions() const { return regions_; }
  const ModelMetadata& metadata() const { return metadata_; }
  /// Returns the index of a region. Throws InputError, with the nearest name, when there is none.
  int region_named(const std::string& name) const;
  /// Warnings of all regions; of several regions they begin "region 'NAME': …".
  std::vector<std::string> warnings() const;

  const std::shared_ptr<const ParametricMesh>& mesh() const { return mesh_; }
  const std::shared_ptr<const Trim>& trim() const { return trim_; }
  TriangleElement element() const { return region(0).element(); }

  // -- lines --------------------------------------------------------------------------------------
  const std::vector<ModelLine>& lines() const { return lines_; }
  bool has_line(const std::string& name) const;
  /// Returns the line of this name. Throws InputError, with the nearest name, when there is none.
  const ModelLine& model_line(const std::string& name) const;
  /// Returns the curve X(t) of a line, as its first side has it. Throws as above.
  const HermiteCurve& line(const std::string& name) const;
  /// Return the curve X(t) as a side has it, and its image c(t), over the same parameters.
  const HermiteCurve& curve(const LineSide& side) const;
  HermiteCurve pcurve(const LineSide& side) const;
  /// Returns whether a side runs against the first side of the line.
  bool against(const ModelLine& line, const LineSide& side) const;
  /// Returns each line that regions share, smooth or a crease, as its first side and each further
  /// one. Which of them lies to the left is not told.
  std::vector<JoinLine> shared_lines() const;
  const std::vector<JoinPlan>& join_plans() const { return join_plans_; }
  /// Returns the plan of the line's smooth join, or null.
  const JoinPlan* join_plan(const std::string& line) const;

  // -- rows and numbers ---------------------------------------------------------------------------
  /// Returns the rows that hold every line in every region, with the names of the lines, and those
  /// of smooth joins, "smooth line NAME". All are uncoupled.
  ConstraintSet line_constraints() const;
  /// Returns the rows that hold only the corners of all regions, "corner 1" (of several regions
  /// "REGION corner 1"), those that keep regions together along lines that they share, "joined line
  /// NAME", and those of smooth joins. Throws InputError for a model without corners.
  ConstraintSet corner_constraints() const;
  /// Returns join_stiffness() of all embedded join lines, for isotropic β = 1 on the model scaled
  /// to size 1. It belongs to every stiffness of bending; times β.
  SparseMatrix join_stiffness() const;
  /// Returns a vector with 1 at position dofs and 0 elsewhere.
  VecX position_dofs() const;
  /// Returns a fill-reducing order of all dofs; empty where joins tie regions together: a better
  /// order is then found from the matrix.
  std::vector<int> dof_order() const;
  /// The factor (s_r/S)² of each triangle; empty when it is 1 everywhere.
  const VecX& domain_scale() const { return domain_scale_; }
  /// Turns materials on the model scaled to size 1 (one for all, or one for each triangle) into
  /// materials in the regions' own (u, v), one for each triangle; when all factors are 1 they are
  /// returned as they are.
  std::vector<SurfaceStiffness> scale_to_regions(std::vector<SurfaceStiffness> materials) const;
  /// Return the numbers of a region's dofs, and of its first triangle, in the model.
  const DofOffsets& dof_offsets(int r) const { return dof_offsets_[r]; }
  int first_triangle(int r) const { return first_triangle_[r]; }
  /// Returns a vector over all dofs with these values of one region at its dofs, 0 elsewhere.
  VecX spread(int r, const VecX& own) const;
  int region_of(int triangle) const;  ///< region of a triangle of the model
  Location to_model_location(int r, Location where) const;

  // -- shapes -------------------------------------------------------------------------------------
  Points region_dofs(int r, const Points& all) const;
  Points all_dofs(const std::vector<Points>& of_regions) const;
  /// Returns all regions as one surface, for jets. Its (u, v) have no meaning: each region has its
  /// own.
  Surface surface(Points all) const;
  SkinnedRegion skinned(int r, const Points& all) const;
  /// Returns the shape of least energy that has the lines, in absolute coordinates. `rest`: the
  /// shape without energy, absolute dofs, 0 in regions that have none; no rows: none has. Costs one
  /// factor. Throws ConflictError, NoSolutionError.
  Points minimize_energy(const SurfaceStiffness& material, const Points& rest = {}) const;
  /// Returns the shape that has the lines and is nearest to another one, absolute dofs: the bending
  /// energy of the difference is least. Costs one factor. Throws as minimize_energy().
  Points nearest(const Points& wanted) const;

  // -- edits: each throws before it has changed anything ---------------------------------------
  /// Halves marked triangles and so many others that the mesh stays conforming, in each region and
  /// along the runs that they share. Returns false when nothing is marked. Where lines with a
  /// smooth join are embedded, plan_joins() has to follow.
  bool refine(const std::vector<char>& marked);
  /// Gives a line another shape over the same CurveMesh, in all regions that have it.
  void set_line(const std::string& name, const HermiteCurve& curve);
  /// Adds an inner line in the region that is nearest to it: RegionLayout::add_inner_line().
  void add_inner_line(const CharacterLine& line, const Points& shape);
  void remove_inner_line(const std::string& name);  ///< RegionLayout::remove_inner_line()
  /// Plans γ and δ of all smooth joins again, from a shape on this layout. Joins that turn out to
  /// be impossible are given up (JoinPlan::rejection_reason). O(join lines).
  void plan_joins(const Points& shape);
  /// Makes a crease of the line's smooth join, for a reason in words.
  void reject_join(const std::string& line, const std::string& why);
  /// Returns by how much γ and δ at the ends of smooth joins would change, relatively, if they were
  /// planned from this shape; infinite where an end would open or close, or a join is impossible.
  /// plan_joins() is due when this is not small.
  double gluing_change(const Points& shape) const;

 private:
  void assign_dof_offsets();
  Points minimize_difference(const SurfaceStiffness& material, const Points& wanted) const;
  std::vector<const RegionLayout*> layouts() const;
  std::vector<Points> of_regions(const Points& all) const;
  ConstraintSet gather(ConstraintSet (RegionLayout::*constraints)() const, bool name_regions) const;

  ModelMetadata metadata_;
  std::vector<std::shared_ptr<const RegionLayout>> regions_;
  std::vector<JoinPlan> join_plans_;
  // Made from these by assign_dof_offsets():
  std::shared_ptr<const ParametricMesh> mesh_;
  std::shared_ptr<const Trim> trim_;
  std::vector<DofOffsets> dof_offsets_;
  std::vector<int> first_triangle_;  // and behind the last
  VecX domain_scale_;
  std::vector<ModelLine> lines_;
};


// The factors of loads and materials on a model scaled to size 1.

/// A model of size S is solved on its domain divided by S. In relative units alpha, beta and loads
/// are pure numbers there while dofs keep their length, so that forces get a factor S. In absolute
/// units forces stay as they are and areas of the domain get a factor S². (Between the regions of a
/// model: ModelLayout::domain_scale().)
class ModelScale {
 public:
  ModelScale(LoadUnits units, double size)
      : relative_(units == LoadUnits::Relative), units_(units), size_(size) {}

  SurfaceStiffness material(const SurfaceStiffness& m) const {
    return scaled_to_unit_domain(m, units_, size_);
  }
  /// Returns the factor of a force.
  double force() const { return relative_ ? size_ : 1; }
  /// Return the factors of a force per area of the domain, and per area of the surface itself.
  double per_domain_area() const { return relative_ ? size_ : size_ * size_; }
  double per_area() const { return relative_ ? 1 / size_ : 1; }
  /// Returns the factor of mass and damping per area of the domain.
  double inertia() const { return relative_ ? 1 : size_ * size_; }
  /// Return the factors from forces and energies of the solved problem to those that are reported.
  double reaction_factor() const { return relative_ ? 1 / size_ : 1; }
  double energy_factor() const { return relative_ ? 1 / (size_ * size_) : 1; }

 private:
  bool relative_;
  LoadUnits units_;
  double size_;
};

}  // namespace batten
