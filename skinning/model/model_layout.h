// Layout of a model without a shape: its regions, their shared lines, and the joins along these.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/core/containers.h"
#include "batten/elements/reference_triangle.h"
#include "batten/skinning/layout/region_layout.h"
#include "batten/skinning/model/join.h"

namespace batten {

/// A region's representation of a line: edge-aligned or embedded.
struct LineSide {
  int region = 0;
  bool embedded = false;
  int index = 0;  ///< index into RegionLayout::edge_aligned() or ::embedded()
};

/// A curve of the model, listed once for all faces that contain it. All sides have the same curve
/// in space.
struct ModelLine {
  std::string name;
  /// One per face that contains the curve: mesh-aligned ones first, then embedded ones; each kind
  /// sorted by face.
  std::vector<LineSide> sides;
};

/// A point of the model: a region and a point of its domain.
struct ModelPoint {
  int region = 0;
  Vec2 uv = Vec2::Zero();  ///< parameters in that region's domain
};

/// Data common to all regions of a model.
struct ModelMetadata {
  std::string name;
  double size = 1;  ///< S: length scale of the model, model units
  /// Largest allowed distance between an input curve and its C1 cubic approximation, model units.
  double tolerance = 0;
  /// Point relative to which dofs are solved for, model units.
  Vec3 origin = Vec3::Zero();
  /// If the tangent planes at a node differ by more than this angle (degrees), smooth joins end as
  /// creases there.
  double max_plane_angle_deg = 0.1;
  /// Regions have a rest shape, which their boundary curves suggest (model_shapes.h). If false,
  /// bending energy is that of the shape itself (rest shape zero).
  bool rest = true;
};

/// Regions that share lines, as one system of unknowns. A single region is a model with one region;
/// it keeps its mesh, numbering and constraints.
///
/// The model has one mesh: the concatenated meshes of the regions (ParametricMesh::concatenated()),
/// each in its own (u, v). So everything that is done per triangle (stiffness, loads, display)
/// handles one surface. The dofs of one coordinate are 3 per vertex, region after region, then 1
/// per edge, region after region.
///
/// Each region, of size s_r, is scaled to 1. The model's energy is that of the model scaled to size
/// 1, by U = u s_r/S. In its own (u, v), a region's bending stiffness therefore has the factor
/// (S/s_r)², its stretching stiffness the factor 1, and an area of its domain the factor (s_r/S)².
/// See domain_scale() and scale_to_regions().
///
/// Each region constrains its own copy of a line. Smooth joins are constraints on the dofs of both
/// sides (join.h). Other lines with several regions are creases (G0): the regions share the line
/// only.
///
/// Copies share the regions' layouts; an edit replaces the layouts that it changes.
class ModelLayout {
 public:
  /// Constructs a model of one region.
  ModelLayout(RegionLayout region);  // NOLINT: a region is a model
  /// Constructs a model of several regions; join lines refer to them by index. Throws InputError if
  /// there is no region, or if their elements differ.
  ModelLayout(ModelMetadata metadata, std::vector<std::shared_ptr<const RegionLayout>> regions,
              std::vector<JoinPlan> join_lines);

  const std::string& name() const { return metadata_.name; }
  bool has_rest() const { return metadata_.rest; }
  double size() const { return metadata_.size; }
  double tolerance() const { return metadata_.tolerance; }
  /// Point relative to which dofs are solved for, to reduce round-off; model units.
  const Vec3& origin() const { return metadata_.origin; }
  int region_count() const { return isize(regions_); }
  const RegionLayout& region(int r) const { return *regions_[r]; }
  const std::vector<std::shared_ptr<const RegionLayout>>& regions() const { return regions_; }
  const ModelMetadata& metadata() const { return metadata_; }
  /// Index of a region. Throws InputError, suggesting the closest name, if there is none.
  int region_named(const std::string& name) const;
  /// Warnings of all regions; if there are several, each begins with "face 'NAME': ".
  std::vector<std::string> warnings() const;

