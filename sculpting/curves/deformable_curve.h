// A deformable curve: named loads give it its shape.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "batten/constraints/constrained_solver.h"
#include "batten/elements/reference_triangle.h"
#include "batten/fem/curve_assembler.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// A load on a curve. Its `value` is a parameter that sliders and --set change by the load's name.
struct CurveLoad {
  /// The force value · direction acts all along the curve, per length of its parameter u.
  struct Uniform {
    Vec3 direction;
  };
  /// The force value · direction acts at the point of the curve that is nearest to `at`.
  struct Force {
    Vec3 at, direction;
  };
  /// A spring of stiffness value ≥ 0 pulls the curve's point nearest to `at` to the place `to`.
  struct Spring {
    Vec3 at, to;
  };
  std::string name;
  double value = 0;
  std::variant<Uniform, Force, Spring> kind;
};

/// What the curve resists to loads and motion.
struct CurveMaterial {
  CurveAssembler::Coefficient alpha = {0}, beta = {1};
  /// Relative: alpha, beta, loads, density and damping are pure numbers on the curve scaled to
  /// length 1, so that the same curve in mm and in m takes the same shape. Absolute: alpha is a
  /// force, beta force·length², a spring force/length.
  LoadUnits units = LoadUnits::Relative;
  /// True: the shape that the curve is made with has no energy. False: a straight line has none
  /// (a point, where alpha is above 0).
  bool starts_unstressed = true;
  double density = 1, damping = 1;  ///< ρ and μ of a motion, ≥ 0
};

/// The deformable curve of Celniker and Gossard 1991: the minimum of
///
///     E = ∫ alpha |Y_u|² + beta |Y_uu|² du + Σ k |X(u_k) - to_k|² - 2 ∫ f·X du - 2 Σ F·X(u_i)
///
/// under constraints that hold exactly; Y = X, or X minus the shape it was made with
/// (starts_unstressed). Positions are taken relative to a point of the curve, so that a curve far from
/// the origin loses no digits. Loads that only change the right-hand side cost one solve; another
/// stiffness of a spring costs a factor of a banded matrix.
class DeformableCurve {
 public:
  /// `constraints` are on the dofs of the shape's mesh (CurveConstraints). Throws InputError
  /// (counts, numbers that are not finite, two loads of one name, a negative stiffness). solve()
  /// and start_motion() throw ConflictError, and NoSolutionError when nothing holds the curve.
  DeformableCurve(HermiteCurve shape, ConstraintSet constraints, CurveMaterial material,
                  std::vector<CurveLoad> loads);

  const std::vector<CurveLoad>& loads() const { return loads_; }
  /// Sets the value of a load. Throws InputError: an unknown name (the nearest is offered), a value
  /// that is not finite, a negative stiffness.
  void set(const std::string& load, double value);
  /// Sets the place that a spring pulls to. Throws InputError: no such spring, a place that is not
  /// finite.
  void set_spring_target(const std::string& spring, const Vec3& to);

  /// Returns the shape at rest under the present loads.
  HermiteCurve solve();

  /// Starts a motion, with velocity 0, from the present shape (the last one solved or reached), or
  /// from the shape at rest when the present one does not keep the constraints. Values of loads may
  /// change between steps.
  void start_motion(double dt, double theta = 1);
  /// Makes one implicit step. Throws InputError when there was no start_motion().
  HermiteCurve step();
  /// Returns kinetic plus potential energy, which never grows under constant loads. Throws
  /// InputError when there was no start_motion().
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
  std::vector<double> at_;  // parameters of the loads
  CurveAssembler assembler_;
  Vec3 origin_;
  VecX positions_;  // 1 at position dofs
  SparseMatrix bending_;
  std::optional<ConstrainedSolver> solver_;
  std::optional<ThetaIntegrator> steps_;
  double dt_ = 0, theta_ = 1;
  bool stiffness_changed_ = false;
  Points current_;
};

}  // namespace batten
