// Smooth (G1) joins: tangent-plane continuity between regions that share a line.
//
// Two regions A and B have the same curve X(t) on edge-aligned lines with the same vertices. Let y
// be the cross-boundary derivative, per unit of t and towards the inside of each region,
//
//      y_A = σ_A ∂x/∂n_A,     σ_A = length of the line in (u, v) per unit of t.
//
// Their tangent planes agree if y_A, y_B and X' are coplanar. The regions are on different sides of
// the line if, with gluing functions γ and δ,
//
//      y_A = -γ y_B + δ X',   γ > 0.                                                       (1)
//
// At a corner of a region, y is determined by the two lines that meet there, and so are γ and δ.
// Between the ends, log γ and δ are cubics along the line. They are fitted by least squares to the
// shapes from which they are planned, if these are nearly tangent (GluingCorrection). For given γ
// and δ, (1) is linear in the dofs and the same for x, y and z: one matrix for all regions of a
// group, solved together. The tangent planes are then those of least energy of both sides. (1) is
// imposed at vertices and at edge midpoints (w_n). In between, y is quadratic along an edge, so
// that
//
//      γ, δ constant:  (1) holds exactly: A and B unfold into one plane, C1 as inside a region;
//      otherwise:      the angle between the surfaces decreases as h³.
//
// At a vertex where the line continues straight (A has no corner there: another line ends on the
// other side), y of A is free. It is set to the mean of -y of its neighbours, the choice of least
// change, and their γ and δ follow. If the tangents at a node are not coplanar, there is no tangent
// plane: (1) then holds only up to the last vertex before the node.
//
// If a region has the line embedded, (1) is imposed on averages over hat functions φ_k along its
// collocation points,
//
//      ∫ φ_k (y_A + γ y_B - δ x_t) dt = 0,     y = |c'| ∂x/∂ν of the embedded side,
//
// and also pointwise at ends where lines meet at a corner. In between, join_stiffness() penalises
// the residual. γ and δ are those that change the first shapes least: γ is the ratio of the
// components of y_A and y_B across the line, δ is the remainder along it. The angle then decreases
// only as h (docs/theory/domains.md).
//
// All constraints are homogeneous in the dofs: X' is expressed by x_t, the derivative of one side
// along the line, and a prescribed y by the dofs of the neighbours. So they hold under any motion
// of the lines, with γ and δ as planned. If tangents at nodes rotate, γ and δ have to be planned
// again.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "batten/skinning/layout/region_layout.h"