  const std::shared_ptr<const ParametricMesh>& mesh() const { return mesh_; }
  const std::shared_ptr<const Trim>& trim() const { return trim_; }
  TriangleElement element() const { return region(0).element(); }

  // -- lines --------------------------------------------------------------------------------------
  const std::vector<ModelLine>& lines() const { return lines_; }
  bool has_line(const std::string& name) const;
  /// The line of this name. Throws InputError, suggesting the closest name, if there is none.
  const ModelLine& model_line(const std::string& name) const;
  /// The curve X(t) in space with this name: the cubic approximation that its first side stores
  /// (ModelLine::sides). Throws InputError as model_line() does.
  const HermiteCurve& line(const std::string& name) const;
  /// The curve X(t) of a line in space, as approximated on one side, that is in one of the regions
  /// that meet there.
  const HermiteCurve& curve(const LineSide& side) const;
  /// The same curve in the parametric domain of that region, c(t) = (u, v), with the parameter t of
  /// curve().
  HermiteCurve pcurve(const LineSide& side) const;
  /// True if the curve of a side runs against that of the first side of the line.
  bool against(const ModelLine& line, const LineSide& side) const;
  /// Each line that regions share, smooth or crease: one entry for its first side with each further
  /// one. Which side lies to the left is not determined here: JoinSide::left is only a placeholder.
  std::vector<JoinLine> shared_lines() const;
  const std::vector<JoinPlan>& join_plans() const { return join_plans_; }
  /// The plan of the line's smooth join, or null.
  const JoinPlan* join_plan(const std::string& line) const;

  // -- constraints and numbering -----------------------------------------------------------------
  /// Builds the constraints of every line in every region, with the names of the lines, and those
  /// of smooth joins, "smooth curve NAME". None couples x, y and z.
  ConstraintSet line_constraints() const;
  /// Builds the constraints of the corners only, without lines. They are "corner 1" (with several
  /// regions "REGION corner 1"), those that keep regions together along shared lines, "joined curve
  /// NAME", and those of smooth joins. Throws InputError for a model without corners.
  ConstraintSet corner_constraints() const;
  /// join_stiffness() of all embedded join lines, for isotropic β = 1 on the model scaled to size
  /// 1. Add it, multiplied by β, to every bending stiffness.
  SparseMatrix join_stiffness() const;
  /// A vector with 1 at position dofs and 0 elsewhere.
  VecX position_dofs() const;
  /// A fill-reducing ordering of all dofs. Empty if joins couple regions: then a better ordering is
  /// computed from the matrix.
  std::vector<int> dof_order() const;
  /// The factor (s_r/S)² of each triangle; empty if it is 1 everywhere.
  const VecX& domain_scale() const { return domain_scale_; }
  /// Converts materials of the model scaled to size 1 (one for all, or one per triangle) to
  /// materials in the regions' own (u, v), one per triangle. If all factors are 1, they are
  /// returned unchanged.
  std::vector<SurfaceStiffness> scale_to_regions(std::vector<SurfaceStiffness> materials) const;
  /// Offsets from a region's dof numbers to the model's; first_triangle(): the model's number of
  /// its triangle 0.
  const DofOffsets& dof_offsets(int r) const { return dof_offsets_[r]; }
  int first_triangle(int r) const { return first_triangle_[r]; }
  /// Extends a vector of one region's dofs to all dofs of the model, with zeros elsewhere.
  VecX spread(int r, const VecX& own) const;
  int region_of(int triangle) const;  ///< index of the region that contains a triangle of the model
  /// Converts a location in a region's mesh to one in the model's mesh.
  Location to_model_location(int r, Location where) const;

