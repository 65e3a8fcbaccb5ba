// Smooth joins: regions that share a line and their tangent planes along it.
//
// Two regions A and B carry the same curve X(t) on runs with the same vertices. With y the slope
// across the line, per unit of t and towards the inside of each region,
//
//      y_A = σ_A ∂x/∂n_A,     σ_A = length of the run in (u, v) per unit of t,
//
// their tangent planes agree where y_A, y_B and X' lie in one plane, and are on different sides of
// the line where
//
//      y_A = -γ y_B + δ X',   γ > 0.                                                       (1)
//
// At a corner of a region y is fixed by the two lines that meet there, and so are γ and δ; between
// its ends log γ and δ are cubics along the line, those of least squares for the shapes from which
// they are planned, where these are nearly tangent (GluingCorrection). With γ and δ known (1) is linear in the dofs
// and the same for x, y and z: one matrix for all regions of a group, solved together, and the
// tangent planes come out as those of least energy of both sides. (1) is imposed at the vertices
// and at the middles of edges (w_n). Between these, y is quadratic along an edge, so that
//
//      γ, δ constant:  (1) holds all along: A and B unfold into one plane, C1 as inside of a region
//      otherwise:      the angle between the surfaces falls with h³.
//
// At a vertex where the line goes on straight (A has no corner there: another line ends on the
// other side), y of A is free. It is set to the mean of -y of its neighbours, the choice of least
// change, and γ and δ of these follow. Where the tangents at a node do not lie in one plane there
// is no tangent plane: (1) then holds up to the last vertex before it.
//
// Where a region has the line embedded, (1) is imposed on averages over hats φ_k along its points,
//
//      ∫ φ_k (y_A + γ y_B - δ x_t) dt = 0,     y = |c'| ∂x/∂ν of the embedded side,
//
// at ends where lines meet at a corner also pointwise, and between as join_stiffness() can. γ, δ
// are those that change the first shapes least: γ the ratio of the parts of y_A and y_B
// across the line, δ what is left along it. The angle then falls with h only
// (docs/theory/domains.md).
//
// All rows are homogeneous in the dofs: for X' they have x_t, the slope of one side along the line,
// and for a y that is set the dofs of the neighbours. So they hold whatever moves the lines, with γ
// and δ as they were planned; where tangents turn at nodes these have to be planned again.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "batten/skinning/layout/region_layout.h"

