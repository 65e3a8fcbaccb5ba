// SPDX-License-Identifier: MPL-2.0
#include "batten/sculpting/session/session_engine.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "batten/core/cancellation.h"
#include "batten/core/errors.h"
#include "batten/skinning/model/model_projector.h"

namespace batten::detail {

void multiply_symmetric(const SparseMatrix& S, const Points& x, Points& out) {
  out.setZero();
  const int* starts = S.outerIndexPtr();
  const int* rows = S.innerIndexPtr();
  const double* values = S.valuePtr();
  for (int c = 0; c < 3; ++c) {
    const double* in = x.col(c).data();
    double* to = out.col(c).data();
    for (int j = 0; j < S.cols(); ++j) {
      poll_every<32768>(j);
      double sum = 0;
      for (int k = starts[j]; k < starts[j + 1]; ++k) {
        const int i = rows[k];
        sum += values[k] * in[i];
        if (i != j) to[i] += values[k] * in[j];
      }
      to[j] += sum;
    }
  }
}

void SessionEngine::bind(const SessionSystem& system) {
  const int n = system.dofs(), m = system.reduction->free_count();
  const auto points = system.auxiliary->A.cols();
  const auto rows = static_cast<long>(system.auxiliary->rows.size());
  rhs_.setZero(system.base_rhs.rows(), 3);
  rate_.setZero(system.base_rhs.rows(), 3);
  hd_.setZero(m, 3);
  base_.setZero(m, 3);
  y_.setZero(m, 3);
  for (Points* p : {&e_, &next_, &F_, &product_}) {
    throw_if_cancelled();
    p->setZero(n, 3);
  }
  start_.resize(n, 3);
  ae_.setZero(points, 3);
  ax_.setZero(points, 3);
  av_.setZero(points, 3);
  g_.setZero(rows);
  long soft = 0;
  for (const auto& row : system.auxiliary->rows) soft += row.soft;
  stiffness_.setConstant(soft, -1);
  wanted_stiffness_.setZero(soft);
  std::vector<int> sample;
  for (int v = 0; v < system.parts->mesh->vertex_count(); ++v)
    sample.push_back(system.parts->assembler.dofs().vertex(v));
  throw_if_cancelled();
  accelerator_.resize(n, std::move(sample));
  throw_if_cancelled();
  contraction_ratio_ = 0;
  dof_weights_ = system.parts->displacement_weights;
  responses_.clear();
  responses_.resize(system.loads.size());
  response_is_known_.assign(system.loads.size(), 0);
  anchored_ = false;
  rhs_values_.clear();
}

void SessionEngine::reset_acceleration() {
  accelerator_.clear();
  contraction_ratio_ = 0;
  stiffness_.setConstant(-1);
  response_is_known_.assign(response_is_known_.size(), 0);
  anchored_ = false;
}

namespace {

std::vector<SurfaceStiffness> materials(const SessionSystem& system,
                                        const std::vector<double>& values) {
  const auto at = [&](int p) { return values[p]; };
  SurfaceStiffness base;
  base.alpha = Mat2::Zero();
  base.alpha(0, 0) = at(system.alpha[0]);
  base.alpha(1, 1) = at(system.alpha[2]);
  if (system.alpha[0] != system.alpha[1]) base.alpha(0, 1) = base.alpha(1, 0) = at(system.alpha[1]);
  base.beta = Vec3(at(system.beta[0]), at(system.beta[1]), at(system.beta[2]));
  const auto triangles = static_cast<size_t>(system.parts->mesh->triangle_count());
  std::vector<SurfaceStiffness> all(system.weights.empty() ? 1 : triangles, base);
  for (size_t w = 0; w < system.weights.size(); ++w) {
    const double value = at(system.weight_parameter[w]);
    if (value == 0) continue;
    const AssembledStiffnessField& assembled = *system.weights[w];
    const bool bends = system.def.weights[w]->weight.kind == StiffnessField::Kind::Bending;
    for (size_t t = 0; t < triangles; ++t) {
      poll_every<16384>(static_cast<long>(t));
      // Regions without the line have no direction.
      if (!assembled.directions.empty() && assembled.directions[t].isZero(0)) continue;
      const double weight = value * assembled.weights[static_cast<long>(t)];
      const double alpha = bends ? 0 : weight, beta = bends ? weight : 0;
      all[t] += assembled.directions.empty()
                    ? SurfaceStiffness::isotropic(alpha, beta)
                    : SurfaceStiffness::directional(assembled.directions[t], alpha, beta);
    }
  }
  for (SurfaceStiffness& m : all) {
    if (!m.is_valid())
      throw InputError("alpha must be positive semi-definite and beta 0 or more, at every point");
    m = system.def.scale().material(m);
  }
  return system.layout().scale_to_regions(std::move(all));
}

}  // namespace

// Point-cloud springs act on the matrix: they add Σ k N Nᵀ to it and Σ k N p to the right-hand
// side.
void SessionEngine::add_point_clouds(SessionSystem& system, const std::vector<double>& values,
                                     SparseMatrix& K) {
  const MeshData& parts = *system.parts;
  for (size_t l = 0; l < system.loads.size(); ++l) {
    const auto* scan = std::get_if<Load::PointCloudSprings>(&system.def.loads[l]->load.kind);
    if (!scan || system.scan_foot_points[l].empty()) continue;
    if (system.matrix_load.rows() == 0)
      system.matrix_load = Points::Zero(system.dofs(), 3);
    const double value = values[system.load_parameter[l]];
    if (!(value >= 0))
      throw InputError("load '" + system.def.loads[l]->load.name +
                       "': found the spring stiffness " + format_number(value) +
                       ", expected 0 or more");
    const double k = value / static_cast<double>(scan->points.size());
    for (size_t i = 0; i < scan->points.size(); ++i) {
      poll_every<256>(static_cast<long>(i));
      if (!system.scan_used[l][i]) continue;
      const Location where = parts.at(system.scan_foot_points[l][i]);
      const Vec12 N =
          C1Triangle(parts.kind, parts.mesh->shape(where.triangle)).evaluate(where.L).col(kW);
      const auto dof = parts.assembler.dofs().triangle(*parts.mesh, where.triangle);
      for (int a = 0; a < 12; ++a) {
        system.matrix_load.row(dof[a]) +=
            k * N[a] * (scan->points[i] - system.origin()).transpose();
        for (int b = 0; b < 12; ++b)
          if (dof[a] >= dof[b]) K.coeffRef(dof[a], dof[b]) += k * N[a] * N[b];
      }
    }
  }
}

// Stiffness of the surface alone, without point clouds and joins.
SparseMatrix SessionEngine::elastic_stiffness(const SessionSystem& system,
                                              const std::vector<double>& values) {
  const SurfaceAssembler& assembler = system.parts->assembler;
  const auto all = materials(system, values);
  SparseMatrix K = assembler.pattern();
  if (all.size() == 1)
    assembler.stiffness(all[0], K);
  else
    assembler.stiffness(all, K);
  return K;
}

// Penalty on angles along embedded lines, for these values.
JoinPenalty SessionEngine::join_penalty(const SessionSystem& system,
                                        const std::vector<double>& values) {
  JoinPenalty penalty = system.layout().join_penalty();
  const double beta = (values[system.beta[0]] + values[system.beta[2]]) / 2,
               scaled =
                   system.def.scale().material(SurfaceStiffness::isotropic(0, beta)).beta[0];
  penalty.stiffness *= scaled;
  penalty.load *= scaled;
  return penalty;
}

// Load K x_rest, which keeps the surface in its rest shape. `K` excludes point clouds and joins.
void SessionEngine::set_rest_load(SessionSystem& system, const SparseMatrix& K) {
  const bool has_rest_shape = system.rest && system.rest->dofs.rows() > 0;
  system.rest_load.resize(has_rest_shape ? system.dofs() : 0, 3);
  system.rest_reduced.resize(0, 3);
  if (!has_rest_shape) return;
  multiply_symmetric(K, system.rest->dofs, system.rest_load);
  system.rest_reduced = system.reduction->D().transpose() * system.rest_load;
}

void SessionEngine::set_rest_shape(SessionSystem& system,
                                   std::shared_ptr<const RestConfiguration> rest) {
  system.rest = std::move(rest);
  anchored_ = false;
  if (system.statics && !system.matrix_values.empty() && system.matrix_load.rows() == 0)
    set_rest_load(system, elastic_stiffness(system, system.matrix_values));
  else
    invalidate_matrix(system);
}

namespace {

// The loads of a system that belong to its matrix. Restores them unless the matrix was replaced.
class MatrixLoads {
 public:
  explicit MatrixLoads(SessionSystem& system) : system_(system) { exchange(); }
  MatrixLoads(const MatrixLoads&) = delete;
  ~MatrixLoads() {
    if (!replaced_) exchange();
  }
  void replace() { replaced_ = true; }

