// Makes the domain and the mesh of one region from its character lines.
#pragma once

#include <string>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/core/progress.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

struct DomainInput;  // skinning/domains/domain_input.h

/// A region before it has a shape: its domain, its mesh, and how each line lies on it. It is made
/// in these steps:
///
/// 1. lines are cut at their corners (into "name.1", "name.2", …), outline lines joined at their
///    ends into loops, hole lines too;
/// 2. a domain is chosen:
///      polygon  one loop with three corners or more: bends at the line's corners only, sides as
///               long and corners as wide as the lines make them; every outline line is a straight
///               run of element edges, fitted exactly. Inner lines are straight runs across where
///               they can be;
///      plane    other outlines: their projection; all lines are embedded, the mesh is cut;
///      ring     two smooth loops: a strip that is periodic in u, both rims fitted;
///      sheet    a loop without a polygon that does not project simply either: its developable
///               filling, unfolded like a strip of paper; all lines are embedded;
///    scaled so that the region's size is 1: (u, v) has no unit;
/// 3. the outline becomes C1 cubic Hermite curves (exact where the input is piecewise cubic) on
///    that domain, which is meshed;
/// 4. holes, and inner lines that cannot be fitted (closed, bent, ending inside, crossing), are
///    embedded: on a plane where they are seen, on other domains where the surface that the outline
///    alone makes is nearest to them;
/// 5. the mesh is cut along embedded boundaries. Embedded lines are held at points; the gap between
///    these is measured, and triangles there are halved until it is below tolerance/2 for the shape
///    of least bending.
/// The domain runs counter-clockwise along the outline in the direction of its first line, so that
/// line's direction decides to which side the surface's normal points. u runs along that line's
/// side of the polygon, around the ring, or along the projected x axis (y where the plane is at
/// right angles to x); directional alpha and beta refer to it.
/// Source: straight-run rule and embedded lines, docs/theory/domains.md.
class RegionLayout {
 public:
  /// Throws InputError, in words for the user, for what it refuses: an open loop, lines that cross
  /// or touch, a loop that crosses itself, all lines on one line, holes outside of the outline or
  /// in each other, inner lines that leave the region or cross at different heights, a domain that
  /// does not suit the outline. NoSolutionError: a cut whose area does not add up.
  RegionLayout(std::string name, const std::vector<CharacterLine>& lines,
               const SkinOptions& options, const Progress& progress = {});

  const std::string& name() const { return name_; }
  const std::shared_ptr<const ParametricMesh>& mesh() const { return geometry_.mesh; }
  const std::shared_ptr<const Trim>& trim() const { return geometry_.trim; }
  TriangleElement element() const { return options_.element; }
  const std::vector<EdgeAlignedLine>& edge_aligned() const { return geometry_.edge_aligned; }
  const std::vector<EmbeddedLine>& embedded() const { return geometry_.embedded; }
  double size() const { return size_; }
  /// Returns the largest distance that a line may have from its curve, model units.
  double tolerance() const { return tolerance_; }
  const std::vector<std::string>& warnings() const { return geometry_.warnings; }
  const std::vector<DomainCorner>& corners() const { return geometry_.corners; }
  /// Returns the boundary loops as in SkinnedRegion::boundary.
  const std::vector<std::vector<BoundarySegment>>& boundary() const { return geometry_.boundary; }
  /// Returns the angle, degrees, above which the outline turns a corner.
  double corner_angle() const { return options_.corner_angle; }
  SkinOptions::Domain domain() const { return options_.domain; }
  bool convex() const { return options_.convex; }         ///< SkinOptions::convex
  bool uses_rest_shape() const { return options_.rest; }  ///< SkinOptions::rest
  /// Returns the start of the first line.
  Vec3 origin() const;

  /// Returns the rows that hold every line, fitted ones exactly, embedded ones at their points.
  /// They are uncoupled and have the names of the lines.
  ConstraintSet line_constraints() const;
  /// Returns the rows that hold only the positions of the corners. They are uncoupled and named
  /// "corner 1", "corner 2", … Throws InputError for a domain without corners.
  ConstraintSet corner_constraints() const;
  /// Returns the region in the shape with these dofs.
  SkinnedRegion region(Points dofs) const;

  /// Halves triangles where a shape's embedded lines miss their curves by more than `target`
  /// between points. Returns false when there is nothing to halve; otherwise the layout has another
  /// mesh, and dofs and constraints made before do not fit it any more.
  bool refine(const Surface& shape, double target);

  // Edits. Each throws before it has changed anything: the layout is then as it was. After
  // refine() and, where points of other lines moved, after add_inner_line() and remove_inner_line(), dofs and
  // constraints made before do not fit any more.

  /// Halves the marked triangles, one mark for each, and so many others that the mesh stays
  /// conforming (bisected()); cuts it and places the points of embedded lines again. Runs stay
  /// runs. Returns false when nothing is marked. Throws InputError on a wrong count, and what the
  /// constructor throws when lines do not fit together any more.
  bool refine(const std::vector<char>& marked);

  /// Whether a run or an embedded line has this name ("name.1", … where a line was cut at corners).
  bool has_line(const std::string& name) const;
  /// Returns the fitted curve of a line. Throws InputError, with the nearest name, when there is
  /// none.
  const HermiteCurve& line(const std::string& name) const;
  /// Gives a line another shape over the same CurveMesh; `line.curve` becomes the same curve. The
  /// rows of line_constraints() keep their coefficients, their values change. Whether it still
  /// meets its neighbours is not checked here: constraints that contradict each other are found
  /// when they are reduced. Throws InputError: no such line, another mesh, numbers that are not
  /// finite.
  void set_line(const std::string& name, HermiteCurve curve);

  /// Embeds an inner line where `shape`, a surface on this layout's mesh, is nearest to it; fitted
  /// within tolerance(), cut at its corners into "name.1", … The mesh stays as it is: refine(shape,
  /// target) then halves where gaps are wide. Throws InputError: a name that is taken, a role other
  /// than Inner, Treatment::EdgeAligned, a ring, a shape on another mesh, a line that leaves the region,
  /// is far away, or crosses others at different heights.
  void add_inner_line(const CharacterLine& line, const Surface& shape);
  /// Takes an embedded inner line out again. Throws InputError for other lines, or none.
  void remove_inner_line(const std::string& name);

 private:
  DomainInput task() const;
  std::vector<std::string> line_names() const;
  std::string name_;
  SkinOptions options_;
  double size_ = 1, tolerance_ = 0, edge_length_ = 0, gap_tolerance_ = 0;
  RegionGeometry geometry_;
};

}  // namespace batten
