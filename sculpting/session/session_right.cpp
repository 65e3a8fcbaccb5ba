#include <cmath>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/sculpting/session/session_engine.h"

namespace batten::live {

void Engine::lines_right(const System& system, const std::vector<double>& values,
                         MatX& right) const {
  right = system.base_right;
  for (size_t i = 0; i < system.move_right.size(); ++i)
    if (const double v = values[system.move_parameter[i]]; v != 0)
      right += v * *system.move_right[i];
}

void Engine::loose_right(const System& system, const std::vector<double>& values) {
  const LooseRows& rows = *system.loose;
  if (rows.rows.empty()) return;
  for (size_t r = 0; r < rows.rows.size(); ++r) {
    const auto& source = rows.sources[r];
    const Coupling::Row& row = rows.rows[r];
    if (row.soft) continue;
    const double goal = source.kind == LooseRows::Source::Goal
                            ? values[source.parameter] - system.origin()[source.coordinate]
                            : 0;
    g_[static_cast<long>(r)] = goal - row.of(ae_);
  }
  if (system.coupling->implied().empty()) return;
  const auto [missed, row] = system.coupling->contradiction(g_);
  if (missed > kAgree * system.layout().size()) throw_conflict(system, values, row);
}

ConstraintSet Engine::all_rows(const System& system, const std::vector<double>& values) const {
  ConstraintSet all(system.dofs());
  MatX right;
  lines_right(system, values, right);
  const auto& names = system.line_rows->names();
  const auto& lines = system.line_rows->rows();
  for (size_t r = 0; r < lines.size(); ++r)
    all.add(names[lines[r].name], lines[r].entries, right.row(static_cast<long>(r)));
  const LooseRows& loose = *system.loose;
  for (size_t r = 0; r < loose.rows.size(); ++r) {
    if (loose.rows[r].soft) continue;
    std::vector<ConstraintSet::CoupledEntry> entries;
    loose.rows[r].terms([&](int point, const Vec3& n) {
      for (SparseMatrix::InnerIterator it(loose.A, point); it; ++it)
        entries.push_back({static_cast<int>(it.row()), it.value() * n});
    });
    const auto& source = loose.sources[r];
    const double goal = source.kind == LooseRows::Source::Goal
                            ? values[source.parameter] - system.origin()[source.coordinate]
                            : 0;
    all.add_coupled(loose.name_of(static_cast<int>(r)), std::move(entries), goal);
  }
  return all;
}

void Engine::throw_conflict(const System& system, const std::vector<double>& values,
                            int row) const {
  // The elimination knows which rows make up another; it is asked only now.
  const ConstraintSet all = all_rows(system, values);
  const LooseRows& loose = *system.loose;
  const AffineReduction check(all, AffineReduction::Values::Given, kDependent);
  throw ConflictError({{{loose.name_of(row), "the lines or constraints beside it"},
                        system.coupling->contradiction(g_).first}});
}

void Engine::prepare_right(System& system, const std::vector<double>& values) {
  // The right-hand sides of lines are made anew only when lines moved.
  bool stands = right_values_.size() == values.size() && right_matrix_ == system.statics.get();
  for (size_t p = 0; stands && p < values.size(); ++p)
    stands = (system.roles[p] & kRight) == 0 || values[p] == right_values_[p];
  if (!stands) {
    right_values_.clear();
    lines_right(system, values, right_);
    system.reduction->check(right_);
    if (system.reduction->from_right().nonZeros() > 0)
      e_.noalias() = system.reduction->from_right() * right_;
    system.statics->start_load(right_, hd_);
    ae_.noalias() = system.loose->A.transpose() * e_;
    right_values_ = values;
    right_matrix_ = system.statics.get();
  }
  loose_right(system, values);
  base_ = hd_;
  add_linear(system, values, base_);
}

void Engine::add_linear(const System& system, const std::vector<double>& values, MatX& to) const {
  for (size_t l = 0; l < system.loads.size(); ++l)
    if (const double v = values[system.load_parameter[l]];
        v != 0 && system.loads[l]->reduced.rows() > 0)
      to += v * system.loads[l]->reduced;
  if (system.scan_load.rows() > 0) to += system.scan_reduced;
  if (system.rest_load.rows() > 0) to += system.rest_reduced;
}

namespace {

// The point of a spring's target that is nearest to p.
Vec3 nearest_of(const Load::Pulls& springs, int spring, const Vec3& p) {
  if (const auto* places = std::get_if<Load::Pulls::Places>(&springs.target))
    return places->to[spring];
  if (const auto* curve = std::get_if<Load::Pulls::Curve>(&springs.target))
    return curve->curve.evaluate(curve->curve.closest_point(p).u);
  const auto& plane = std::get<Load::Pulls::Plane>(springs.target);
  const Vec3 n = plane.normal.normalized();
  return p - n.dot(p - plane.through) * n;
}

}  // namespace

Engine::Pull Engine::pull(const System& system, const LooseRows::Source& source, double value,
                          const Vec3& p) const {
  const auto& placed = *system.def.loads[source.load];
  const auto& springs = std::get<Load::Pulls>(placed.load.kind);
  Vec3 target = nearest_of(springs, source.spring, p);
  const double distance = (p - target).norm();
  double stiffness = value;
  if (springs.falloff > 0) stiffness *= std::exp(-std::pow(distance / springs.falloff, 2));
  if (springs.rest_length > 0 && distance > 0)
    target += springs.rest_length / distance * (p - target);
  return {stiffness, target};
}

void Engine::aim_springs(System& system, const std::vector<double>& values, const Points& x) {
  const LooseRows& rows = *system.loose;
  const auto& soft = system.coupling->soft();
  if (soft.empty()) return;
  ax_.noalias() = rows.A.transpose() * x;
  for (size_t k = 0; k < soft.size(); ++k) {
    const auto r = static_cast<size_t>(soft[k]);
    const Coupling::Row& row = rows.rows[r];
    const double value = values[rows.sources[r].parameter];
    if (!(value >= 0))
      throw InputError("springs '" + rows.name_of(soft[k]) + "' have the stiffness " +
                       number(value) + ": it must not be below 0");
    const Vec3 p = ax_.row(row.point).transpose() + system.origin();
    const Pull to = pull(system, rows.sources[r], value, p);
    wanted_[static_cast<long>(k)] = to.stiffness;
    g_[static_cast<long>(r)] =
        row.direction.dot(to.target - system.origin() - Vec3(ae_.row(row.point)));
  }
  if (wanted_ != stiffness_) {
    system.coupling->set_stiffness(wanted_);
    stiffness_ = wanted_;
    // Responses to loads were those of softer or stiffer springs.
    known_response_.assign(known_response_.size(), 0);
  }
}

// 2 ∫ φ(ρ) (ρ - r₀) dρ from r₀ to r: what a spring of stiffness 1 stores.
double Engine::stretch_energy(const System& system, const LooseRows::Source& source,
                              const Vec3& p) const {
  const auto& springs = std::get<Load::Pulls>(system.def.loads[source.load]->load.kind);
  const double r = (p - nearest_of(springs, source.spring, p)).norm(), rest = springs.rest_length,
               falloff = springs.falloff;
  if (falloff == 0) return (r - rest) * (r - rest);
  const auto phi = [&](double at) { return std::exp(-(at / falloff) * (at / falloff)); };
  return falloff * falloff * (phi(rest) - phi(r)) -
         rest * falloff * std::sqrt(std::numbers::pi) *
             (std::erf(r / falloff) - std::erf(rest / falloff));
}

}  // namespace batten::live