 private:
  void exchange() {
    system_.rest_load.swap(rest_load_);
    system_.rest_reduced.swap(rest_reduced_);
    system_.matrix_load.swap(matrix_load_);
    system_.matrix_load_reduced.swap(matrix_load_reduced_);
  }
  SessionSystem& system_;
  Points rest_load_ = Points(0, 3), matrix_load_ = Points(0, 3);
  MatX rest_reduced_, matrix_load_reduced_;
  bool replaced_ = false;
};

}  // namespace

// Assembles and factors the matrix for these values.
void SessionEngine::make_matrix(SessionSystem& system, const std::vector<double>& values) {
  MatrixLoads loads(system);
  SparseMatrix K = elastic_stiffness(system, values);
  set_rest_load(system, K);
  system.matrix_load.resize(0, 3);
  if (const JoinPenalty joins = join_penalty(system, values); joins.stiffness.nonZeros() > 0) {
    K += joins.stiffness;
    if (!joins.load.isZero(0)) system.matrix_load = joins.load;
  }
  throw_if_cancelled();
  add_point_clouds(system, values, K);
  if (system.matrix_load.rows() > 0)
    system.matrix_load_reduced = system.reduction->D().transpose() * system.matrix_load;
  throw_if_cancelled();
  // A factor shared with the history must not change; one that is not shared is refactored in
  // place.
  if (system.statics && system.statics.use_count() == 1)
    system.statics->set_matrix(std::move(K));
  else
    system.statics =
        system.statics
            ? std::make_shared<ReusableFactorization>(*system.statics, std::move(K))
            : std::make_shared<ReusableFactorization>(
                  system.reduction, std::move(K), system.parts->vertices, system.def.factor_reuse);
  loads.replace();
  system.matrix_values = values;
  system.coupling.reset();  // computed with the previous factor
  system.dynamics.reset();
  system.dynamics_coupling.reset();
}

// True if the couplings of both would be equal on the same mesh and reduction. The sources of their
// right-hand sides may differ.
bool same_rows(const AuxiliaryConstraints& a, const AuxiliaryConstraints& b) {
  const auto same_matrix = [](const SparseMatrix& x, const SparseMatrix& y) {
    const auto equal = [](const auto* p, const auto* q, long n) { return std::equal(p, p + n, q); };
    return x.rows() == y.rows() && x.cols() == y.cols() && x.nonZeros() == y.nonZeros() &&
           x.isCompressed() && y.isCompressed() &&
           equal(x.outerIndexPtr(), y.outerIndexPtr(), x.cols() + 1) &&
           equal(x.innerIndexPtr(), y.innerIndexPtr(), x.nonZeros()) &&
           equal(x.valuePtr(), y.valuePtr(), x.nonZeros());
  };
  return &a == &b || (a.rows == b.rows && same_matrix(a.A, b.A));
}

// Computes the Schur complement of the auxiliary constraints. `older`, on the same factor: its
// solves are reused.
void SessionEngine::couple(SessionSystem& system, const SchurComplementConstraints* older) {
  const AuxiliaryConstraints& rows = *system.auxiliary;
  std::vector<int> known(static_cast<size_t>(rows.A.cols()), -1);
  if (older)
    for (const auto& block : rows.blocks)
      for (const auto& other : system.coupled_rows->blocks)
        if (other.owner == block.owner &&
            other.end_point - other.first_point == block.end_point - block.first_point)
          for (int k = block.first_point; k < block.end_point; ++k)
            known[k] = other.first_point + k - block.first_point;
  SparseMatrix U(system.reduction->free_count(), rows.A.cols());
  if (rows.A.cols() > 0) U = SparseMatrix(system.reduction->D().transpose()) * rows.A;
  throw_if_cancelled();
  system.coupling =
      older ? std::make_shared<SchurComplementConstraints>(system.statics->factor(), std::move(U),
                                                           rows.rows, *older, known,
                                                           kRedundantTolerance)
            : std::make_shared<SchurComplementConstraints>(system.statics->factor(), std::move(U),
                                                           rows.rows, kRedundantTolerance);
  system.coupled_rows = system.auxiliary;
  system.dynamics_coupling.reset();
  stiffness_.setConstant(-1);
}

bool SessionEngine::prepare_matrix(SessionSystem& system, const std::vector<double>& values) {
  bool fits = system.statics && system.statics->is_factored() &&
              system.matrix_values.size() == values.size();
  for (size_t p = 0; fits && p < values.size(); ++p)
    if (system.roles[p] & kMatrix) fits = values[p] == system.matrix_values[p];
  if (fits && system.coupling && system.coupled_rows == system.auxiliary) return false;
  anchored_ = false;
  rhs_values_.clear();
  response_is_known_.assign(response_is_known_.size(), 0);
  if (!fits) make_matrix(system, values);
  const std::shared_ptr<const SchurComplementConstraints> older = fits ? system.coupling : nullptr;
  if (older && same_rows(*system.coupled_rows, *system.auxiliary))
    system.coupled_rows = system.auxiliary;
  else
    couple(system, older.get());
  return !fits;
}

SurfaceEnergy SessionEngine::elastic_energy(const SessionSystem& system,
                                            const std::vector<double>& values, const Points& x) {
  const bool has_rest_shape = system.rest && system.rest->dofs.rows() > 0;
  const Points from_rest = has_rest_shape ? Points(x - system.rest->dofs) : x;
  const auto part = [&](bool bends) {
    auto all = materials(system, values);
    all.resize(static_cast<size_t>(system.parts->mesh->triangle_count()), all[0]);
    for (SurfaceStiffness& m : all) {
      if (bends)
        m.alpha.setZero();
      else
        m.beta = m.beta_mixed = Vec3::Zero();
    }
    SparseMatrix K = system.parts->assembler.pattern();
    system.parts->assembler.stiffness(all, K);
    multiply_symmetric(K, from_rest, product_);
    return 0.5 * from_rest.cwiseProduct(product_).sum();
  };
  return {part(false), part(true)};
}

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
  if (missed > kRoundingTolerance * system.layout().size()) throw_conflict(system, values, row);
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
  // The elimination finds which constraints imply the redundant one; it runs only in case of
  // conflict.
  const ConstraintSet all = all_rows(system, values);
  const AuxiliaryConstraints& auxiliary = *system.auxiliary;
  std::vector<ConflictError::Conflict> conflicts;
  try {
    AffineReduction(all, AffineReduction::RhsMode::Given, kRedundantTolerance);
  } catch (const ConflictError& e) {
    for (const auto& conflict : e.conflicts())
      if (conflict.amount > kRoundingTolerance * system.layout().size())
        conflicts.push_back(conflict);
  }
  if (!conflicts.empty()) throw ConflictError(std::move(conflicts));
  throw ConflictError({{{auxiliary.name_of(row), "the adjacent curves or constraints"},
                        system.coupling->contradiction(g_).first}});
}

