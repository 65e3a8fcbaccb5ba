// SPDX-License-Identifier: MPL-2.0
// Layout of a model without a shape: its faces, their shared curves, and the joins along these.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/core/containers.h"
#include "batten/elements/reference_triangle.h"
#include "batten/skinning/layout/region_layout.h"
#include "batten/skinning/model/join.h"

namespace batten {

/// The representation of a curve in one face: mesh-aligned or embedded.
struct LineSide {
  int region = 0;
  bool embedded = false;
  int index = 0;  ///< index into embedded() or edge_aligned() of RegionLayout
};

/// A curve of the model, listed once for all faces that contain the curve.
struct ModelLine {
  std::string name;
  /// One entry per face that contains the curve: first mesh-aligned, then embedded representations,
  /// each sorted by face. All represent the same curve in space.
  std::vector<LineSide> sides;
};

/// A point of the model, given by a face and a point in the domain of this face.
struct ModelPoint {
  int region = 0;
  Vec2 uv = Vec2::Zero();  ///< parameters (u, v) in the domain of this face
};

/// Data common to all faces of a model.
struct ModelMetadata {
  std::string name;
  /// Length scale of the model: diagonal of the bounding box of the curves, model units.
  double size = 1;
  /// Largest allowed distance between an input curve and its C1 cubic approximation, model units.
  double tolerance = 0;
  /// Origin of the coordinates in which the dofs are computed, model units.
  Vec3 origin = Vec3::Zero();
  /// A smooth join ends as a crease at a node at which the tangent planes of both faces differ by
  /// more than this angle, degrees.
  double max_plane_angle_deg = 0.1;
  /// True: the rest shape of each face is computed from its boundary curves (rest_dofs() in
  /// model_shapes.h). False: the rest state is flat, so that a face has the bending energy of the
  /// shape itself.
  bool rest = true;
};

/// The layout of a model: faces that share curves, as one system of unknowns. A model of a single
/// face has the mesh, the numbering and the constraints of this face.
///
/// The model has one mesh: the concatenated meshes of the faces (ParametricMesh::concatenated()),
/// each in its own (u, v). Computations per triangle (stiffness, loads, display) therefore handle
/// one surface. For each coordinate, the 3 dofs of each vertex come first, face after face, and
/// then the dof of each edge, face after face.
///
/// The domain of each face r is scaled to size 1: a length in its parameters u is about a length in
/// space divided by the size s_r of the face. The energy of the model is computed as if the model
/// were scaled from its size S to size 1, so it is an integral over the parameters U = u s_r/S, in
/// which all faces have the same scale. Converted to the parameters u of face r, the bending
/// stiffness has the factor (S/s_r)², the membrane stiffness the factor 1, and an area of the
/// domain the factor (s_r/S)². See domain_scale() and scale_to_regions().
///
/// Each face has its own constraints for a shared curve. Smooth joins are additional constraints on
/// the dofs of both faces (join.h). All other shared curves are creases (G0): the faces share only
/// the curve.
///
/// Copies of a ModelLayout share the layouts of the faces; an edit replaces the layouts that it
/// changes.
class ModelLayout {
 public:
  /// Constructs a model of one face.
  ModelLayout(RegionLayout region);  // NOLINT: a face is a model
  /// Constructs a model of one or more faces. The joins refer to faces by their index in `regions`.
  /// Throws InputError if there is no face, or if the faces have different types of elements.
  ModelLayout(ModelMetadata metadata, std::vector<std::shared_ptr<const RegionLayout>> regions,
              std::vector<JoinPlan> join_lines);

