// SPDX-License-Identifier: MPL-2.0
#include "batten/sculpting/curves/deformable_curve.h"

#include <algorithm>
#include <cmath>

#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

bool finite(const CurveLoad& load) {
  const auto all = [](const auto&... v) { return (v.allFinite() && ...); };
  return std::isfinite(load.value) &&
         std::visit(
             [&](const auto& kind) {
               using Kind = std::decay_t<decltype(kind)>;
               if constexpr (std::is_same_v<Kind, CurveLoad::Uniform>)
                 return all(kind.direction);
               else if constexpr (std::is_same_v<Kind, CurveLoad::Force>)
                 return all(kind.at, kind.direction);
               else
                 return all(kind.at, kind.to);
             },
             load.kind);
}

void check_value(const CurveLoad& load) {
  if (!finite(load)) throw InputError("load '" + load.name + "' of a curve: a value is not finite");
  if (std::holds_alternative<CurveLoad::Spring>(load.kind) && load.value < 0)
    throw InputError("spring '" + load.name + "': found the stiffness " +
                     format_number(load.value) + ", expected 0 or more");
}

// Adds the lower triangle of weight H Hᵀ at one parameter.
void add_spring(const CurveMesh& mesh, double u, double weight, SparseMatrix& K) {
  const auto at = mesh.locate(u);
  const auto H = HermiteSegment(mesh.length(at.segment)).evaluate(at.s);
  const auto dof = mesh.segment_dofs(at.segment);
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b)
      if (dof[a] >= dof[b]) K.coeffRef(dof[a], dof[b]) += weight * H[a] * H[b];
}

}  // namespace

DeformableCurve::DeformableCurve(HermiteCurve shape, ConstraintSet constraints,
                                 CurveMaterial material, std::vector<CurveLoad> loads)
    : shape_(std::move(shape)),
      constraints_(std::move(constraints)),
      about_origin_(constraints_),
      material_(std::move(material)),
      loads_(std::move(loads)),
      assembler_(shape_.mesh()) {
  const CurveMesh& mesh = shape_.mesh();
  if (constraints_.dof_count() != mesh.dof_count())
    throw InputError("found a constraint set of " + std::to_string(constraints_.dof_count()) +
                     " dofs, expected " + std::to_string(mesh.dof_count()) + " of the curve");
  for (size_t i = 0; i < loads_.size(); ++i) {
    check_value(loads_[i]);
    for (size_t j = 0; j < i; ++j)
      if (loads_[j].name == loads_[i].name)
        throw InputError("two loads of a curve are named '" + loads_[i].name + "'");
    double u = 0;
    if (const auto* force = std::get_if<CurveLoad::Force>(&loads_[i].kind))
      u = shape_.closest_point(force->at).u;
    if (const auto* spring = std::get_if<CurveLoad::Spring>(&loads_[i].kind))
      u = shape_.closest_point(spring->at).u;
    at_.push_back(u);
  }
  positions_ = VecX::Zero(mesh.dof_count());
  for (int n = 0; n < mesh.node_count(); ++n) positions_[mesh.position_dof(n)] = 1;
  origin_ = shape_.position(0);
  about_origin_ = constraints_.translated(positions_, origin_);

  CurveAssembler::Coefficient alpha = material_.alpha, beta = material_.beta;
  for (auto& a : alpha) a = {a.start * scale(1), a.end * scale(1)};
  for (auto& b : beta) b = {b.start * scale(3), b.end * scale(3)};
  bending_ = assembler_.stiffness(alpha, beta);
  current_ = shape_.dofs() - positions_ * origin_.transpose();
}

// Factor that converts relative values to those of the actual curve: a power of its length.
double DeformableCurve::scale(int power) const {
  if (material_.units == LoadUnits::Absolute) return 1;
  return std::pow(shape_.end() - shape_.start(), power);
}

CurveLoad& DeformableCurve::load(const std::string& name) {
  std::vector<std::string> names;
  for (CurveLoad& l : loads_) {
    if (l.name == name) return l;
    names.push_back(l.name);
  }
  throw InputError("the curve has no load '" + name + "'" + did_you_mean(name, names));
}

void DeformableCurve::set(const std::string& name, double value) {
  CurveLoad changed = load(name);
  changed.value = value;
  check_value(changed);
  load(name) = changed;
  if (std::holds_alternative<CurveLoad::Spring>(changed.kind)) {
    solver_.reset();
    stiffness_changed_ = true;
  }
}

void DeformableCurve::set_spring_target(const std::string& name, const Vec3& to) {
  CurveLoad& found = load(name);
  auto* spring = std::get_if<CurveLoad::Spring>(&found.kind);
  if (!spring) throw InputError("load '" + name + "' is not a spring");
  if (!to.allFinite()) throw InputError("spring '" + name + "': the target point is not finite");
  spring->to = to;
}