void SessionEngine::prepare_rhs(SessionSystem& system, const std::vector<double>& values) {
  // Right-hand sides of lines are recomputed only if lines moved.
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
  if (system.matrix_load.rows() > 0) to += system.matrix_load_reduced;
  if (system.rest_load.rows() > 0) to += system.rest_reduced;
}

namespace {

// The point of a spring's target that is closest to p.
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
      throw InputError("load '" + rows.name_of(soft[k]) + "': found the spring stiffness " +
                       format_number(value) + ", expected 0 or more");
    const Vec3 p = ax_.row(row.point).transpose() + system.origin();
    const SpringTarget to = spring_target(system, rows.sources[r], value, p);
    wanted_stiffness_[static_cast<long>(k)] = to.stiffness;
    g_[static_cast<long>(r)] =
        row.direction.dot(to.target - system.origin() - Vec3(ae_.row(row.point)));
  }
  if (wanted_stiffness_ != stiffness_) {
    system.coupling->set_stiffness(wanted_stiffness_);
    stiffness_ = wanted_stiffness_;
    // Load responses were computed for other spring stiffnesses.
    response_is_known_.assign(response_is_known_.size(), 0);
  }
}

// Energy of a spring of stiffness 1: 2 ∫ φ(ρ) (ρ - r₀) dρ from r₀ to r.
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