  const std::string& name() const { return metadata_.name; }
  bool has_rest() const { return metadata_.rest; }
  double size() const { return metadata_.size; }
  double tolerance() const { return metadata_.tolerance; }
  /// Origin of the coordinates in which the dofs are computed, to reduce round-off errors; model
  /// units.
  const Vec3& origin() const { return metadata_.origin; }
  int region_count() const { return isize(regions_); }
  const RegionLayout& region(int r) const { return *regions_[r]; }
  const std::vector<std::shared_ptr<const RegionLayout>>& regions() const { return regions_; }
  const ModelMetadata& metadata() const { return metadata_; }
  /// Index of the face with this name. Throws InputError if there is no such face; the message
  /// suggests the closest name.
  int region_named(const std::string& name) const;
  /// Warnings of all faces. In a model of several faces, each warning begins with "face 'NAME': ".
  std::vector<std::string> warnings() const;

  const std::shared_ptr<const ParametricMesh>& mesh() const { return mesh_; }
  const std::shared_ptr<const Trim>& trim() const { return trim_; }
  TriangleElement element() const { return region(0).element(); }

  // -- curves -------------------------------------------------------------------------------------
  const std::vector<ModelLine>& lines() const { return lines_; }
  bool has_line(const std::string& name) const;
  /// The curve called `name` and its representations in the faces. Throws InputError if there is no
  /// such curve; the message suggests the closest name.
  const ModelLine& model_line(const std::string& name) const;
  /// The geometry in space of the curve called `name`: its C1 cubic approximation in the first face
  /// that contains the curve (ModelLine::sides). Throws as model_line() does.
  const HermiteCurve& line(const std::string& name) const;
  /// The C1 cubic curve in space that represents a model curve in one face.
  const HermiteCurve& curve(const LineSide& side) const;
  /// The pcurve of a model curve in the domain (u, v) of one face, with the parameter of curve().
  HermiteCurve pcurve(const LineSide& side) const;
  /// True if the representation of a model curve in one face, curve(side), runs against the one in
  /// the first face, curve(line.sides[0]).
  bool against(const ModelLine& line, const LineSide& side) const;
  /// All curves that faces share, smooth or creases, as pairs of faces: the first face that
  /// contains the curve, paired with each of the others. JoinSide::left is not determined here, and
  /// its value is meaningless.
  std::vector<JoinLine> shared_lines() const;
  const std::vector<JoinPlan>& join_plans() const { return join_plans_; }
  /// The plan of the smooth join along the curve called `line`; null if there is no smooth join.
  const JoinPlan* join_plan(const std::string& line) const;

  // -- constraints and numbering -----------------------------------------------------------------
  /// Builds the constraints by which the faces contain their curves, named after the curves, and
  /// those of smooth joins, named "smooth curve NAME". The constraints do not couple x, y and z.
  ConstraintSet line_constraints() const;
  /// Builds the constraints of a model of which only the corners are fixed, not the curves: those
  /// of the corner positions, named "corner 1", … (with several faces "FACE corner 1", …); the
  /// constraints that keep faces together along shared curves, named "joined curve NAME"; and those
  /// of smooth joins. Throws InputError for a model without corners.
  ConstraintSet corner_constraints() const;
  /// The penalty on angles at all smooth joins on embedded curves (join_penalty() in join.h), for
  /// the isotropic bending stiffness β = 1 and the model scaled to size 1. Add β times its matrix to
  /// the bending stiffness matrix, and β times its load to the right-hand side.
  JoinPenalty join_penalty() const;
  /// A vector over the dofs of one coordinate: 1 at vertex positions (w), 0 at derivatives.
  VecX position_dofs() const;
  /// A fill-reducing ordering of all dofs. Empty if joins couple faces, because an ordering
  /// computed from the matrix is then better.
  std::vector<int> dof_order() const;
  /// For each triangle, the factor (s/S)² by which areas of the face's domain are scaled to the
  /// model of size 1. s is the size of the face, S that of the model. Empty if all factors are 1.
  const VecX& domain_scale() const { return domain_scale_; }
  /// Converts materials from the parameters of the model scaled to size 1 to the parameters (u, v)
  /// of each face. `materials`: one for all triangles, or one per triangle. The result has one per
  /// triangle, or equals `materials` if domain_scale() is empty.
  std::vector<SurfaceStiffness> scale_to_regions(std::vector<SurfaceStiffness> materials) const;
  /// Offsets from the dof numbers of face `r` to those of the model. first_triangle(r) is the
  /// number in the model of the first triangle of face `r`.
  const DofOffsets& dof_offsets(int r) const { return dof_offsets_[r]; }
  int first_triangle(int r) const { return first_triangle_[r]; }
  /// Extends the vector `own` over the dofs of face `r` to all dofs of the model, by zeros.
  VecX spread(int r, const VecX& own) const;
  int region_of(int triangle) const;  ///< index of the face that contains a triangle of the model
  /// Converts a location in the mesh of face `r` to a location in the mesh of the model.
  Location to_model_location(int r, Location where) const;

