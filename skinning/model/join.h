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
// its ends log γ and δ run linearly along the line. With γ and δ known (1) is linear in the dofs
// and the same for x, y and z: one matrix for all regions of a group, solved together, and the
// tangent planes come out as those of least energy of both sides. (1) is imposed at the vertices
// and at the middles of edges (w_n). Between these, y is quadratic along an edge, so that
//
//      γ, δ constant:  (1) holds all along: A and B unfold into one plane, C1 as inside of a region
//      otherwise:      the angle between the surfaces falls with h³.
//
// At a vertex where the line goes on straight (no corner of A there: another line ends on the other
// side), y of A is free; it is set to that of least change, the mean of -y of its neighbours, and γ
// and δ of these follow. Where the tangents at a node do not lie in one plane there is no tangent
// plane: (1) then holds up to the last vertex before it.
//
// Where a region has the line embedded, (1) is imposed on averages over hats φ_k along its points,
//
//      ∫ φ_k (y_A + γ y_B - δ x_t) dt = 0,     y = |c'| ∂x/∂ν of the embedded side,
//
// and γ, δ are those that change the first shapes least: γ the ratio of the parts of y_A and y_B
// across the line, δ what is left along it. The angle then falls with h only
// (docs/theory/domains.md).
//
// All rows are homogeneous in the dofs: X' is x_t, the slope of one side along the line, and y of a
// neighbour is that neighbour's. So they hold whatever moves the lines, with γ and δ as they were
// planned; where tangents turn at nodes these have to be planned again.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "batten/skinning/layout/region_layout.h"

namespace batten {

/// A region beside a line.
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
};

/// What is known of a join line before it is solved for, at its start and end.
struct JoinEnd {
  double gamma = 1, delta = 0;  ///< coefficients γ, δ of (1)
  /// Angle between the tangent planes that the lines make there, degrees; 0 where they leave them
  /// free. Above the limit of plan_joins() (1) does not hold at this node.
  double apart_deg = 0;
  bool open = false;  ///< (1) does not hold at this node
  /// y of a side is free there and there is nothing to set it to: (1) with γ = 1, δ = 0.
  bool loose = false;
  /// Where y of a side is free: the other regions' sides and ends (1: at its end), the mean of
  /// whose -y it is set to. Empty: it is not.
  struct Neighbour {
    JoinSide side;
    int end;
  };
  std::array<std::vector<Neighbour>, 2> set;
};
struct JoinPlan {
  JoinLine join_line;
  std::array<JoinEnd, 2>
      ends;  ///< start and end of a join line of two runs (not of embedded lines)
  /// For an embedded line: fractions of its parameter, and γ and δ there, linear between.
  std::vector<double> at, gamma, delta;
  std::string why_not;  ///< in words: why it cannot be joined at all
  bool constant() const;
};

/// γ, δ and what stands in the way, from shapes that have all lines (dofs of each region).
/// `most_apart_deg`: tangent planes at a node that differ by more are no plane. Join lines that have to
/// be given up say why: runs with other vertices, regions that lie on the same side (γ ≤ 0, or out
/// of [1/50, 50]). Regions that no join line has may be null.
std::vector<JoinPlan> plan_joins(const std::vector<const RegionLayout*>& regions,
                                 const std::vector<Points>& shapes,
                                 const std::vector<JoinLine>& join_lines, double most_apart_deg);

/// Which numbers the dofs of a region have among those of a model: 3·vertices of the region, then
/// its edges, are moved by one number each.
struct RegionNumbers {
  int vertex_dofs = 0;  ///< 3 · vertices of the region
  int vertices = 0, edges = 0;
  int operator()(int dof) const { return dof + (dof < vertex_dofs ? vertices : edges); }
};

/// Adds (1) along all join lines that are not given up, as "smooth line NAME". Lines that are held make
/// (1) true at nodes by themselves; where they are `free` it is imposed there as well, but for the
/// last join line around a node, which the others imply.
void add_join_rows(const std::vector<const RegionLayout*>& regions,
                   const std::vector<RegionNumbers>& numbers, const std::vector<JoinPlan>& plans,
                   bool free, ConstraintSet& set);

/// Adds rows that keep the regions beside a line together where nothing holds the line itself, as
/// "joined line NAME": places and slopes along it are the same at the vertices of two runs, the
/// places on the average of each hat where a region has it embedded.
void add_line_ties(const std::vector<const RegionLayout*>& regions,
                   const std::vector<RegionNumbers>& numbers, const JoinLine& line,
                   ConstraintSet& set);

/// The angle between the surfaces' planes along a join line of finished regions, degrees: 0 where they
/// go on smoothly, 180 where one doubles back on the other. `samples` in each edge, both ends of
/// the join line among them; NaN where a surface is singular.
struct JoinAngle {
  double max_deg = 0, mean_deg = 0;
  std::array<double, 2> end_deg{};  ///< angle at the start and the end of the join line
  /// Largest angle without the first or last edge where (1) was given up at that end.
  double max_inside_deg = 0;
};
JoinAngle join_angle(const std::vector<const SkinnedRegion*>& regions, const JoinLine& join_line,
                     const std::array<bool, 2>& open = {}, int samples = 8);

}  // namespace batten
