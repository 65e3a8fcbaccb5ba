// SPDX-License-Identifier: MPL-2.0
// Deformable curves: physically based curve modelling with named loads, statics and dynamics, also
// of faired curves through given points.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "batten/constraints/constrained_solver.h"
#include "batten/elements/reference_triangle.h"
#include "batten/fairing/curves/fair_curve.h"
#include "batten/fem/curve_assembler.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// A load on a curve. Its `value` scales the load; sliders and the option --set change it under the
/// load's name.
struct CurveLoad {
  /// Distributed force value · direction along the whole curve, per unit of the curve parameter u.
  struct Uniform {
    Vec3 direction;
  };
  /// Point force value · direction at the curve point closest to `at`.
  struct Force {
    Vec3 at, direction;
  };
  /// Spring with the stiffness value ≥ 0, from the curve point closest to `at` to the fixed point
  /// `to`.
  struct Spring {
    Vec3 at, to;
  };
  std::string name;
  double value = 0;
  std::variant<Uniform, Force, Spring> kind;
};

/// Material of a deformable curve: stiffness, density and damping.
struct CurveMaterial {
  /// Stretching stiffness alpha and bending stiffness beta along the curve.
  CurveAssembler::Coefficient alpha = {0}, beta = {1};
  /// Relative: alpha, beta, loads, density and damping are dimensionless and refer to the curve
  /// scaled to length 1, so that the same curve in mm and in m takes the same shape. Absolute:
  /// alpha is a force, beta is force·length², a spring stiffness is force/length.
  LoadUnits units = LoadUnits::Relative;
  /// True: the initial shape has zero energy. False: a straight line has zero energy (a point, if
  /// alpha is above 0).
  bool starts_unstressed = true;
  double density = 1, damping = 1;  ///< mass density and damping coefficient, ≥ 0
};

/// The deformable curve of [Celniker1991]. Its shape X(u) minimises the energy
///
///     E = ∫ alpha |Y_u|² + beta |Y_uu|² du + Σ k |X(u_k) - to_k|² - 2 ∫ f·X du - 2 Σ F·X(u_i)
///
/// under constraints that hold exactly, with springs of stiffness k from X(u_k) to the points to_k,
/// distributed forces f and point forces F. Y is X minus the initial shape if `starts_unstressed`,
/// otherwise X.
///
/// Positions are taken relative to a point of the curve, so that a curve far from the origin keeps
/// its accuracy. Loads that change only the right-hand side cost one solve. A changed spring
/// stiffness costs the factorization of a banded matrix.
class DeformableCurve {
 public:
  /// `constraints`: constraints on the dofs of shape.mesh(), see CurveConstraints.
  ///
  /// Throws InputError for wrong counts, numbers that are not finite, two loads of the same name,
  /// and a negative stiffness. solve() and start_motion() throw ConflictError for contradictory
  /// constraints, and NoSolutionError if neither constraints nor springs support the curve.
  DeformableCurve(HermiteCurve shape, ConstraintSet constraints, CurveMaterial material,
                  std::vector<CurveLoad> loads);

  const std::vector<CurveLoad>& loads() const { return loads_; }
  /// Sets the value of a load. Throws InputError for an unknown name (the message suggests the
  /// closest one), a value that is not finite, and a negative stiffness.
  void set(const std::string& load, double value);
  /// Sets the fixed end point of a spring. Throws InputError if there is no spring of this name or
  /// `to` is not finite.
  void set_spring_target(const std::string& spring, const Vec3& to);

  /// Computes the equilibrium shape under the current loads.
  HermiteCurve solve();

  /// Starts a motion with velocity 0 from the current shape: the result of the last solve() or
  /// step().
  ///
  /// If the current shape violates the constraints, the motion starts from the equilibrium shape
  /// instead. Values of loads may change between steps. `dt`: time step, above 0; `theta`:
  /// parameter of the theta method (ThetaIntegrator), ½ … 1.
  void start_motion(double dt, double theta = 1);
  /// Advances the motion by one implicit time step. Throws InputError if start_motion() was not
  /// called.
  HermiteCurve step();
  /// Kinetic plus potential energy of the motion; it never grows under constant loads. Throws
  /// InputError if start_motion() was not called.
  double energy();

  const ConstraintSet& constraints() const { return constraints_; }

 private:
  double scale(int power) const;
  CurveLoad& load(const std::string& name);
  SparseMatrix stiffness() const;
  Points rhs() const;
  void restart();
  HermiteCurve made(const Points& about_origin) const;

  HermiteCurve shape_;
  ConstraintSet constraints_, about_origin_;
  CurveMaterial material_;
  std::vector<CurveLoad> loads_;
  std::vector<double> at_;  // curve parameters of the loads
  CurveAssembler assembler_;
  Vec3 origin_;
  VecX positions_;  // per dof: 1 for positions, 0 for slopes
  SparseMatrix bending_;
  std::optional<ConstrainedSolver> solver_;
  std::optional<ThetaIntegrator> steps_;
  double dt_ = 0, theta_ = 1;
  bool stiffness_changed_ = false;
  Points current_;
};

// A curve through given points, such as the vertices of a mesh, that is faired and shaped by loads.

/// Options of sculpt_curve().
struct SculptedCurveOptions {
  /// Support of the ends of an open curve.
  enum class Ends {
    Clamped,  ///< position and tangent are fixed
    Pinned,   ///< the position is fixed
    Free      ///< no constraints; springs must support the curve
  };
  bool closed = false;
  bool faired = true;  ///< false: the curve interpolates the points before the loads act
  /// Fairing options; `closed`, `fix_ends` and `reject_outliers` are ignored: ends of open curves
  /// stay, and no point is an outlier.
  FairOptions fair;
  Ends ends = Ends::Clamped;
  double alpha = 0, beta = 1;    ///< stretch and bending stiffness, LoadUnits::Relative
  std::vector<CurveLoad> loads;  ///< empty: the curve is only faired
};

/// A faired curve under its loads. Lengths are in the unit of the points.
struct SculptedCurve {
  HermiteCurve curve;
  /// One target position per input point: the closest point of the faired curve, displaced by the
  /// loads.
  std::vector<Vec3> targets;
  Deviation fairing;         ///< deviation of the points from the curve without loads
  double wavelength = 0;     ///< smoothing wavelength of the fairing, model units
  double largest_shift = 0;  ///< largest displacement of a target by the loads
  Fairness before, after;    ///< fairness of the interpolating spline, and of `curve`
};

/// Fairs the curve through some points (fair_points()) and lets loads deform it (DeformableCurve).
/// If the points are vertices of a mesh, use SculptedCurve::targets as position constraints to let
/// the curve deform the mesh (see position_constraints() in mesh/deform/deform_problem.h).
///
/// `points`: in order along the curve; for a closed curve, the first point is not repeated. `name`
/// appears in messages. Throws InputError for too few points and for invalid options or loads,
/// ConflictError for contradictory constraints, and NoSolutionError if neither ends nor springs
/// support the curve.
SculptedCurve sculpt_curve(const std::string& name, const std::vector<Vec3>& points,
                           const SculptedCurveOptions& options = {});

}  // namespace batten
