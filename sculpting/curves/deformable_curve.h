// A curve that loads shape, with named parameters.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "batten/constraints/constrained_solver.h"
#include "batten/constraints/implicit_steps.h"
#include "batten/fairing/energy.h"
#include "batten/fem/curve.h"
#include "batten/fem/curve_assembly.h"

namespace batten {

/// A load on a curve; its `value` is a named parameter, for sliders and --set.
struct CurveLoad {
  /// value · direction per length of the parameter u, all along the curve.
  struct Uniform {
    Vec3 direction;
  };
  /// value · direction at the point nearest to `at`.
  struct Force {
    Vec3 at, direction;
  };
  /// A spring of stiffness value ≥ 0 from the point nearest to `at` to the place `to`.
  struct Spring {
    Vec3 at, to;
  };
  std::string name;
  double value = 0;
  std::variant<Uniform, Force, Spring> kind;
};

struct CurveMaterial {
  CurveAssembler::Along alpha = {0}, beta = {1};
  /// Relative: alpha, beta, loads, density and damping are pure numbers on the curve scaled to
  /// length 1, so that the same curve in mm and in m takes the same shape. Absolute: alpha is a
  /// force, beta force·length², a spring force/length.
  LoadUnits units = LoadUnits::Relative;
  /// The shape it is made with costs no energy; otherwise a straight line (alpha: a point) does.
  bool keeps_shape = true;
  double density = 1, damping = 1;
};

/// The deformable curve of Celniker and Gossard 1991: the minimum of
///
///     E = ∫ alpha |Y_u|² + beta |Y_uu|² du + Σ k |X(u_k) - to_k|² - 2 ∫ f·X du - 2 Σ F·X(u_i)
///
/// under constraints that hold exactly; Y = X, or X minus the shape it was made with. Solved
/// about a point of the curve, so that one far away keeps its digits. Loads that only change the
/// right-hand side cost one solve; a spring's stiffness costs a factor of a banded matrix.
class DeformableCurve {
 public:
  /// `constraints`: on the dofs of the shape's mesh (CurveConstraints). Throws InputError (counts,
  /// numbers that are not finite, two loads of one name, a negative stiffness). solve() and
  /// start_motion() throw ConflictError, and NoSolutionError when nothing holds the curve.
  DeformableCurve(HermiteCurve shape, ConstraintSet constraints, CurveMaterial material,
                  std::vector<CurveLoad> loads);

  const std::vector<CurveLoad>& loads() const { return loads_; }
  /// Throws InputError: an unknown name (the nearest is offered), a value that is not finite, a
  /// negative stiffness.
  void set(const std::string& load, double value);
  /// Where a spring pulls to. Throws InputError when there is no such spring.
  void pull_to(const std::string& spring, const Vec3& to);

  /// The static shape under the loads as they are.
  HermiteCurve solve();

  /// Motion from the shape as it is (the last one solved or reached), at rest; from the static one
  /// when that does not keep the constraints. Parameters may change between steps.
  void start_motion(double dt, double theta = 1);
  /// One implicit step; throws InputError when there was no start_motion().
  HermiteCurve step();
  /// Kinetic plus potential energy: never grows under constant loads.
  double energy();

  const ConstraintSet& constraints() const { return constraints_; }

 private:
  double scale(int power) const;
  CurveLoad& load(const std::string& name);
  SparseMatrix stiffness() const;
  Points right_side() const;
  void restart();
  HermiteCurve made(const Points& about_origin) const;

  HermiteCurve shape_;
  ConstraintSet constraints_, about_origin_;
  CurveMaterial material_;
  std::vector<CurveLoad> loads_;
  std::vector<double> at_;  // parameters of the loads
  CurveAssembler assembler_;
  Vec3 origin_;
  VecX positions_;  // 1 at position dofs
  SparseMatrix bending_;
  std::optional<ConstrainedSolver> solver_;
  std::optional<ImplicitSteps> steps_;
  double dt_ = 0, theta_ = 1;
  bool stiffness_changed_ = false;
  Points current_;
};

}  // namespace batten