namespace {

// Fraction of the size: smaller changes that no longer decrease are rounding.
constexpr double kRoundingFloor = 1e-9;
// Factor of the size: after a larger change in one iteration, the solve has diverged.
constexpr double kDivergence = 1e6;

}  // namespace

bool SessionEngine::is_linear(const SessionSystem& system,
                              const std::vector<double>& values) const {
  for (size_t l = 0; l < system.loads.size(); ++l) {
    const auto p = static_cast<size_t>(system.load_parameter[l]);
    const bool follows = std::holds_alternative<Load::Pressure>(system.def.loads[l]->load.kind) ||
                         (system.roles[p] & kSpring && system.roles[p] & kPressure);
    if (follows && values[p] != 0) return false;
  }
  return true;
}

void SessionEngine::map(SessionSystem& system, const std::vector<double>& values, const Points& x,
                        Points& to) {
  y_ = base_;
  bool has_pressure = false;
  for (size_t l = 0; l < system.loads.size(); ++l) {
    if (!std::holds_alternative<Load::Pressure>(system.def.loads[l]->load.kind)) continue;
    const double v = values[system.load_parameter[l]];
    if (v == 0) continue;
    if (!has_pressure) F_.setZero();
    has_pressure = true;
    system.parts->pressure().add(x, system.loads[l]->weights, v * system.loads[l]->scale, F_);
  }
  throw_if_cancelled();
  if (has_pressure) system.statics->add_load(F_, y_);
  set_spring_targets(system, values, x);
  throw_if_cancelled();
  system.statics->solve(y_);
  system.coupling->apply(y_, g_);
  throw_if_cancelled();
  system.statics->expand(y_, e_, to);
}

