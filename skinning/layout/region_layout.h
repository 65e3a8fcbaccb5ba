// SPDX-License-Identifier: MPL-2.0
// Builds the domain, the mesh and the constraints of one face from its curves.
#pragma once

#include <string>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/core/progress.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

struct DomainInput;  // skinning/domains/domain_input.h

/// The layout of a face, without its shape: its domain, its mesh, and the representation of each
/// curve on the mesh. The constructor builds it in these steps:
///
/// 1. Curves are split at their corners (into "name.1", "name.2", …). Outline curves, and hole
///    curves, are joined at their ends into loops.
/// 2. A domain type is chosen:
///      polygon      one loop with three or more corners. Its sides and corner angles approximate
///                   the lengths and angles of the curves. Every outline curve is mesh-aligned: a
///                   straight chain of element edges. Inner curves are mesh-aligned across the
///                   polygon where possible;
///      projected    other outlines: their planar projection. All curves are embedded and the mesh
///                   is trimmed;
///      annulus      two smooth loops: a strip that is periodic in u. Both circles are
///                   mesh-aligned;
///      developable  a loop that has neither a polygon nor a simple projection: an unfolded
///                   developable surface through it. All curves are embedded.
///    The domain is divided by the size of the face, so that u and v are dimensionless.
/// 3. The outline is fitted by C1 cubic Hermite curves (exact for piecewise cubic input), and the
///    domain is meshed.
/// 4. Holes, and inner curves that cannot be mesh-aligned (closed, bent, ending inside, crossing),
///    are embedded: by projection in a projected domain, otherwise at the closest points of the
///    surface that the outline alone defines.
/// 5. The mesh is trimmed along embedded boundaries. Embedded curves are imposed at collocation
///    points. Triangles under embedded curves are bisected until the gap between surface and curve,
///    in the shape of minimum bending energy, is below tolerance() / 2.
///
/// The domain runs counter-clockwise along the outline in the direction of its first curve, which
/// therefore determines the side to which the surface normal points. The parameter u runs along the
/// side of the polygon that contains this curve, around the annulus, or along the projection of the
/// x axis (y axis if the plane is perpendicular to x). Directional stiffnesses (alpha, beta) refer
/// to the direction of u. Theory: docs/theory/domains.md.
class RegionLayout {
 public:
  /// Builds the layout of a face. Throws InputError, with a message for the user, for invalid
  /// input: an open loop; curves that cross or touch; a loop that crosses itself; all curves on one
  /// straight line; holes outside of the outline or inside each other; inner curves that leave the
  /// face, or cross in the domain but not in space; a domain type that does not suit the outline.
  /// Throws NoSolutionError for a trimmed mesh whose area does not match the outline.
  RegionLayout(std::string name, const std::vector<CharacterLine>& lines,
               const SkinOptions& options, const Progress& progress = {});

  const std::string& name() const { return name_; }
  const std::shared_ptr<const ParametricMesh>& mesh() const { return geometry_.mesh; }
  const std::shared_ptr<const Trim>& trim() const { return geometry_.trim; }
  TriangleElement element() const { return options_.element; }
  const std::vector<EdgeAlignedLine>& edge_aligned() const { return geometry_.edge_aligned; }
  const std::vector<EmbeddedLine>& embedded() const { return geometry_.embedded; }
  double size() const { return size_; }
  /// Largest allowed distance between an input curve and the C1 cubic curve that is fitted to it,
  /// model units.
  double tolerance() const { return tolerance_; }
  const std::vector<std::string>& warnings() const { return geometry_.warnings; }
  const std::vector<DomainCorner>& corners() const { return geometry_.corners; }
  /// Boundary loops of the face; see SkinnedRegion::boundary.
  const std::vector<std::vector<BoundarySegment>>& boundary() const { return geometry_.boundary; }
  /// Change of direction above which the outline has a corner, degrees.
  double corner_angle() const { return options_.corner_angle; }
  SkinOptions::Domain domain() const { return options_.domain; }
  bool convex() const { return options_.convex; }  ///< true: all corners are treated as convex
  bool uses_rest_shape() const { return options_.rest; }  ///< false: the rest state is flat
  /// Start point in space of the first mesh-aligned (if none, of the first embedded) curve.
  Vec3 origin() const;

