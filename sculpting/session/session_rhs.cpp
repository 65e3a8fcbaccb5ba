#include <cmath>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/sculpting/session/session_engine.h"

namespace batten::detail {

void SessionEngine::line_rhs(const SessionSystem& system, const std::vector<double>& values,
                             MatX& rhs) const {
  rhs = system.base_rhs;
  for (size_t i = 0; i < system.offset_rhs.size(); ++i)
    if (const double v = values[system.move_parameter[i]]; v != 0) rhs += v * *system.offset_rhs[i];
}

void SessionEngine::auxiliary_rhs(const SessionSystem& system, const std::vector<double>& values) {
  const AuxiliaryConstraints& rows = *system.auxiliary;
  if (rows.rows.empty()) return;
  for (size_t r = 0; r < rows.rows.size(); ++r) {
    const auto& source = rows.sources[r];
    const SchurComplementConstraints::Constraint& row = rows.rows[r];
    if (row.soft) continue;
    const double goal = source.kind == AuxiliaryConstraints::Source::Goal
                            ? values[source.parameter] - system.origin()[source.coordinate]
                            : 0;
    g_[static_cast<long>(r)] = goal - row.evaluate(ae_);
  }
  if (system.coupling->redundant().empty()) return;
  const auto [missed, row] = system.coupling->contradiction(g_);
  if (missed > kRhsConflictTolerance * system.layout().size()) throw_conflict(system, values, row);
}

ConstraintSet SessionEngine::all_rows(const SessionSystem& system,
                                      const std::vector<double>& values) const {
  ConstraintSet all(system.dofs());
  MatX rhs;
  line_rhs(system, values, rhs);
  const auto& names = system.line_rows->names();
  const auto& lines = system.line_rows->constraints();
  for (size_t r = 0; r < lines.size(); ++r)
    all.add(names[lines[r].name], lines[r].entries, rhs.row(static_cast<long>(r)));
  const AuxiliaryConstraints& auxiliary = *system.auxiliary;
  for (size_t r = 0; r < auxiliary.rows.size(); ++r) {
    if (auxiliary.rows[r].soft) continue;
    std::vector<ConstraintSet::CoupledEntry> entries;
    auxiliary.rows[r].terms([&](int point, const Vec3& n) {
      for (SparseMatrix::InnerIterator it(auxiliary.A, point); it; ++it)
        entries.push_back({static_cast<int>(it.row()), it.value() * n});
    });
    const auto& source = auxiliary.sources[r];
    const double goal = source.kind == AuxiliaryConstraints::Source::Goal
                            ? values[source.parameter] - system.origin()[source.coordinate]
                            : 0;
    all.add_coupled(auxiliary.name_of(static_cast<int>(r)), std::move(entries), goal);
  }
  return all;
}

void SessionEngine::throw_conflict(const SessionSystem& system, const std::vector<double>& values,
                                   int row) const {
  // The elimination knows which rows make up another; it is asked only now.
  const ConstraintSet all = all_rows(system, values);
  const AuxiliaryConstraints& auxiliary = *system.auxiliary;
  const AffineReduction check(all, AffineReduction::RhsMode::Given, kRedundantTolerance);
  throw ConflictError({{{auxiliary.name_of(row), "the lines or constraints beside it"},
                        system.coupling->contradiction(g_).first}});
}

void SessionEngine::prepare_rhs(SessionSystem& system, const std::vector<double>& values) {
  // The right-hand sides of lines are made anew only when lines moved.
  bool stands = rhs_values_.size() == values.size() && rhs_matrix_ == system.statics.get();
  for (size_t p = 0; stands && p < values.size(); ++p)
    stands = (system.roles[p] & kRhs) == 0 || values[p] == rhs_values_[p];
  if (!stands) {
    rhs_values_.clear();
    line_rhs(system, values, rhs_);
    system.reduction->check(rhs_);
    if (system.reduction->rhs_to_particular().nonZeros() > 0)
      e_.noalias() = system.reduction->rhs_to_particular() * rhs_;
    system.statics->start_load(rhs_, hd_);
    ae_.noalias() = system.auxiliary->A.transpose() * e_;
    rhs_values_ = values;
    rhs_matrix_ = system.statics.get();
  }
  auxiliary_rhs(system, values);
  base_ = hd_;
  add_linear(system, values, base_);
}

void SessionEngine::add_linear(const SessionSystem& system, const std::vector<double>& values,
                               MatX& to) const {
  for (size_t l = 0; l < system.loads.size(); ++l)
    if (const double v = values[system.load_parameter[l]];
        v != 0 && system.loads[l]->reduced.rows() > 0)
      to += v * system.loads[l]->reduced;
  if (system.scan_load.rows() > 0) to += system.scan_reduced;
  if (system.rest_load.rows() > 0) to += system.rest_reduced;
}

namespace {

// The point of a spring's target that is nearest to p.
Vec3 nearest_of(const Load::AttractorSprings& springs, int spring, const Vec3& p) {
  if (const auto* points = std::get_if<Load::AttractorSprings::TargetPoints>(&springs.target))
    return points->to[spring];
  if (const auto* curve = std::get_if<Load::AttractorSprings::Curve>(&springs.target))
    return curve->curve.evaluate(curve->curve.closest_point(p).u);
  const auto& plane = std::get<Load::AttractorSprings::Plane>(springs.target);
  const Vec3 n = plane.normal.normalized();
  return p - n.dot(p - plane.through) * n;
}

}  // namespace

SessionEngine::SpringTarget SessionEngine::spring_target(const SessionSystem& system,
                                                         const AuxiliaryConstraints::Source& source,
                                                         double value, const Vec3& p) const {
  const auto& placed = *system.def.loads[source.load];
  const auto& springs = std::get<Load::AttractorSprings>(placed.load.kind);
  Vec3 target = nearest_of(springs, source.spring, p);
  const double distance = (p - target).norm();
  double stiffness = value;
  if (springs.falloff > 0) stiffness *= std::exp(-std::pow(distance / springs.falloff, 2));
  if (springs.rest_length > 0 && distance > 0)
    target += springs.rest_length / distance * (p - target);
  return {stiffness, target};
}

void SessionEngine::set_spring_targets(SessionSystem& system, const std::vector<double>& values,
                                       const Points& x) {
  const AuxiliaryConstraints& rows = *system.auxiliary;
  const auto& soft = system.coupling->soft();
  if (soft.empty()) return;
  ax_.noalias() = rows.A.transpose() * x;
  for (size_t k = 0; k < soft.size(); ++k) {
    const auto r = static_cast<size_t>(soft[k]);
    const SchurComplementConstraints::Constraint& row = rows.rows[r];
    const double value = values[rows.sources[r].parameter];
    if (!(value >= 0))
      throw InputError("springs '" + rows.name_of(soft[k]) + "' have the stiffness " +
                       format_number(value) + ": it must not be below 0");
    const Vec3 p = ax_.row(row.point).transpose() + system.origin();
    const SpringTarget to = spring_target(system, rows.sources[r], value, p);
    wanted_stiffness_[static_cast<long>(k)] = to.stiffness;
    g_[static_cast<long>(r)] =
        row.direction.dot(to.target - system.origin() - Vec3(ae_.row(row.point)));
  }
  if (wanted_stiffness_ != stiffness_) {
    system.coupling->set_stiffness(wanted_stiffness_);
    stiffness_ = wanted_stiffness_;
    // Responses to loads were those of softer or stiffer springs.
    response_is_known_.assign(response_is_known_.size(), 0);
  }
}

// 2 ∫ φ(ρ) (ρ - r₀) dρ from r₀ to r: what a spring of stiffness 1 stores.
double SessionEngine::spring_energy(const SessionSystem& system,
                                    const AuxiliaryConstraints::Source& source,
                                    const Vec3& p) const {
  const auto& springs = std::get<Load::AttractorSprings>(system.def.loads[source.load]->load.kind);
  const double r = (p - nearest_of(springs, source.spring, p)).norm(), rest = springs.rest_length,
               falloff = springs.falloff;
  if (falloff == 0) return (r - rest) * (r - rest);
  const auto phi = [&](double at) { return std::exp(-(at / falloff) * (at / falloff)); };
  return falloff * falloff * (phi(rest) - phi(r)) -
         rest * falloff * std::sqrt(std::numbers::pi) *
             (std::erf(r / falloff) - std::erf(rest / falloff));
}

}  // namespace batten::detail
