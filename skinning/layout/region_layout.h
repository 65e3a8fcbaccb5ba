// Builds the domain, the mesh and the constraints of one region from its character lines.
#pragma once

#include <string>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/core/progress.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

struct DomainInput;  // skinning/domains/domain_input.h

/// A region without a shape: its domain, its mesh, and the representation of each character line.
/// It is built in these steps:
///
/// 1. Lines are split at their corners (into "name.1", "name.2", …). Outline lines, and hole
///    lines, are joined at their ends into loops.
/// 2. A domain type is chosen:
///      polygon      one loop with three or more corners. Its sides and corner angles approximate
///                   the lengths and angles of the lines. Every outline line is edge-aligned: a
///                   straight chain of element edges. Inner lines are edge-aligned across the
///                   polygon where possible;
///      projected    other outlines: their planar projection. All lines are embedded and the mesh
///                   is trimmed;
///      annulus      two smooth loops: a strip that is periodic in u. Both circles are
///                   edge-aligned;
///      developable  a loop that has neither a polygon nor a simple projection: an unfolded
///                   developable surface through it. All lines are embedded.
///    The domain is scaled so that the region's size is 1: (u, v) has no unit.
/// 3. The outline is fitted by C1 cubic Hermite curves (exact for piecewise cubic input), and the
///    domain is meshed.
/// 4. Holes, and inner lines that cannot be edge-aligned (closed, bent, ending inside, crossing),
///    are embedded: by projection in a projected domain, otherwise at the closest points of the
///    surface that the outline alone defines.
/// 5. The mesh is trimmed along embedded boundaries. Embedded lines are imposed at collocation
///    points. The gap between these is measured, and triangles there are bisected until it is below
///    tolerance/2 for the shape of minimum bending energy.
///
/// The domain runs counter-clockwise along the outline in the direction of its first line, which
/// therefore determines the side of the surface's normal. u runs along that line's side of the
/// polygon, around the annulus, or along the projected x axis (y if the plane is perpendicular to
/// x). Directional alpha and beta refer to u. Theory: docs/theory/domains.md.
class RegionLayout {
 public:
  /// Throws InputError, with a message for the user, for invalid input: an open loop; lines that
  /// cross or touch; a loop that crosses itself; all lines on one straight line; holes outside of
  /// the outline or inside each other; inner lines that leave the region, or cross in the domain
  /// but not in space; a domain type that does not suit the outline. Throws NoSolutionError for a
  /// trimmed mesh whose area does not match the outline.
  RegionLayout(std::string name, const std::vector<CharacterLine>& lines,
               const SkinOptions& options, const Progress& progress = {});

  const std::string& name() const { return name_; }
  const std::shared_ptr<const ParametricMesh>& mesh() const { return geometry_.mesh; }
  const std::shared_ptr<const Trim>& trim() const { return geometry_.trim; }
  TriangleElement element() const { return options_.element; }
  const std::vector<EdgeAlignedLine>& edge_aligned() const { return geometry_.edge_aligned; }
  const std::vector<EmbeddedLine>& embedded() const { return geometry_.embedded; }
  double size() const { return size_; }
  /// Largest allowed distance between a line and its curve, model units.
  double tolerance() const { return tolerance_; }
  const std::vector<std::string>& warnings() const { return geometry_.warnings; }
  const std::vector<DomainCorner>& corners() const { return geometry_.corners; }
  /// Boundary loops as in SkinnedRegion::boundary.
  const std::vector<std::vector<BoundarySegment>>& boundary() const { return geometry_.boundary; }
  /// Change of direction above which the outline has a corner, degrees.
  double corner_angle() const { return options_.corner_angle; }
  SkinOptions::Domain domain() const { return options_.domain; }
  bool convex() const { return options_.convex; }         ///< SkinOptions::convex
  bool uses_rest_shape() const { return options_.rest; }  ///< SkinOptions::rest
  /// Start of the first line, model units.
  Vec3 origin() const;

  /// Builds the constraint equations of every line, exact for edge-aligned lines, at collocation
  /// points for embedded ones. They do not couple x, y and z, and they carry the names of the
  /// lines.
  ConstraintSet line_constraints() const;
  /// Builds the constraint equations of the corner positions only. They do not couple x, y and z
  /// and are named "corner 1", "corner 2", … Throws InputError for a domain without corners.
  ConstraintSet corner_constraints() const;
  /// Builds the region from a shape (its dofs, absolute coordinates).
  SkinnedRegion region(Points dofs) const;

  /// Bisects triangles under embedded lines whose gap to `shape`, between collocation points,
  /// exceeds `target` (model units). Returns false if nothing is bisected. Otherwise the layout has
  /// another mesh, and existing dofs and constraints are invalid.
  bool refine(const Surface& shape, double target);

  // Edits. If one throws, the layout is unchanged. Existing dofs and constraints are invalid after
  // refine(), and after add_inner_line() or remove_inner_line() if collocation points of other
  // lines moved.

  /// Bisects the marked triangles (one mark per triangle) and others as needed for conformity
  /// (bisected()). Then it trims the mesh and chooses collocation points again. Edge-aligned lines
  /// stay edge-aligned. Returns false if nothing is marked. Throws InputError for a wrong number of
  /// marks, and what the constructor throws if lines do not fit together any more.
  bool refine(const std::vector<char>& marked);

  /// True if an edge-aligned or embedded line has this name ("name.1", … after splitting at
  /// corners).
  bool has_line(const std::string& name) const;
  /// The fitted curve of a line. Throws InputError, suggesting the closest name, if there is none.
  const HermiteCurve& line(const std::string& name) const;
  /// Replaces the curve of a line by another one over the same CurveMesh; `line.curve` becomes the
  /// same curve. Coefficients of line_constraints() stay, their values change. It is not checked
  /// that the line still meets its neighbours: contradictory constraints are detected when they are
  /// reduced. Throws InputError for an unknown line, a different CurveMesh, or non-finite values.
  void set_line(const std::string& name, HermiteCurve curve);

  /// Embeds an inner line at the closest points of `shape`, a surface on this layout's mesh. The
  /// line is fitted within tolerance() and split at its corners into "name.1", … The mesh is
  /// unchanged: call refine(shape, target) to bisect triangles with large gaps.
  ///
  /// Throws InputError for a name that exists, a role other than Inner, MeshAlignment::EdgeAligned,
  /// or a shape on another mesh. Also for a line that leaves the region, is far away, or crosses
  /// others in the domain but not in space.
  void add_inner_line(const CharacterLine& line, const Surface& shape);
  /// Removes an embedded inner line. Throws InputError for other lines, and if there is none.
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