namespace batten {

/// A region that lies beside a line.
struct JoinSide {
  int region = 0;         ///< index into the regions of the call
  bool embedded = false;  ///< an embedded line of that region, otherwise a run
  int line = 0;           ///< its index there
  /// The region lies to the left of the line's direction, seen from its normal's side.
  bool left = true;
};

/// A line along which two regions (or one with itself) are to be joined.
struct JoinLine {
  std::string name;
  std::array<JoinSide, 2> sides;
  /// Whether fairing lets the curvature go on across it, or jump. None: as the lines across it do
  /// (curvature_join_points.h).
  std::optional<bool> curvature = {};
};

/// What is planned for one end of a join line, before anything is solved.
struct JoinEnd {
  double gamma = 1, delta = 0;  ///< coefficients γ, δ of (1)
  /// Angle between the tangent planes of both sides there, degrees; 0 where the lines leave one
  /// free.
  double plane_angle_deg = 0;
  bool open = false;  ///< (1) does not hold at this node: plane_angle_deg is above the limit
  /// Open although (1) is asked for there: on an embedded line the edge beside the end keeps the angle
  /// plane_angle_deg (refine_embedded_joins()). Stays when joins are planned anew.
  bool creased = false;
  /// y of a side is free there and no neighbour sets it: (1) holds with γ = 1, δ = 0.
  bool undetermined = false;
  /// A side of another region, and which of its ends (0: start, 1: end) is meant.
  struct Neighbour {
    JoinSide side;
    int end;
  };
  /// For each side whose y is free there: the neighbours, whose mean of -y it is set to. Empty: y
  /// is not set.
  std::array<std::vector<Neighbour>, 2> set;
};
/// What log γ and δ have beyond the linear run between their ends, at the fraction f of a line:
/// f (1 - f) (c[0] + c[1] (2 f - 1)).
struct GluingCorrection {
  std::array<double, 2> log_gamma{}, delta{};
  bool is_zero() const { return *this == GluingCorrection{}; }
  bool operator==(const GluingCorrection&) const = default;
  static double at(const std::array<double, 2>& c, double f) {
    return f * (1 - f) * (c[0] + c[1] * (2 * f - 1));
  }
};

/// How (1) is imposed along one join line.
struct JoinPlan {
  JoinLine join_line;
  std::array<JoinEnd, 2> ends;  ///< start and end; of an embedded line only whether it is open
  GluingCorrection gluing_correction;  ///< of two runs
  /// For an embedded line: fractions of its parameter, and γ and δ there, linear between.
  std::vector<double> at, gamma, delta;
  bool closed = false;  ///< of an embedded line: it has no ends
  /// For an embedded line, what is imposed at its start and end: (1) on the average over the hat
  /// there, where its regions go on smoothly beyond it; (1) itself at a corner, where the lines that
  /// meet give y of both sides; or nothing, where the end is open or a side has a corner that the
  /// other does not see.
  enum class EndCondition { None, Hat, Point };
  std::array<EndCondition, 2> end_conditions{};
  std::string
      rejection_reason;  ///< in words, where it is given up: why the line cannot be joined at all
  bool rejected() const { return !rejection_reason.empty(); }
  bool constant() const;  ///< γ and δ are the same at both ends, and neither is open
};

/// Plans joins: computes γ and δ from shapes that have all lines (dofs of each region).
/// `max_plane_angle_deg`: an end at which the tangent planes differ by more is open. JoinPlan::rejection_reason
/// says why a join line has to be given up: runs with other vertices, tangent planes that differ by
/// more than 90 degrees, γ outside of (1/50, 50), an embedded line shorter than its elements.
/// Regions that no join line has may be null.
std::vector<JoinPlan> plan_joins(const std::vector<const RegionLayout*>& regions,
                                 const std::vector<Points>& shapes,
                                 const std::vector<JoinLine>& join_lines,
                                 double max_plane_angle_deg);

/// The numbers that the dofs of a region have in a model: one number is added to those of vertices,
/// another one to those of edges.
struct DofOffsets {
  int vertex_dofs = 0;  ///< 3 · vertices of the region
  int vertices = 0, edges = 0;
  int operator()(int dof) const { return dof + (dof < vertex_dofs ? vertices : edges); }
};

/// Adds (1) along all join lines that are not given up, as rows with the name "smooth line NAME".
/// Lines that are held make (1) true at nodes by themselves. With `free` nothing holds them, and
/// (1) is imposed there as well, but for the last join line around a node, which the others imply.
void add_join_constraints(const std::vector<const RegionLayout*>& regions,
                          const std::vector<DofOffsets>& dof_offsets,
                          const std::vector<JoinPlan>& plans, bool free, ConstraintSet& set);

/// Between hats the rows leave (1) open on embedded lines. This is what its square costs there, with
/// β = 1, beside the bending energy on the domain of size 1; lower triangle, of one coordinate,
///
///     1000 (S/s_A)² ∫ |y_A + γ y_B - δ x_t|² / (σ_A h) dt,      h = √(2 · area of the triangle).
///
/// Zeros where no join line is embedded. `size`: S of the model.
SparseMatrix join_stiffness(const std::vector<const RegionLayout*>& regions,
                            const std::vector<DofOffsets>& dof_offsets,
                            const std::vector<JoinPlan>& plans, double size, int dofs);

/// Adds rows with the name "joined line NAME" that keep the regions beside a line together where
/// nothing holds the line itself: places and slopes along it are the same at the vertices of two
/// runs; where a region has it embedded, places are the same on the average of each hat.
void add_line_ties(const std::vector<const RegionLayout*>& regions,
                   const std::vector<DofOffsets>& dof_offsets, const JoinLine& line,
                   ConstraintSet& set);

/// How finished regions meet along a join line. Angles are those between their tangent planes,
/// degrees: 0 where they go on smoothly, 180 where one doubles back on the other; NaN where a
/// surface is singular.
struct JoinQuality {
  double max_gap = 0;  ///< largest distance between the two sides, model units
  double max_deg = 0;
  double mean_deg = 0;              ///< over the length of the line
  std::array<double, 2> end_deg{};  ///< angle at the start and the end of the join line
  /// Largest angle without the first edge, or the last, where that end is open.
  double max_inside_deg = 0;
  /// Median and largest jump of the normal curvature at right angles to the line, without edges at
  /// open ends, 1/length: 0 where the curvature goes on.
  double median_curvature_jump = 0, max_curvature_jump = 0;
  /// Integral along the line of the angle between the normals (radians), positive where the edge is
  /// convex seen from the side of the normals; model units. It means nothing where both regions lie
  /// on one side of the line.
  double convexity = 0;
};
/// Measures it at samples + 1 places of each edge, its ends among them. `open`: (1) was given up at
/// that end.
JoinQuality measure_join(const std::vector<const SkinnedRegion*>& regions,
                         const JoinLine& join_line, const std::array<bool, 2>& open = {},
                         int samples = 8);


// The side by which a finished region has a line on its boundary.

/// Returns the side by which a finished region has a line of this name on its boundary, or nothing
/// when it has none. `region`: JoinSide::region of what is returned.
std::optional<JoinSide> side_of(const SkinnedRegion& made, int region, const std::string& name);

}  // namespace batten