  // -- shapes -------------------------------------------------------------------------------------
  /// Extracts the dofs of one region from those of the model.
  Points region_dofs(int r, const Points& all) const;
  /// Combines the dofs of all regions to those of the model.
  Points all_dofs(const std::vector<Points>& of_regions) const;
  /// All regions as one surface, for evaluation by location. Its (u, v) are ambiguous, because each
  /// region has its own.
  Surface surface(Points all) const;
  /// Builds one region from a shape of the model (absolute dofs).
  SkinnedRegion skinned(int r, const Points& all) const;
  /// Computes the shape of minimum energy through the lines, in absolute coordinates. `rest`: the
  /// shape of zero energy, absolute dofs, 0 in regions without one; no rows: no region has one.
  /// Cost: one factorization. Throws ConflictError, NoSolutionError.
  Points minimize_energy(const SurfaceStiffness& material, const Points& rest = {}) const;
  /// Computes the shape through the lines that is closest to `wanted`, in absolute dofs: the
  /// bending energy of the difference is minimal. Cost: one factorization. Throws as
  /// minimize_energy().
  Points nearest(const Points& wanted) const;

  // -- edits: if one throws, the layout is unchanged --------------------------------------------
  /// Bisects the marked triangles, and others as needed for conformity, within each region and
  /// along edge-aligned lines that regions share. Returns false if nothing is marked. If lines with
  /// a smooth join are embedded, call plan_joins() afterwards.
  bool refine(const std::vector<char>& marked);
  /// Replaces the curve of a line by another one over the same CurveMesh, in all regions that have
  /// it.
  void set_line(const std::string& name, const HermiteCurve& curve);
  /// Adds an inner line to the region closest to it (RegionLayout::add_inner_line()).
  void add_inner_line(const CharacterLine& line, const Points& shape);
  void remove_inner_line(const std::string& name);  ///< RegionLayout::remove_inner_line()
  /// Plans γ and δ of all smooth joins again, from a shape on this layout. Joins that turn out to
  /// be impossible are rejected (JoinPlan::rejection_reason). O(join lines).
  void plan_joins(const Points& shape);
  /// Turns the line's smooth join into a crease; `why` is the message for the user.
  void reject_join(const std::string& line, const std::string& why);
  /// Largest relative change of γ and δ at the ends of smooth joins if they were planned from this
  /// shape. Infinite if an end would open or close, or if a join is impossible. Call plan_joins()
  /// if it is not small.
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
  // Derived from these by assign_dof_offsets():
  std::shared_ptr<const ParametricMesh> mesh_;
  std::shared_ptr<const Trim> trim_;
  std::vector<DofOffsets> dof_offsets_;
  std::vector<int> first_triangle_;  // the last entry is the total
  VecX domain_scale_;
  std::vector<ModelLine> lines_;
};

// Scale factors of loads and materials for a model scaled to size 1.

/// Scale factors between a model of size S and its domain divided by S, on which it is solved. In
/// relative units alpha, beta and loads are pure numbers there, while dofs keep their length, so
/// that forces get a factor S. In absolute units forces are unchanged and areas of the domain get a
/// factor S². (For factors between the regions of a model see ModelLayout::domain_scale().)
class ModelScale {
 public:
  ModelScale(LoadUnits units, double size)
      : relative_(units == LoadUnits::Relative), units_(units), size_(size) {}

  SurfaceStiffness material(const SurfaceStiffness& m) const {
    return scaled_to_unit_domain(m, units_, size_);
  }
  /// Factor of a force.
  double force() const { return relative_ ? size_ : 1; }
  /// Factors of a force per area of the domain and, with per_area(), per area of the surface
  /// itself.
  double per_domain_area() const { return relative_ ? size_ : size_ * size_; }
  double per_area() const { return relative_ ? 1 / size_ : 1; }
  /// Factor of mass and damping per area of the domain.
  double inertia() const { return relative_ ? 1 : size_ * size_; }
  /// Factors from forces and energies of the scaled problem to reported ones.
  double reaction_factor() const { return relative_ ? 1 / size_ : 1; }
  double energy_factor() const { return relative_ ? 1 / (size_ * size_) : 1; }

 private:
  bool relative_;
  LoadUnits units_;
  double size_;
};

}  // namespace batten