  // -- shapes -------------------------------------------------------------------------------------
  /// Extracts the dofs of face `r` from `all`, the dofs of the model.
  Points region_dofs(int r, const Points& all) const;
  /// Combines the dofs of all faces into those of the model.
  Points all_dofs(const std::vector<Points>& of_regions) const;
  /// All faces as one surface, for evaluation by location. Do not evaluate this surface by (u, v):
  /// each face has its own parameters. `all`: dofs of the model.
  Surface surface(Points all) const;
  /// Builds face `r` with the shape that `all` defines: dofs of the model in absolute coordinates.
  SkinnedRegion skinned(int r, const Points& all) const;
  /// Computes the shape of minimum energy that satisfies line_constraints(). `material`: stiffness.
  /// `rest`: dofs of the rest shape (zero energy), with zeros in faces without a rest shape; no
  /// rows: no face has a rest shape. Dofs are in absolute coordinates. Cost: one factorization.
  /// Throws ConflictError, NoSolutionError.
  Points minimize_energy(const SurfaceStiffness& material, const Points& rest = {}) const;
  /// Computes the shape that satisfies line_constraints() and is closest to the shape `wanted`: the
  /// bending energy of their difference is minimal. Dofs are in absolute coordinates. Cost: one
  /// factorization. Throws as minimize_energy() does.
  Points nearest(const Points& wanted) const;

  // -- edits: if one throws, the layout is unchanged --------------------------------------------
  /// Bisects the marked triangles (one mark per triangle), and others as needed to keep the mesh
  /// conforming within each face and along shared mesh-aligned curves. Returns false if no triangle
  /// is marked. If there are smooth joins on embedded curves, call plan_joins() afterwards.
  bool refine(const std::vector<char>& marked);
  /// Replaces the curve of this name, in all faces that contain it, by `curve`, which must have the
  /// same CurveMesh (RegionLayout::set_line()).
  void set_line(const std::string& name, const HermiteCurve& curve);
  /// Adds an inner curve to the face closest to it (RegionLayout::add_inner_line()). `shape`: dofs
  /// of the model in absolute coordinates.
  void add_inner_line(const CharacterLine& line, const Points& shape);
  void remove_inner_line(const std::string& name);  ///< see RegionLayout::remove_inner_line()
  /// Plans all smooth joins again (plan_joins() in join.h), from a shape on this layout. Impossible
  /// joins are rejected (JoinPlan::rejection_reason). O(joins).
  void plan_joins(const Points& shape);
  /// Turns the smooth join along a curve into a crease. `why`: the reason, a message for the user.
  void reject_join(const std::string& line, const std::string& why);
  /// Largest relative change that a call of plan_joins(shape) would make to the gluing functions
  /// (of the G1 conditions) at the ends of smooth joins. Infinite if the call would create or
  /// remove a crease at the end of a join, or reject a join. Call plan_joins() if the value is not
  /// small.
  double gluing_change(const Points& shape) const;
  /// Computes the shape that satisfies line_constraints() and for which the energy of its
  /// difference from `wanted` is least. `materials`: one for all triangles, or one per triangle.
  /// Dofs are in absolute coordinates. Cost: one factorization. Throws ConflictError,
  /// NoSolutionError.
  Points nearest_shape(const std::vector<SurfaceStiffness>& materials, const Points& wanted) const;