// Superposition: if only linear loads changed since the anchor, the solution is the anchor shape
// plus a response per load.
bool SessionEngine::superpose(SessionSystem& system, const std::vector<double>& values, Points& x,
                              SolveStatus& run) {
  for (size_t p = 0; p < values.size(); ++p)
    if (values[p] != anchor_values_[p] && (system.roles[p] & ~unsigned(kLinear)) != 0) return false;
  if (x_is_anchor_) anchor_ = x;
  x_is_anchor_ = false;
  next_ = anchor_;
  for (size_t l = 0; l < system.loads.size(); ++l) {
    const auto p = static_cast<size_t>(system.load_parameter[l]);
    if (system.loads[l]->reduced.rows() == 0 || values[p] == anchor_values_[p]) continue;
    if (!response_is_known_[l]) {
      // Response to this load alone: zero right-hand sides of the constraints, current spring
      // stiffnesses.
      y_ = system.loads[l]->reduced;
      system.statics->solve(y_);
      g_.setZero();
      system.coupling->apply(y_, g_);
      responses_[l].resize(x.rows(), 3);
      responses_[l].noalias() = system.reduction->D() * y_;
      response_is_known_[l] = 1;
      ++run.iterations;
    }
    next_ += (values[p] - anchor_values_[p]) * responses_[l];
  }
  run.change = change_between(next_, x) / system.layout().size();
  x.swap(next_);
  run.converged = run.superposed = true;
  return true;
}

// During a drag, previous solves predict the error of the first iterate. If it is small enough, no
// second iteration is made, except in every fourth solve, which measures again.
bool SessionEngine::accept_first_iterate(double first_change, double tolerance, SolveStatus& run) {
  constexpr double careful = 5;
  constexpr int most_unseen = 3;
  const double expected = careful * contraction_ratio_ * first_change;
  run.change_is_estimated = run.iterations == 1 && contraction_ratio_ > 0 &&
                            unmeasured_count_ < most_unseen && expected <= tolerance;
  unmeasured_count_ = run.change_is_estimated ? unmeasured_count_ + 1 : 0;
  if (run.change_is_estimated) {
    run.change = expected;
    run.converged = true;
  }
  return run.change_is_estimated;
}

SessionEngine::SolveStatus SessionEngine::solve_preview(SessionSystem& system,
                                                        const std::vector<double>& values,
                                                        Points& x, int most, double tolerance,
                                                        bool may_superpose) {
  SolveStatus run;
  if (is_linear(system, values) && may_superpose && anchored_ && superpose(system, values, x, run))
    return run;
  anchored_ = false;
  start_moved_ = false;
  try {
    return iterate(system, values, x, most, tolerance, may_superpose);
  } catch (...) {
    if (start_moved_) x.swap(start_);
    reset_acceleration();
    throw;
  }
}