  /// Builds the constraint equations by which the surface contains all curves of the face:
  /// mesh-aligned curves exactly, embedded curves at their collocation points. The equations do not
  /// couple x, y and z. Each equation has the name of its curve.
  ConstraintSet line_constraints() const;
  /// Builds the constraint equations that fix the corner positions of the face, but not its curves.
  /// The equations do not couple x, y and z. They are named "corner 1", "corner 2", … Throws
  /// InputError for a domain without corners.
  ConstraintSet corner_constraints() const;
  /// Builds the face with the shape that `dofs` define (absolute coordinates, model units).
  SkinnedRegion region(Points dofs) const;

  /// Bisects triangles through which an embedded curve passes, if the gap between this curve and
  /// the surface `shape` exceeds `target` (model units) there. Returns false if no triangle is
  /// bisected. Otherwise the mesh changes, and existing dofs and constraints become invalid.
  bool refine(const Surface& shape, double target);

  // Edits. An edit that throws leaves the layout unchanged. Existing dofs and constraints become
  // invalid after refine(), and after add_inner_line() or remove_inner_line() if collocation points
  // of other curves move.

  /// Bisects the marked triangles (one mark per triangle) and others as needed to keep the mesh
  /// conforming (bisected()). The mesh is trimmed again, and new collocation points are selected.
  /// Mesh-aligned curves stay mesh-aligned. Returns false if no triangle is marked. Throws
  /// InputError if the number of marks is wrong; throws as the constructor does if the curves
  /// cannot be represented on the new mesh.
  bool refine(const std::vector<char>& marked);

  /// True if a mesh-aligned or embedded curve has this name. The parts of a curve that was split at
  /// corners have the names "name.1", "name.2", …
  bool has_line(const std::string& name) const;
  /// The C1 cubic curve that was fitted to the input curve of this name. Throws InputError if there
  /// is no such curve; the message suggests the closest name.
  const HermiteCurve& line(const std::string& name) const;
  /// Replaces the fitted and the input curve of this name by `curve`, which must have the same
  /// CurveMesh. In line_constraints(), only the right-hand sides change, not the coefficients.
  /// set_line() does not check whether the new curve meets the adjacent curves: contradictory
  /// constraints are detected when the constraints are reduced. Throws InputError for an unknown
  /// curve, a different CurveMesh, or non-finite values.
  void set_line(const std::string& name, HermiteCurve curve);

  /// Embeds an inner curve at the points of `shape` closest to the curve. `shape`: a surface on the
  /// mesh of this layout. The curve is split at its corners into "name.1", …, and fitted within
  /// tolerance(). The mesh is unchanged: call refine(shape, target) to bisect triangles with large
  /// gaps.
  ///
  /// Throws InputError for a name that exists already, a role other than Inner,
  /// MeshAlignment::EdgeAligned, a shape on another mesh, or a curve that leaves the face, is far
  /// from `shape`, or crosses another curve in the domain but not in space.
  void add_inner_line(const CharacterLine& line, const Surface& shape);
  /// Removes the embedded inner curve of this name. Throws InputError if there is no curve of this
  /// name, or if the curve is mesh-aligned or part of the boundary.
  void remove_inner_line(const std::string& name);

 private:
  DomainInput task() const;
  std::vector<std::string> line_names() const;
  std::string name_;
  SkinOptions options_;
  double size_ = 1, tolerance_ = 0, gap_tolerance_ = 0;
  RegionGeometry geometry_;
};

}  // namespace batten
