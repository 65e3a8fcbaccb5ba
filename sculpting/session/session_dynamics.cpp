// SPDX-License-Identifier: MPL-2.0
#include <algorithm>
#include <cmath>
#include <optional>

#include "batten/constraints/affine_reduction.h"
#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/sculpting/session/session_engine.h"
#include "batten/skinning/model/model_projector.h"

namespace batten::detail {

namespace {

// Value of a parameter at the fraction θ of a time step.
double blended(const Motion& m, const std::vector<double>& from, const std::vector<double>& to,
               int parameter) {
  const auto p = static_cast<size_t>(parameter);
  return m.theta * to[p] + (1 - m.theta) * from[p];
}

}  // namespace

bool SessionEngine::prepare_motion(SessionSystem& system, const Motion& motion) {
  const bool same = system.dynamics && system.motion.dt == motion.dt &&
                    system.motion.density == motion.density &&
                    system.motion.damping == motion.damping && system.motion.theta == motion.theta;
  if (same && system.dynamics_coupling && system.dynamics_constraints == system.auxiliary)
    return false;
  if (!same) {
    const double inertia = system.def.scale().inertia() *
                           (motion.density / (motion.theta * motion.dt) + motion.damping);
    SparseMatrix S =
        inertia * system.parts->mass() + (motion.theta * motion.dt) * system.statics->matrix();
    system.dynamics = std::make_shared<ReusableFactorization>(*system.statics, std::move(S));
    system.dynamics_coupling.reset();  // computed with the previous factor
    system.motion = motion;
  }
  SparseMatrix U = SparseMatrix(system.reduction->D().transpose()) * system.auxiliary->A;
  system.dynamics_coupling = std::make_shared<SchurComplementConstraints>(
      system.dynamics->factor(), std::move(U), system.auxiliary->rows, kRedundantTolerance);
  system.dynamics_constraints = system.auxiliary;
  return true;
}

// Right-hand sides of the auxiliary constraints for one step, as rates.
void SessionEngine::set_dynamic_targets(SessionSystem& system, const std::vector<double>& from,
                                        const std::vector<double>& to, const ShapeState& shape) {
  const AuxiliaryConstraints& rows = *system.auxiliary;
  if (rows.rows.empty()) return;
  const Motion& m = system.motion;
  const double ahead = (1 - m.theta) * m.dt;
  ae_.noalias() = rows.A.transpose() * e_;
  ax_.noalias() = rows.A.transpose() * shape.x;
  av_.noalias() = rows.A.transpose() * shape.v;
  long soft = 0;
  for (size_t r = 0; r < rows.rows.size(); ++r) {
    const auto& source = rows.sources[r];
    const SchurComplementConstraints::Constraint& row = rows.rows[r];
    const double at = row.evaluate(ax_), lines = row.evaluate(ae_);
    double& g = g_[static_cast<long>(r)];
    if (row.soft) {
      const Vec3 p = ax_.row(row.point).transpose() + system.origin();
      const double value = blended(m, from, to, source.parameter);
      const SpringTarget pulled =
          spring_target(system, source, value, p + ahead * av_.row(row.point).transpose());
      wanted_stiffness_[soft++] = m.theta * m.dt * pulled.stiffness;
      g = row.direction.dot(pulled.target - p) / (m.theta * m.dt) - lines;
      continue;
    }
    const double goal = source.kind == AuxiliaryConstraints::Source::Goal
                            ? to[source.parameter] - system.origin()[source.coordinate]
                            : 0;
    g = (goal - at) / m.dt - lines;
  }
  if (soft > 0) system.dynamics_coupling->set_stiffness(wanted_stiffness_);
  if (!system.dynamics_coupling->redundant().empty()) {
    const auto [missed, row] = system.dynamics_coupling->contradiction(g_);
    if (missed * m.dt > kRoundingTolerance * system.layout().size())
      throw_conflict(system, to, row);
  }
}

void SessionEngine::step(SessionSystem& system, const std::vector<double>& from,
                         const std::vector<double>& to, ShapeState& shape) {
  const Motion& m = system.motion;
  anchored_ = false;
  rhs_values_.clear();  // cleared because e_ and ae_ become rates
  const double area = system.def.scale().inertia();
  ReusableFactorization& dynamics = *system.dynamics;

  // Follower loads act on the shape at (1 - θ) dt into the step. With θ = 1 that is its beginning,
  // so that steps of any length are stable.
  const double ahead = (1 - m.theta) * m.dt;
  // Right-hand side b = F - K x + ρ/(θ dt) M v.
  multiply_symmetric(system.statics->matrix(), shape.x, product_);
  F_ = -product_;
  if (m.density > 0) {
    multiply_symmetric(system.parts->mass(), shape.v, product_);
    F_ += (area * m.density / (m.theta * m.dt)) * product_;
  }
  next_ = shape.x + ahead * shape.v;
  for (size_t l = 0; l < system.loads.size(); ++l) {
    const double v = blended(m, from, to, system.load_parameter[l]);
    if (v == 0) continue;
    const AssembledLoad& load = *system.loads[l];
    if (load.F.rows() > 0) F_ += v * load.F;
    if (std::holds_alternative<Load::Pressure>(system.def.loads[l]->load.kind))
      system.parts->pressure().add(next_, load.weights, v * load.scale, F_);
  }
  if (system.matrix_load.rows() > 0) F_ += system.matrix_load;
  if (system.rest_load.rows() > 0) F_ += system.rest_load;

  // Lines move at the rate that takes them to their positions at the end of the step.
  line_rhs(system, from, rate_);
  line_rhs(system, to, rhs_);
  system.reduction->check(rhs_);
  rate_ = (rhs_ - rate_) / m.dt;
  if (system.reduction->rhs_to_particular().nonZeros() > 0)
    e_.noalias() = system.reduction->rhs_to_particular() * rate_;
  dynamics.start_load(rate_, y_);
  dynamics.add_load(F_, y_);

  set_dynamic_targets(system, from, to, shape);
  dynamics.solve(y_);
  system.dynamics_coupling->apply(y_, g_);
  dynamics.expand(y_, e_, next_);
  shape.x += m.dt * next_;
  shape.v += (next_ - shape.v) / m.theta;
}

void SessionEngine::project(SessionSystem& system, const std::vector<double>& values,
                            ShapeState& shape) {
  anchored_ = false;
  rhs_values_.clear();
  // The right-hand sides are the residuals of the shape in the constraints.
  line_rhs(system, values, rhs_);
  system.reduction->check(rhs_);
  const auto correct = [&](Points& x, bool velocity) {
    for (size_t r = 0; r < system.line_rows->constraints().size(); ++r) {
      const auto& row = system.line_rows->constraints()[r];
      Vec3 is = Vec3::Zero();
      for (const auto& e : row.entries) is += e.coefficient * x.row(e.dof).transpose();
      const Vec3 wanted = velocity ? Vec3::Zero() : Vec3(rhs_.row(static_cast<long>(r)));
      rate_.row(static_cast<long>(r)) = wanted - is;
    }
    if (system.reduction->rhs_to_particular().nonZeros() > 0)
      e_.noalias() = system.reduction->rhs_to_particular() * rate_;
    system.statics->start_load(rate_, y_);
    const AuxiliaryConstraints& rows = *system.auxiliary;
    ae_.noalias() = rows.A.transpose() * e_;
    ax_.noalias() = rows.A.transpose() * x;
    for (size_t r = 0; r < rows.rows.size(); ++r) {
      const auto& source = rows.sources[r];
      const SchurComplementConstraints::Constraint& row = rows.rows[r];
      double goal = 0;
      if (!velocity && source.kind == AuxiliaryConstraints::Source::Goal)
        goal = values[source.parameter] - system.origin()[source.coordinate];
      g_[static_cast<long>(r)] = row.soft ? 0 : goal - row.evaluate(ax_) - row.evaluate(ae_);
    }
    if (!velocity && !system.coupling->redundant().empty()) {
      const auto [missed, row] = system.coupling->contradiction(g_);
      if (missed > kRoundingTolerance * system.layout().size()) throw_conflict(system, values, row);
    }
    system.statics->solve(y_);
    system.coupling->apply(y_, g_);
    system.statics->expand(y_, e_, next_);
    x += next_;
  };
  correct(shape.x, false);
  correct(shape.v, true);
}

double SessionEngine::residual(const SessionSystem& system, const std::vector<double>& values,
                               const Points& x) {
  line_rhs(system, values, rate_);
  double largest = 0;
  const auto note = [&](double missed) {
    if (!(missed <= largest) && !std::isnan(largest)) largest = missed;
  };
  const auto& lines = system.line_rows->constraints();
  for (size_t r = 0; r < lines.size(); ++r) {
    Vec3 is = Vec3::Zero();
    for (const auto& e : lines[r].entries) is += e.coefficient * x.row(e.dof).transpose();
    note((is - rate_.row(static_cast<long>(r)).transpose()).cwiseAbs().maxCoeff());
  }
  const AuxiliaryConstraints& rows = *system.auxiliary;
  std::vector<char> redundant(rows.rows.size(), 0);
  for (const int r : system.coupling->redundant()) redundant[r] = 1;
  for (size_t r = 0; r < rows.rows.size(); ++r) {
    if (rows.rows[r].soft) continue;
    double is = 0;
    rows.rows[r].terms([&](int point, const Vec3& n) {
      for (SparseMatrix::InnerIterator it(rows.A, point); it; ++it)
        is += it.value() * n.dot(Vec3(x.row(it.row())));
    });
    const auto& source = rows.sources[r];
    const double goal = source.kind == AuxiliaryConstraints::Source::Goal
                            ? values[source.parameter] - system.origin()[source.coordinate]
                            : 0;
    const double off = std::abs(is - goal);
    // Within rounding, the other constraints replace a redundant one.
    if (!redundant[r] || off > kRoundingTolerance * system.layout().size()) note(off);
  }
  return largest;
}

std::vector<Reaction> SessionEngine::reactions(const SessionSystem& system,
                                               const std::vector<double>& values, const Points& x) {
  multiply_symmetric(system.statics->matrix(), x, product_);
  for (size_t l = 0; l < system.loads.size(); ++l) {
    const double v = values[system.load_parameter[l]];
    if (v == 0) continue;
    if (system.loads[l]->F.rows() > 0) product_ -= v * system.loads[l]->F;
    if (std::holds_alternative<Load::Pressure>(system.def.loads[l]->load.kind))
      system.parts->pressure().add(x, system.loads[l]->weights, -v * system.loads[l]->scale,
                                   product_);
  }
  if (system.matrix_load.rows() > 0) product_ -= system.matrix_load;
  if (system.rest_load.rows() > 0) product_ -= system.rest_load;
  const AuxiliaryConstraints& rows = *system.auxiliary;
  for (size_t r = 0; r < rows.rows.size(); ++r) {
    if (!rows.rows[r].soft) continue;
    Vec3 p = system.origin();
    for (SparseMatrix::InnerIterator it(rows.A, rows.rows[r].point); it; ++it)
      p += it.value() * x.row(it.row()).transpose();
    const double value = values[rows.sources[r].parameter];
    const SpringTarget to = spring_target(system, rows.sources[r], value, p);
    const Vec3& n = rows.rows[r].direction;
    const Vec3 force = to.stiffness * n.dot(p - to.target) * n;
    for (SparseMatrix::InnerIterator it(rows.A, rows.rows[r].point); it; ++it)
      product_.row(it.row()) += it.value() * force.transpose();
  }
  std::vector<Reaction> all;
  for (const auto& named : named_reactions(all_rows(system, values), product_))
    all.push_back({named.name, named.forces.transpose() * system.parts->ones});
  return all;
}

std::vector<PointCloudDistances> SessionEngine::scan_distances(const SessionSystem& system,
                                                               const Points& before,
                                                               const Points& now) const {
  std::vector<PointCloudDistances> all;
  std::optional<ModelProjector> on_before, on_now;
  for (size_t l = 0; l < system.loads.size(); ++l) {
    const auto* scan = std::get_if<Load::PointCloudSprings>(&system.def.loads[l]->load.kind);
    if (!scan) continue;
    if (!on_now) {
      on_before.emplace(system.layout(), before);
      on_now.emplace(system.layout(), now);
    }
    PointCloudDistances s;
    s.name = system.def.loads[l]->load.name;
    s.points = isize(scan->points);
    for (size_t i = 0; i < scan->points.size(); ++i) {
      throw_if_cancelled();
      if (i >= system.scan_used[l].size() || !system.scan_used[l][i]) {
        ++s.left_out;
        continue;
      }
      const double was = on_before->nearest(scan->points[i]).distance,
                   is = on_now->nearest(scan->points[i]).distance;
      s.before_max = std::max(s.before_max, was);
      s.max = std::max(s.max, is);
      s.before_rms += was * was;
      s.rms += is * is;
    }
    const double used = std::max(1, s.points - s.left_out);
    s.before_rms = std::sqrt(s.before_rms / used);
    s.rms = std::sqrt(s.rms / used);
    all.push_back(s);
  }
  return all;
}

double SessionEngine::total_energy(const SessionSystem& system, const std::vector<double>& values,
                                   const ShapeState& shape, bool dynamics) {
  multiply_symmetric(system.statics->matrix(), shape.x, product_);
  for (size_t l = 0; l < system.loads.size(); ++l) {
    const double v = values[system.load_parameter[l]];
    if (system.loads[l]->F.rows() > 0 && v != 0) product_ -= 2 * v * system.loads[l]->F;
    // If the boundary is fixed, ⅔ Fᵀx is twice p V: the potential of the pressure, without the
    // factor ½.
    if (std::holds_alternative<Load::Pressure>(system.def.loads[l]->load.kind) && v != 0) {
      F_.setZero();
      system.parts->pressure().add(shape.x, system.loads[l]->weights, v * system.loads[l]->scale,
                                   F_);
      product_ -= (2.0 / 3) * F_;
    }
  }
  if (system.matrix_load.rows() > 0) product_ -= 2 * system.matrix_load;
  if (system.rest_load.rows() > 0) product_ -= 2 * system.rest_load;
  double energy = shape.x.cwiseProduct(product_).sum();
  if (system.rest_load.rows() > 0) energy += system.rest->dofs.cwiseProduct(system.rest_load).sum();
  const AuxiliaryConstraints& rows = *system.auxiliary;
  for (size_t r = 0; r < rows.rows.size(); ++r) {
    if (!rows.rows[r].soft) continue;
    Vec3 p = system.origin();
    for (SparseMatrix::InnerIterator it(rows.A, rows.rows[r].point); it; ++it)
      p += it.value() * shape.x.row(it.row()).transpose();
    const double value = values[rows.sources[r].parameter];
    // The potential counts once per spring, not once per constraint.
    if (rows.sources[r].coordinate <= 0)
      energy += value * spring_energy(system, rows.sources[r], p);
  }
  if (dynamics && system.motion.density > 0) {
    multiply_symmetric(system.parts->mass(), shape.v, product_);
    energy +=
        system.def.scale().inertia() * system.motion.density * shape.v.cwiseProduct(product_).sum();
  }
  return 0.5 * energy;
}

}  // namespace batten::detail