namespace batten {

/// A region adjacent to a line.
struct JoinSide {
  int region = 0;         ///< index into the regions of the call
  bool embedded = false;  ///< true: an embedded line of that region; false: an edge-aligned one
  int line = 0;           ///< index among these lines
  /// True if the region lies to the left of the line's direction, seen from the side of its normal.
  bool left = true;
};

/// A line along which two regions (or one region with itself) are joined smoothly.
struct JoinLine {
  std::string name;
  std::array<JoinSide, 2> sides;
  /// Whether fairing makes the curvature continuous (G2) across the line. Unset: determined from
  /// the lines that cross it (is_curvature_continuous()).
  std::optional<bool> curvature = {};
};

/// Plan for one end of a join line, made before solving.
struct JoinEnd {
  double gamma = 1, delta = 0;  ///< gluing functions γ, δ of the G1 condition (1) at this end
  /// Angle between the tangent planes of both sides at the end, degrees; 0 if the lines leave one
  /// free.
  double plane_angle_deg = 0;
  /// The join ends as a crease here: plane_angle_deg is above the limit, so (1) is not imposed.
  bool open = false;
  /// Open although the G1 condition (1) should hold there: on an embedded line the last edge at the
  /// end remains a crease with the angle plane_angle_deg (refine_embedded_joins()). Kept when joins
  /// are planned again.
  bool creased = false;
  /// The cross-boundary derivative y of one side is free there, and no neighbour determines it. (1)
  /// is then imposed with γ = 1, δ = 0.
  bool undetermined = false;
  /// A side of another region, and the end of it (0: start, 1: end).
  struct Neighbour {
    JoinSide side;
    int end;
  };
  /// For each side whose cross-boundary derivative y is free there: the neighbours whose mean of -y
  /// determines it. Empty: y is not free, or is not determined.
  std::array<std::vector<Neighbour>, 2> set;
};
/// Correction of log γ and δ to their linear interpolation between the ends. At the fraction f of a
/// line it is f (1 - f) (c[0] + c[1] (2 f - 1)).
struct GluingCorrection {
  std::array<double, 2> log_gamma{}, delta{};
  bool is_zero() const { return *this == GluingCorrection{}; }
  bool operator==(const GluingCorrection&) const = default;
  static double at(const std::array<double, 2>& c, double f) {
    return f * (1 - f) * (c[0] + c[1] * (2 * f - 1));
  }
};

/// Plan of a smooth join: how the G1 condition (1) is imposed along one line.
struct JoinPlan {
  JoinLine join_line;
  /// At start and end; for an embedded line only `open` and the angle are used.
  std::array<JoinEnd, 2> ends;
  GluingCorrection gluing_correction;  ///< for two edge-aligned lines
  /// For an embedded line: fractions of its parameter, and γ and δ there, linear in between.
  std::vector<double> at, gamma, delta;
  bool closed = false;  ///< for an embedded line: it has no ends
  /// How the G1 condition (1) is imposed at the start and the end of an embedded line.
  /// Hat:   on the average over the hat function, if the regions continue smoothly beyond the end;
  /// Point: pointwise, at a corner where the lines that meet determine y of both sides;
  /// None:  not at all: the end is open, or a side has a corner that the other side does not have.
  enum class EndCondition { None, Hat, Point };
  std::array<EndCondition, 2> end_conditions{};
  /// Message that explains why the line cannot be joined at all; empty: it is joined.
  std::string rejection_reason;
  bool rejected() const { return !rejection_reason.empty(); }
  bool constant() const;  ///< true if edge-aligned, γ and δ constant, and no end open
};

/// Plans smooth joins: computes the gluing functions γ and δ of (1) from given shapes. `shapes`:
/// dofs of each region, which satisfy all lines. `max_plane_angle_deg`: an end whose tangent planes
/// differ by a larger angle is open.
///
/// A join is rejected (JoinPlan::rejection_reason) for: edge-aligned lines with different vertices;
/// tangent planes that differ by more than 90 degrees; γ outside of (1/50, 50); an embedded line
/// shorter than its elements. Regions without join lines may be null.
std::vector<JoinPlan> plan_joins(const std::vector<const RegionLayout*>& regions,
                                 const std::vector<Points>& shapes,
                                 const std::vector<JoinLine>& join_lines,
                                 double max_plane_angle_deg);

/// Maps the dof numbers of a region to those of the model: one offset for vertex dofs, another one
/// for edge dofs.
struct DofOffsets {
  int vertex_dofs = 0;  ///< 3 · number of vertices of the region
  /// Offsets of vertex dofs and of edge dofs.
  int vertices = 0, edges = 0;
  /// The model's number of a dof of the region.
  int operator()(int dof) const { return dof + (dof < vertex_dofs ? vertices : edges); }
};

/// Adds the G1 constraints (1) of all joins that are not rejected, named "smooth curve NAME". Lines
/// that are constrained satisfy (1) at nodes automatically. `free`: nothing constrains the lines,
/// so (1) is imposed at nodes too, except for the last join line around a node, which is implied by
/// the others.
void add_join_constraints(const std::vector<const RegionLayout*>& regions,
                          const std::vector<DofOffsets>& dof_offsets,
                          const std::vector<JoinPlan>& plans, bool free, ConstraintSet& set);

/// Computes the penalty matrix of the residual of the G1 condition (1) on embedded lines, where the
/// constraints enforce only averages over hat functions. It is for bending stiffness β = 1, to be
/// added to the bending stiffness on the domain of size 1; lower triangle, of one coordinate:
///
///     1000 (S/s_A)² ∫ |y_A + γ y_B - δ x_t|² / (σ_A h) dt,      h = √(2 · area of the triangle).
///
/// Zero if no join line is embedded. `size`: S, the size of the model. `dofs`: order of the matrix.
SparseMatrix join_stiffness(const std::vector<const RegionLayout*>& regions,
                            const std::vector<DofOffsets>& dof_offsets,
                            const std::vector<JoinPlan>& plans, double size, int dofs);

/// Adds constraints named "joined curve NAME" that keep adjacent regions together along a line
/// that is not constrained itself. For two edge-aligned lines, positions and slopes along the line agree
/// at vertices. If a region has the line embedded, positions agree on the average over each hat.
void add_line_ties(const std::vector<const RegionLayout*>& regions,
                   const std::vector<DofOffsets>& dof_offsets, const JoinLine& line,
                   ConstraintSet& set);

/// Quality of a join between finished regions. Angles are between their tangent planes, degrees: 0
/// if smooth, 180 if one region folds back onto the other, NaN if a surface is singular.
struct JoinQuality {
  double max_gap = 0;  ///< largest distance between the two sides, model units
  /// Largest angle.
  double max_deg = 0;
  double mean_deg = 0;              ///< averaged over the length of the line
  std::array<double, 2> end_deg{};  ///< at the start and the end of the line
  /// Largest angle, without the first or the last edge if that end is open.
  double max_inside_deg = 0;
  /// Median and largest jump of the normal curvature perpendicular to the line, 1/length, without
  /// edges at open ends. 0 if the curvature is continuous.
  double median_curvature_jump = 0, max_curvature_jump = 0;
  /// Integral along the line of the angle between the normals (radians), model units. Positive if
  /// the edge is convex seen from the side of the normals. Meaningless if both regions lie on the
  /// same side of the line.
  double convexity = 0;
};
/// Measures the gap and the angle between the two regions of a join at samples + 1 points per edge,
/// ends included. `open`: for each end of the join, true if tangent continuity is not imposed there,
/// so that the join ends as a crease.
JoinQuality measure_join(const std::vector<const SkinnedRegion*>& regions,
                         const JoinLine& join_line, const std::array<bool, 2>& open = {},
                         int samples = 8);

// Lookup of a line on the boundary of a finished region.

/// Finds the boundary line of this name of a finished region; nullopt if there is none. `region`:
/// copied to JoinSide::region.
std::optional<JoinSide> side_of(const SkinnedRegion& made, int region, const std::string& name);

}  // namespace batten
