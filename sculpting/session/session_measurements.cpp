#include <algorithm>
#include <cmath>
#include <optional>

#include "batten/constraints/affine_reduction.h"
#include "batten/core/isize.h"
#include "batten/sculpting/session/session_engine.h"
#include "batten/skinning/model/model_projector.h"

namespace batten::detail {

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
    note(std::abs(is - goal));
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
  if (system.scan_load.rows() > 0) product_ -= system.scan_load;
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

std::vector<ScanDistances> SessionEngine::scan_distances(const SessionSystem& system,
                                                         const Points& before,
                                                         const Points& now) const {
  std::vector<ScanDistances> all;
  std::optional<ModelProjector> on_before, on_now;
  for (size_t l = 0; l < system.loads.size(); ++l) {
    const auto* scan = std::get_if<Load::PointCloudSprings>(&system.def.loads[l]->load.kind);
    if (!scan) continue;
    if (!on_now) {
      on_before.emplace(system.layout(), before);
      on_now.emplace(system.layout(), now);
    }
    ScanDistances s;
    s.name = system.def.loads[l]->load.name;
    s.points = isize(scan->points);
    for (size_t i = 0; i < scan->points.size(); ++i) {
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
    // Where the rim is held, ⅔ Fᵀx is twice p V: the potential of the pressure, without a half.
    if (std::holds_alternative<Load::Pressure>(system.def.loads[l]->load.kind) && v != 0) {
      F_.setZero();
      system.parts->pressure().add(shape.x, system.loads[l]->weights, v * system.loads[l]->scale,
                                   F_);
      product_ -= (2.0 / 3) * F_;
    }
  }
  if (system.scan_load.rows() > 0) product_ -= 2 * system.scan_load;
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
    // One potential a spring, not a row.
    if (rows.sources[r].coordinate <= 0)
      energy += value * spring_energy(system, rows.sources[r], p);
  }
  if (dynamics && system.motion.density > 0) {
    multiply_symmetric(system.parts->mass(), shape.v, product_);
    energy +=
        system.def.scale().inertia() * system.motion.density * shape.v.cwiseProduct(product_).sum();
  }
  return energy;
}

}  // namespace batten::detail