 private:
  void assign_dof_offsets();
  std::vector<const RegionLayout*> layouts() const;
  std::vector<Points> of_regions(const Points& all) const;
  ConstraintSet gather(ConstraintSet (RegionLayout::*constraints)() const, bool name_regions) const;

  ModelMetadata metadata_;
  std::vector<std::shared_ptr<const RegionLayout>> regions_;
  std::vector<JoinPlan> join_plans_;
  // Derived from the faces and joins by assign_dof_offsets():
  std::shared_ptr<const ParametricMesh> mesh_;
  std::shared_ptr<const Trim> trim_;
  std::vector<DofOffsets> dof_offsets_;
  std::vector<int> first_triangle_;  // of each face; the last entry is the total number
  VecX domain_scale_;
  std::vector<ModelLine> lines_;
};

// Scale factors of loads and materials for a model scaled to size 1.

/// Scale factors between a model of size S and the domain scaled to size 1, on which the model is
/// solved. In relative units, alpha, beta and loads are dimensionless on the scaled domain, but
/// dofs are lengths, so that forces have the factor S. In absolute units, forces are unchanged and
/// areas of the domain have the factor S². See ModelLayout::domain_scale() for factors between the
/// faces of a model.
class ModelScale {
 public:
  ModelScale(LoadUnits units, double size)
      : relative_(units == LoadUnits::Relative), units_(units), size_(size) {}

  SurfaceStiffness material(const SurfaceStiffness& m) const {
    return scaled_to_unit_domain(m, units_, size_);
  }
  /// Factor by which a force on the model is multiplied in the problem scaled to size 1.
  double force() const { return relative_ ? size_ : 1; }
  /// Factor of a force per area of the domain in the problem scaled to size 1; per_area(): of a
  /// force per area of the surface.
  double per_domain_area() const { return relative_ ? size_ : size_ * size_; }
  double per_area() const { return relative_ ? 1 / size_ : 1; }
  /// Factor of mass and damping per area of the domain in the problem scaled to size 1.
  double inertia() const { return relative_ ? 1 : size_ * size_; }
  /// Factor from reaction forces of the problem scaled to size 1 to those in reports.
  /// energy_factor() is the factor for energies.
  double reaction_factor() const { return relative_ ? 1 / size_ : 1; }
  double energy_factor() const { return relative_ ? 1 / (size_ * size_) : 1; }

 private:
  bool relative_;
  LoadUnits units_;
  double size_;
};

// Refinement of a model along embedded curves, after solving.

/// Bisects triangles in which loads and constraints pull a solved surface off its embedded curves:
///
///     GapRefinement refinement(layout);
///     do regions = solve(layout);
///     while (refinement.bisect(layout, regions));
///
/// The refinement ends when the gaps are at most 0.7 of the tolerance of the model, after eight
/// rounds, or before the number of triangles exceeds both 20,000 and four times the initial number.
/// The deviation of the fitted curves from the input curves may use the remaining 0.3 of the
/// tolerance.
class GapRefinement {
 public:
  /// Sets the limit on the number of triangles. `layout`: the model before the first bisections.
  explicit GapRefinement(const ModelLayout& layout);

  /// Bisects the triangles of `layout` in which the gap to an embedded curve exceeds half of the
  /// tolerance of the model. Returns false, and does not change `layout`, if all gaps are at most
  /// 0.7 of the tolerance or if a limit is reached. `regions`: the faces of the solved shape on
  /// `layout`, in order. O(triangles + samples of embedded curves).
  bool bisect(ModelLayout& layout, const std::vector<SkinnedRegion>& regions);

  /// True after eight rounds of bisections, the maximum: bisect() will then return false.
  bool exhausted() const { return rounds_ == kMaxRounds; }

 private:
  static constexpr int kMaxRounds = 8;
  int max_triangles_, rounds_ = 0;
};

}  // namespace batten
