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
// All constraints are homogeneous in the dofs: X' is expressed by x_t, the derivative of one side
// along the curve, and a prescribed y by the dofs of the adjacent faces. With given γ and δ, the
// constraints therefore hold for any motion of the curves. If tangents at nodes rotate, γ and δ
// must be planned again.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "batten/skinning/layout/region_layout.h"

namespace batten {

/// One side of a join: a face, and its representation of the shared curve.
struct JoinSide {
  int region = 0;         ///< index into the faces of the model
  bool embedded = false;  ///< true: the face has the curve embedded; false: mesh-aligned
  int line = 0;           ///< index into the embedded or the mesh-aligned curves of the face
  /// True if the face lies to the left of the directed curve, seen from the tip of the face's
  /// normal.
  bool left = true;
};

/// A curve along which two faces (or one face with itself) are joined smoothly.
struct JoinLine {
  std::string name;
  std::array<JoinSide, 2> sides;
  /// True if fairing makes the curvature continuous (G2) across this curve. Unset:
  /// is_curvature_continuous() decides, by the curves that cross this curve.
  std::optional<bool> curvature = {};
};

/// How a smooth join is imposed at one end of the shared curve; determined before solving.
struct JoinEnd {
  double gamma = 1, delta = 0;  ///< gluing functions γ, δ of the G1 condition (1) at this end
  /// Angle between the tangent planes of both faces at this end, degrees; 0 if the curves do not
  /// determine both tangent planes.
  double plane_angle_deg = 0;
  /// True: the G1 condition (1) is not imposed at this end, where the join ends as a crease,
  /// because plane_angle_deg is above the limit.
  bool open = false;
  /// True: the end is open although the G1 condition (1) should hold there, because refinement
  /// could not reduce the angle in the last mesh edge of an embedded curve
  /// (refine_embedded_joins()). Planning the joins again keeps this value.
  bool creased = false;
  /// True: the cross-boundary derivative of one face is free at this end, and no adjacent join
  /// determines it. The G1 condition (1) is then imposed with γ = 1, δ = 0.
  bool undetermined = false;
  /// A side of an adjacent join, and the end of its curve (0: start, 1: end).
  struct Neighbour {
    JoinSide side;
    int end;
  };
  /// For each side of the join: the neighbours whose cross-boundary derivatives y determine that of
  /// this side, as the mean of -y. Empty if y is not free on this side, or if no neighbour
  /// determines it.
  std::array<std::vector<Neighbour>, 2> set;
};
/// Correction that is added to the linear interpolation of log γ and δ between the ends of a join.
/// At the fraction f of the curve it is f (1 - f) (c[0] + c[1] (2 f - 1)).
struct GluingCorrection {
  std::array<double, 2> log_gamma{}, delta{};
  bool is_zero() const { return *this == GluingCorrection{}; }
  bool operator==(const GluingCorrection&) const = default;
  static double at(const std::array<double, 2>& c, double f) {
    return f * (1 - f) * (c[0] + c[1] * (2 * f - 1));
  }
};

/// Plan of a smooth join: how the G1 condition (1) is imposed along one curve.
struct JoinPlan {
  JoinLine join_line;
  /// Conditions at the start and the end of the curve. For an embedded curve, only JoinEnd::open
  /// and JoinEnd::plane_angle_deg are used.
  std::array<JoinEnd, 2> ends;
  GluingCorrection gluing_correction;  ///< used if both faces have the curve mesh-aligned
  /// For an embedded curve: fractions of the parameter interval, and the values of γ and δ at these
  /// fractions. Interpolation is linear.
  std::vector<double> at, gamma, delta;
  bool closed = false;  ///< true: the embedded curve is closed and has no ends
  /// How the G1 condition (1) is imposed at an end of an embedded curve.
  /// Hat:   averaged over the hat function, if the faces continue smoothly beyond the end.
  /// Point: pointwise, at a corner at which the curves determine the tangent planes of both faces.
  /// None:  not imposed: the end is open, or only one of the faces has a corner there.
  enum class EndCondition { None, Hat, Point };
  std::array<EndCondition, 2> end_conditions{};
  /// Message that explains why the faces cannot be joined smoothly along this curve; empty if they
  /// are joined.
  std::string rejection_reason;
  bool rejected() const { return !rejection_reason.empty(); }
  bool constant() const;  ///< true: mesh-aligned curves, constant γ and δ, no open end
};

/// Plans smooth joins: computes the gluing functions γ and δ of the G1 condition (1) from given
/// shapes. `regions`: the faces; faces without smooth joins may be null. `shapes`: dofs of each
/// face, which satisfy the constraints of all curves. `max_plane_angle_deg`: if the tangent planes
/// at an end of a join differ by a larger angle, the join ends as a crease there.
///
/// A join is rejected (JoinPlan::rejection_reason) if the faces have different mesh vertices on a
/// mesh-aligned curve; if the tangent planes differ by more than 90 degrees; if γ is outside of
/// (1/50, 50); or if an embedded curve is shorter than the elements there.
std::vector<JoinPlan> plan_joins(const std::vector<const RegionLayout*>& regions,
                                 const std::vector<Points>& shapes,
                                 const std::vector<JoinLine>& join_lines,
                                 double max_plane_angle_deg);

/// Maps the dof numbers of a face to those of the model: one offset for vertex dofs, another one
/// for edge dofs.
struct DofOffsets {
  int vertex_dofs = 0;  ///< 3 · number of vertices of the face
  /// Offsets that are added to the numbers of vertex dofs and of edge dofs.
  int vertices = 0, edges = 0;
  /// Number of a dof of the face in the model.
  int operator()(int dof) const { return dof + (dof < vertex_dofs ? vertices : edges); }
};

/// Adds the G1 constraints (1) of all joins that are not rejected, named "smooth curve NAME". If
/// the curves are constrained, (1) holds at the nodes automatically. `free`: true if the curves are
/// not constrained. (1) is then imposed at the nodes too, except for the last join around a node,
/// which the other joins imply.
void add_join_constraints(const std::vector<const RegionLayout*>& regions,
                          const std::vector<DofOffsets>& dof_offsets,
                          const std::vector<JoinPlan>& plans, bool free, ConstraintSet& set);

/// Computes the penalty matrix of the residual of the G1 condition (1) on embedded curves, where
/// the constraints enforce only averages over hat functions. The matrix is the lower triangle for
/// one coordinate and the bending stiffness β = 1, to be added to the bending stiffness matrix on
/// the domain of size 1:
///
///     1000 (S/s_A)² ∫ |y_A + γ y_B - δ x_t|² / (σ_A h) dt,      h = √(2 · area of the triangle).
///
/// The matrix is zero if no join is on an embedded curve. `size`: size S of the model. `dofs`:
/// number of rows of the matrix. s_A is the size of face A.
SparseMatrix join_stiffness(const std::vector<const RegionLayout*>& regions,
                            const std::vector<DofOffsets>& dof_offsets,
                            const std::vector<JoinPlan>& plans, double size, int dofs);

/// Adds constraints named "joined curve NAME" that keep adjacent faces together along a curve that
/// is not constrained itself. If both faces have the curve mesh-aligned, positions and slopes along
/// the curve agree at vertices. If a face has the curve embedded, positions agree on average over
/// each hat function.
void add_line_ties(const std::vector<const RegionLayout*>& regions,
                   const std::vector<DofOffsets>& dof_offsets, const JoinLine& line,
                   ConstraintSet& set);

/// Quality of a join between two solved faces. Angles are between the tangent planes of the faces,
/// degrees: 0 if smooth, 180 if one face folds back onto the other, NaN if a surface is singular.
struct JoinQuality {
  double max_gap = 0;  ///< largest distance between the two faces along the curve, model units
  /// Largest angle between the tangent planes, degrees.
  double max_deg = 0;
  double mean_deg = 0;              ///< mean angle along the curve, degrees
  std::array<double, 2> end_deg{};  ///< angles at the start and the end of the curve, degrees
  /// Largest angle in degrees, excluding the first or the last mesh edge if that end is open.
  double max_inside_deg = 0;
  /// Median and largest difference, between the two faces, of the normal curvature perpendicular to
  /// the curve, 1/length. Mesh edges at open ends are excluded. 0 if the curvature is continuous.
  double median_curvature_jump = 0, max_curvature_jump = 0;
  /// Integral along the curve of the angle between the normals (radians), model units. The value is
  /// positive if the edge is convex, seen from the side to which the normals point. It is
  /// meaningless if both faces lie on the same side of the curve.
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
/// `made`: the solved face. `region`: index of this face, which is stored in JoinSide::region.
std::optional<JoinSide> side_of(const SkinnedRegion& made, int region, const std::string& name);

}  // namespace batten