SparseMatrix DeformableCurve::stiffness() const {
  SparseMatrix K = bending_;
  for (size_t i = 0; i < loads_.size(); ++i)
    if (std::holds_alternative<CurveLoad::Spring>(loads_[i].kind))
      add_spring(shape_.mesh(), at_[i], loads_[i].value, K);
  return K;
}

Points DeformableCurve::rhs() const {
  const CurveMesh& mesh = shape_.mesh();
  Points F = Points::Zero(mesh.dof_count(), 3);
  if (material_.starts_unstressed)
    F = bending_.selfadjointView<Eigen::Lower>() *
        Points(shape_.dofs() - positions_ * origin_.transpose());
  for (size_t i = 0; i < loads_.size(); ++i) {
    const double value = loads_[i].value;
    if (const auto* uniform = std::get_if<CurveLoad::Uniform>(&loads_[i].kind))
      F += assembler_.load(
          (value * uniform->direction.transpose()).replicate(mesh.segment_count() + 1, 1));
    else if (const auto* force = std::get_if<CurveLoad::Force>(&loads_[i].kind))
      F += assembler_.point_load(at_[i], scale(1) * value * force->direction);
    else
      F += assembler_.point_load(
          at_[i], value * (std::get<CurveLoad::Spring>(loads_[i].kind).to - origin_));
  }
  return F;
}

HermiteCurve DeformableCurve::made(const Points& about_origin) const {
  return {shape_.mesh(), about_origin + positions_ * origin_.transpose()};
}

HermiteCurve DeformableCurve::solve() {
  if (!solver_) solver_.emplace(about_origin_, stiffness());
  current_ = solver_->solve(rhs());
  return made(current_);
}

void DeformableCurve::restart() {
  SparseMatrix M = assembler_.mass();
  M *= scale(-1);
  ThetaIntegrator steps(about_origin_, stiffness(), std::move(M),
                        {material_.density, material_.damping, dt_, theta_});
  if (steps_)
    steps.start(steps_->positions(), steps_->velocities());
  else
    steps.start(current_, Points::Zero(current_.rows(), 3));
  steps_ = std::move(steps);
  stiffness_changed_ = false;
}

void DeformableCurve::start_motion(double dt, double theta) {
  dt_ = dt;
  theta_ = theta;
  steps_.reset();
  constexpr double held = 1e-9;
  if (about_origin_.max_residual(current_) > held * (shape_.end() - shape_.start())) solve();
  restart();
}

HermiteCurve DeformableCurve::step() {
  if (!steps_) throw InputError("step() of a curve without a simulation: start the motion first");
  if (stiffness_changed_) restart();
  current_ = steps_->step(rhs());
  return made(current_);
}

double DeformableCurve::energy() {
  if (!steps_) throw InputError("energy() of a curve without a simulation: start the motion first");
  if (stiffness_changed_) restart();
  return steps_->kinetic() + steps_->potential(rhs());
}

// Curves through given points.

namespace {

ConstraintSet end_constraints(const HermiteCurve& curve, SculptedCurveOptions::Ends ends) {
  using Ends = SculptedCurveOptions::Ends;
  ConstraintSet set(curve.mesh().dof_count());
  if (curve.closed() || ends == Ends::Free) return set;
  CurveConstraints rows(curve.mesh(), set);
  for (const double u : {curve.start(), curve.end()}) {
    rows.point("ends", u, curve.evaluate(u));
    if (ends == Ends::Clamped) rows.derivative("ends", u, curve.evaluate(u, 1));
  }
  return set;
}

}  // namespace

SculptedCurve sculpt_curve(const std::string& name, const std::vector<Vec3>& points,
                           const SculptedCurveOptions& options) {
  FairOptions fair_options = options.fair;
  fair_options.reject_outliers = false;
  fair_options.closed = options.closed;
  fair_options.fix_ends = !options.closed;
  const HermiteCurve given = interpolating_spline(name, points, fair_options);
  if (!options.faired) {
    fair_options.smoothing = FairOptions::Smoothing::Wavelength;
    fair_options.wavelength = 1e-6 * given.length();  // interpolates the points
  }
  const FairCurve fair = fair_points(name, points, fair_options);
  SculptedCurve result;
  result.fairing = fair.deviation;
  result.wavelength = fair.wavelength;
  result.before = fairness(given);
  result.curve = fair.curve;
  if (!options.loads.empty()) {
    CurveMaterial material;
    material.alpha = {options.alpha};
    material.beta = {options.beta};
    DeformableCurve deformable(fair.curve, end_constraints(fair.curve, options.ends), material,
                               options.loads);
    result.curve = deformable.solve();
  }
  for (const double u : fair.parameters) {
    result.targets.push_back(result.curve.evaluate(u));
    result.largest_shift =
        std::max(result.largest_shift, (result.targets.back() - fair.curve.evaluate(u)).norm());
  }
  result.after = fairness(result.curve);
  return result;
}

}  // namespace batten
