// SPDX-License-Identifier: MPL-2.0
// Smooth (G1) joins: tangent-plane continuity between two faces that share a curve.
//
// Two faces A and B share a mesh-aligned curve X(t) and have the same mesh vertices on it. Let y be
// the cross-boundary derivative of a face, per unit of t and towards the inside of the face,
//
//      y_A = σ_A ∂x/∂n_A,     σ_A = length of the curve in (u, v) per unit of t.
//
// The tangent planes of A and B agree if y_A, y_B and X' are coplanar. The faces also lie on
// different sides of the curve if, with gluing functions γ and δ,
//
//      y_A = -γ y_B + δ X',   γ > 0.                                                       (1)
//
// At a corner of a face, y is determined by the two curves that meet there, and so are γ and δ.
// Between the ends, log γ and δ are cubics along the curve. They are fitted by least squares to the
// shapes from which they are planned, if these are nearly tangent (GluingCorrection). For given γ
// and δ, (1) is linear in the dofs and the same for x, y and z: one matrix for all faces of a
// group, solved together. The tangent planes are then those of least energy of both sides. (1) is
// imposed at vertices and at edge midpoints (w_n). In between, y is quadratic along an edge, so
// that
//
//      γ, δ constant:  (1) holds exactly: A and B unfold into one plane, C1 as inside a face;
//      otherwise:      the angle between the surfaces decreases as h³.
//
// At a vertex where the curve continues straight (A has no corner there: another curve ends on the
// other side), y of A is free. It is set to the mean of -y of the adjacent faces, which is the
// choice of least change, and determines γ and δ of these joins. If the tangents at a node are not
// coplanar, there is no tangent plane: (1) then holds only up to the last vertex before the node.
//
// If a face has the curve embedded, (1) is imposed on averages over hat functions φ_k along its
// collocation points,
//
//      ∫ φ_k (y_A + γ y_B - δ x_t) dt = 0,     y = |c'| ∂x/∂ν of the embedded side,
//
// and also pointwise at ends where curves meet at a corner. In between, join_stiffness() penalises
// the residual. γ and δ are chosen to change the initial shapes least: γ is the ratio of the
// components of y_A and y_B across the curve, δ is the remainder along it. The angle then decreases
// only as h (docs/theory/domains.md).
//
// The second side of a join may also be a given surface that is not part of the model
// (neighbour_edge.h). Its y_B is known: |X'| times the unit vector of its tangent plane across the
// curve, so that (1) has a right-hand side. γ and δ are planned as above.
//
// Without given surfaces, all constraints are homogeneous in the dofs: X' is expressed by x_t, the derivative of one side
// along the curve, and a prescribed y by the dofs of the adjacent faces. With given γ and δ, the
// constraints therefore hold for any motion of the curves. If tangents at nodes rotate, γ and δ
// must be planned again.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/skinning/layout/region_layout.h"
#include "batten/skinning/model/neighbour_edge.h"