SessionEngine::SolveStatus SessionEngine::iterate(SessionSystem& system,
                                                  const std::vector<double>& values, Points& x,
                                                  int most, double tolerance, bool may_superpose) {
  const double size = system.layout().size();
  const bool linear = is_linear(system, values);
  SolveStatus run;
  prepare_rhs(system, values);
  accelerator_.begin();
  double least_change = std::numeric_limits<double>::infinity();
  int iterations_since_least = 0;
  double first_change = 0;
  while (run.iterations < most) {
    map(system, values, x, next_);
    ++run.iterations;
    run.change = change_between(next_, x) / size;
    if (!(run.change < kDivergence)) {  // written so that it is also true for NaN
      run.diverged = true;
      accelerator_.clear();
      return run;
    }
    // Rounding limits the accuracy, more on cut and graded meshes: the change then stops
    // decreasing.
    iterations_since_least = run.change < 0.5 * least_change ? 0 : iterations_since_least + 1;
    if (iterations_since_least == 0) least_change = run.change;
    const bool at_floor = iterations_since_least >= 4 && least_change <= kRoundingFloor;
    run.converged = linear || run.change <= tolerance || at_floor;
    if (run.iterations == 1) first_change = run.change;
    if (run.iterations == 2 && may_superpose)
      contraction_ratio_ = std::max(0.5 * contraction_ratio_, run.change / first_change);
    throw_if_cancelled();
    // The last pair keeps the Anderson history up to date for the next solve.
    if (!run.converged || run.iterations > 1) accelerator_.add_iterate(x, next_);
    throw_if_cancelled();
    if (!run.converged) accelerator_.extrapolate(next_);
    x.swap(next_);
    if (run.iterations == 1) {  // keeps x from before the first iteration
      next_.swap(start_);
      start_moved_ = true;
    }
    if (run.converged) break;
    if (may_superpose)
      accept_first_iterate(first_change, tolerance, run);
    else
      unmeasured_count_ = 0;
    // An extrapolated iterate satisfies the constraints only as accurately as its differences do.
    if (run.change_is_estimated || run.iterations == most) project_onto_constraints(system, x);
    if (run.change_is_estimated) break;
    throw_if_cancelled();
  }
  if (linear) {
    anchor_values_ = values;
    anchored_ = x_is_anchor_ = true;
  }
  return run;
}

double SessionEngine::change_between(const Points& a, const Points& b) const {
  double largest = 0, all = 0;
  for (int c = 0; c < 3; ++c) {
    largest =
        std::max(largest, ((a.col(c) - b.col(c)).cwiseAbs().cwiseProduct(dof_weights_)).maxCoeff());
    all += a.col(c).sum();
  }
  return std::isfinite(all) ? largest : std::numeric_limits<double>::quiet_NaN();
}

void SessionEngine::project_onto_constraints(const SessionSystem& system, Points& x) {
  const auto& free = system.reduction->free_dofs();
  for (int c = 0; c < 3; ++c)
    for (size_t f = 0; f < free.size(); ++f) y_(static_cast<long>(f), c) = x(free[f], c);
  system.coupling->project(y_, g_);
  system.statics->expand(y_, e_, x);
}

bool SessionEngine::update_scan_foot_points(SessionSystem& system, const Points& x) {
  bool moved = false;
  for (size_t l = 0; l < system.loads.size(); ++l) {
    const auto* scan = std::get_if<Load::PointCloudSprings>(&system.def.loads[l]->load.kind);
    if (!scan) continue;
    const ModelProjector projector(system.layout(),
                                   x + system.parts->ones * system.origin().transpose());
    auto& foot_points = system.scan_foot_points[l];
    auto& used = system.scan_used[l];
    const bool first = foot_points.empty();
    foot_points.resize(scan->points.size());
    used.resize(scan->points.size());
    for (size_t i = 0; i < foot_points.size(); ++i) {
      throw_if_cancelled();
      const Vec3& p = scan->points[i];
      const auto closest = projector.nearest(p);
      // At the boundary, the vector to a point beyond it is not perpendicular to the surface.
      const SurfaceJet jet = projector.surface(closest.at.region).jet(closest.where);
      const Vec3 across = p - jet.x;
      const char use = closest.inside && (across.norm() <= 1e-9 * system.layout().size() ||
                                          std::abs(across.normalized().dot(jet.normal())) > 0.7);
      moved = moved || first || use != used[i] || closest.at.region != foot_points[i].region ||
              !((closest.at.uv - foot_points[i].uv).norm() < 1e-6);
      foot_points[i] = closest.at;
      used[i] = use;
    }
  }
  if (moved) invalidate_matrix(system);
  return moved;
}

}  // namespace batten::detail