namespace batten {

/// One of the two faces that are joined along a curve, and its representation of this curve.
///
/// If `neighbour` is set, this side is a given surface that is not part of the model. The other
/// members then describe the face on the opposite side, except that `left` is reversed.
struct JoinSide {
  int region = 0;         ///< index into the faces of the model
  bool embedded = false;  ///< true: the face has the curve embedded; false: mesh-aligned
  int line = 0;           ///< index into the face's embedded or mesh-aligned curves
  /// True if the face lies to the left of the directed curve, seen from the tip of the face's
  /// normal.
  bool left = true;
  /// The given surface along the curve, or null if this side is a face of the model.
  std::shared_ptr<const NeighbourEdge> neighbour = {};
};

/// A curve along which two faces (or one face with itself) are joined smoothly.
struct JoinLine {
  std::string name;
  std::array<JoinSide, 2> sides;  ///< only the second one may be a given surface
  /// The given surface that the face continues, or null if two faces of the model are joined.
  const NeighbourEdge* neighbour() const { return sides[1].neighbour.get(); }
  /// True if fairing makes the curvature continuous (G2) across this curve, false if not. Unset:
  /// is_curvature_continuous() determines it from the curves that cross this curve.
  std::optional<bool> curvature = {};
};

/// How tangent-plane continuity (G1) of two faces is imposed at one end of their shared curve.
struct JoinEnd {
  /// Gluing functions γ, δ at this end, in the G1 condition y_A = -γ y_B + δ X', where y_A, y_B are
  /// the cross-boundary derivatives of both faces and X' is the derivative of the curve.
  double gamma = 1, delta = 0;
  /// Angle between the tangent planes of both faces at this end, degrees; 0 if the curves that meet
  /// there do not determine both tangent planes.
  double plane_angle_deg = 0;
  /// True: the join ends as a crease, because G1 continuity is not imposed at this end of the
  /// curve: plane_angle_deg is above the limit of plan_joins(), or `creased` is true.
  bool open = false;
  /// True: G1 continuity is given up at this end, because refinement could not reduce the angle in
  /// the last mesh edge of an embedded curve. Planning the joins again keeps this value.
  bool creased = false;
  /// True: at this end, neither curves nor adjacent joins determine the cross-boundary derivative
  /// of one of the two faces. The G1 condition is then imposed with γ = 1, δ = 0 or, beside a given
  /// surface, with γ and δ of the initial shape.
  bool undetermined = false;
  /// A face at an adjacent join, and the end of the curve of this join (0: start, 1: end).
  struct Neighbour {
    JoinSide side;
    int end;
  };
  /// For each of the two joined faces: the faces at adjacent joins that determine its
  /// cross-boundary derivative at this end, as the negative mean of their own derivatives. Empty if
  /// curves determine the derivative, or if no adjacent join does.
  std::array<std::vector<Neighbour>, 2> set;
};
/// Correction of log γ and δ along a join, where γ and δ are the gluing functions of the G1
/// condition. It is added to the linear interpolation between the ends of the join. At the fraction
/// f of the curve it is f (1 - f) (c[0] + c[1] (2 f - 1)), with c = `log_gamma` or c = `delta`.
struct GluingCorrection {
  std::array<double, 2> log_gamma{}, delta{};
  bool is_zero() const { return *this == GluingCorrection{}; }
  bool operator==(const GluingCorrection&) const = default;
  static double at(const std::array<double, 2>& c, double f) {
    return f * (1 - f) * (c[0] + c[1] * (2 * f - 1));
  }
};

/// How tangent-plane continuity (G1) of two faces is imposed along their shared curve.
struct JoinPlan {
  JoinLine join_line;
  /// Conditions at the start and the end of the curve. If a face has the curve embedded, only
  /// JoinEnd::open and JoinEnd::plane_angle_deg are used.
  std::array<JoinEnd, 2> ends;
  GluingCorrection gluing_correction;  ///< used only if both faces have the curve mesh-aligned
  /// If a face has the curve embedded: fractions (0 to 1) of the parameter interval, and the gluing
  /// functions γ and δ of the G1 condition there, interpolated linearly in between.
  std::vector<double> at, gamma, delta;
  bool closed = false;  ///< true: the embedded curve is closed and has no ends
  /// How tangent-plane continuity (G1) is imposed at an end of an embedded curve.
  /// Hat:   on the average over a hat function, if the faces continue smoothly beyond the end.
  /// Point: pointwise, at a corner at which the curves determine the tangent planes of both faces.
  /// None:  not imposed: JoinEnd::open is true, or only one of the faces has a corner there.
  enum class EndCondition { None, Hat, Point };
  std::array<EndCondition, 2> end_conditions{};
  /// Reason why the faces cannot be joined smoothly along this curve, or "" if they can.
  std::string rejection_reason;
  bool rejected() const { return !rejection_reason.empty(); }
  /// True if both faces have the curve mesh-aligned, the gluing functions are constant along it,
  /// and tangent-plane continuity is imposed at both ends.
  bool constant() const;
};

/// Plans smooth joins: computes their gluing functions γ and δ from given shapes of the faces. At a
/// join of faces A and B along the curve X(t), the G1 condition is y_A = -γ y_B + δ X' with the
/// cross-boundary derivatives y_A and y_B. `regions`: the faces; faces without smooth joins may be
/// null. `shapes`: dofs of each face, which satisfy the constraints of all curves.
/// `max_plane_angle_deg`: if the tangent planes at an end of a join differ by a larger angle, the
/// join ends as a crease there.
///
/// A join is rejected (JoinPlan::rejection_reason) if the faces have different mesh vertices on a
/// mesh-aligned curve; if the tangent planes differ by more than 90 degrees, or by more than 150
/// degrees from those of a given surface; if γ is outside of (1/50, 50); or if an embedded curve is
/// shorter than the elements that it crosses.
std::vector<JoinPlan> plan_joins(const std::vector<const RegionLayout*>& regions,
                                 const std::vector<Points>& shapes,
                                 const std::vector<JoinLine>& join_lines,
                                 double max_plane_angle_deg);

/// Maps the dof numbers of a face to those of the model: one offset for vertex dofs, another one
/// for edge dofs.
struct DofOffsets {
  int vertex_dofs = 0;  ///< 3 · number of vertices of the face
  /// Offsets from the numbers in the face to those in the model, for vertex dofs and for edge dofs.
  int vertices = 0, edges = 0;
  /// Number in the model of the dof with the number `dof` in the face.
  int operator()(int dof) const { return dof + (dof < vertex_dofs ? vertices : edges); }
};

/// Adds the constraints of tangent-plane continuity (G1) of all joins that are not rejected, named
/// "smooth curve NAME". If the curves are constrained, continuity holds at the nodes automatically.
/// `free`: true if the curves are not constrained. The constraints are then imposed at the nodes
/// too, except for the last join around a node, which the other joins imply.
void add_join_constraints(const std::vector<const RegionLayout*>& regions,
                          const std::vector<DofOffsets>& dof_offsets,
                          const std::vector<JoinPlan>& plans, bool free, ConstraintSet& set);

/// Penalty on the residual of the G1 condition, ½ qᵀ K q - qᵀ F for the dofs q, as matrix K and
/// load F. See join_penalty().
struct JoinPenalty {
  SparseMatrix stiffness;  ///< K: lower triangle for one coordinate
  Points load;             ///< F: non-zero only at joins with given surfaces
};

/// Computes the penalty for tangent-plane continuity (G1) on embedded curves, on which constraints
/// enforce only averages. It is for one coordinate and the bending stiffness β = 1, to be added to
/// the bending stiffness matrix on the domain of size 1:
///
///     ½ · 1000 (S/s_A)² ∫ |y_A + γ y_B - δ x_t|² / (σ_A h) dt,      h = √(2 · area of the triangle).
///
/// The penalty is zero if no join is on an embedded curve. For faces A and B, y_A and y_B are the
/// cross-boundary derivatives, x_t is the derivative along the curve, γ and δ are the gluing
/// functions. s_A is the size of face A, σ_A the length of the curve in (u, v) per unit of t.
/// `size`: size S of the model. `dofs`: number of rows of the matrix.
JoinPenalty join_penalty(const std::vector<const RegionLayout*>& regions,
                         const std::vector<DofOffsets>& dof_offsets,
                         const std::vector<JoinPlan>& plans, double size, int dofs);

/// Adds constraints named "joined curve NAME" that keep adjacent faces together along a curve whose
/// own position is not constrained. If both faces have the curve mesh-aligned, positions and
/// derivatives along the curve agree at vertices. If a face has the curve embedded, positions agree
/// on averages weighted by hat functions along the curve.
void add_line_ties(const std::vector<const RegionLayout*>& regions,
                   const std::vector<DofOffsets>& dof_offsets, const JoinLine& line,
                   ConstraintSet& set);

/// Quality of a join between two solved faces. Angles are between the tangent planes of the faces,
/// in degrees: 0 if smooth, 180 if one face folds back onto the other, NaN if a face has no normal.
struct JoinQuality {
  double max_gap = 0;  ///< largest distance between the two faces along the curve, model units
  /// Largest angle between the tangent planes of the two faces along the curve, degrees.
  double max_deg = 0;
  double mean_deg = 0;              ///< mean angle between the tangent planes, degrees
  std::array<double, 2> end_deg{};  ///< angle of the tangent planes at start and end, degrees
  /// Largest angle between the tangent planes, degrees, excluding the mesh edge at an end of the
  /// curve if `open` is true for this end (measure_join()).
  double max_inside_deg = 0;
  /// Median and largest difference, between the two faces, of the normal curvature perpendicular to
  /// the curve, 1/length. Mesh edges at ends at which the join is a crease are excluded. 0: the
  /// curvature is continuous.
  double median_curvature_jump = 0, max_curvature_jump = 0;
  /// Integral along the curve of the angle between the normals of both faces (radians), model
  /// units. The value is positive if the edge is convex, seen from the side to which the normals
  /// point. It is meaningless if both faces lie on the same side of the curve.
  double convexity = 0;
};
/// Measures the gap and the angle between the two faces of a join at `samples` + 1 points per mesh
/// edge, including the ends. `open`: for each end of the join, true if tangent continuity is not
/// imposed there, so that the join ends as a crease.
JoinQuality measure_join(const std::vector<const SkinnedRegion*>& regions,
                         const JoinLine& join_line, const std::array<bool, 2>& open = {},
                         int samples = 8);

// Lookup of a curve on the boundary of a finished face.

/// Finds the curve called `name` on the boundary of a face; nullopt if there is no such curve.
/// `made`: the solved face. `region`: index of this face, stored in JoinSide::region of the result.
std::optional<JoinSide> side_of(const SkinnedRegion& made, int region, const std::string& name);

}  // namespace batten
