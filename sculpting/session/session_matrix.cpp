#include "batten/core/errors.h"
#include "batten/sculpting/session/session_engine.h"

namespace batten::detail {

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
      throw InputError("alpha must be positive semi-definite and beta not negative, everywhere");
    m = system.def.scale().material(m);
  }
  return system.layout().scale_to_regions(std::move(all));
}

}  // namespace

// Scans act on the matrix itself: Σ k N Nᵀ, and Σ k N p on the right.
void SessionEngine::add_scans(SessionSystem& system, const std::vector<double>& values,
                              SparseMatrix& K) {
  const MeshData& parts = *system.parts;
  system.scan_load.resize(0, 3);
  for (size_t l = 0; l < system.loads.size(); ++l) {
    const auto* scan = std::get_if<Load::PointCloudSprings>(&system.def.loads[l]->load.kind);
    if (!scan || system.scan_foot_points[l].empty()) continue;
    if (system.scan_load.rows() == 0) system.scan_load = Points::Zero(system.dofs(), 3);
    const double value = values[system.load_parameter[l]];
    if (!(value >= 0))
      throw InputError("load '" + system.def.loads[l]->load.name + "' has springs of stiffness " +
                       format_number(value) + ": it must not be below 0");
    const double k = value / static_cast<double>(scan->points.size());
    for (size_t i = 0; i < scan->points.size(); ++i) {
      if (!system.scan_used[l][i]) continue;
      const Location where = parts.at(system.scan_foot_points[l][i]);
      const Vec12 N =
          C1Triangle(parts.kind, parts.mesh->shape(where.triangle)).evaluate(where.L).col(kW);
      const auto dof = parts.assembler.dofs().triangle(*parts.mesh, where.triangle);
      for (int a = 0; a < 12; ++a) {
        system.scan_load.row(dof[a]) += k * N[a] * (scan->points[i] - system.origin()).transpose();
        for (int b = 0; b < 12; ++b)
          if (dof[a] >= dof[b]) K.coeffRef(dof[a], dof[b]) += k * N[a] * N[b];
      }
    }
  }
  if (system.scan_load.rows() > 0)
    system.scan_reduced = system.reduction->D().transpose() * system.scan_load;
}

// What ties regions along embedded lines, for the values.
SparseMatrix SessionEngine::join_stiffness(const SessionSystem& system,
                                           const std::vector<double>& values) {
  const double beta = (values[system.beta[0]] + values[system.beta[2]]) / 2;
  return system.def.scale().material(SurfaceStiffness::isotropic(0, beta)).beta[0] *
         system.layout().join_stiffness();
}

// What holds the surface in its rest shape, as a load: K x_rest. `K` is without scans and joins.
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
  if (system.statics && system.scan_load.rows() == 0) {
    const SparseMatrix joins = join_stiffness(system, system.matrix_values);
    if (joins.nonZeros() > 0)
      set_rest_load(system, system.statics->matrix() - joins);
    else
      set_rest_load(system, system.statics->matrix());
  } else
    invalidate_matrix(system);
}

// The matrix and its factor for the values.
void SessionEngine::make_matrix(SessionSystem& system, const std::vector<double>& values) {
  const MeshData& parts = *system.parts;
  const auto all = materials(system, values);
  SparseMatrix K = parts.assembler.pattern();
  if (all.size() == 1)
    parts.assembler.stiffness(all[0], K);
  else
    parts.assembler.stiffness(all, K);
  set_rest_load(system, K);
  K += join_stiffness(system, values);
  add_scans(system, values, K);
  // A factor that the history keeps must stay; one of our own takes other numbers in place.
  if (system.statics && system.statics.use_count() == 1)
    system.statics->set_matrix(std::move(K));
  else
    system.statics =
        system.statics
            ? std::make_shared<ReusableFactorization>(*system.statics, std::move(K))
            : std::make_shared<ReusableFactorization>(system.reduction, std::move(K),
                                                      parts.vertices, system.def.factor_reuse);
  system.matrix_values = values;
  system.dynamics.reset();
  system.dynamics_coupling.reset();
}

// Whether two couplings of these would be equal, on one mesh and reduction. What their right-hand
// sides come from may differ.
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

// Makes the coupling of the rows beside the factor. `older` is on the same factor: solves of what
// it has already are kept.
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
  SparseMatrix U = SparseMatrix(system.reduction->D().transpose()) * rows.A;
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
  bool fits = system.statics && system.matrix_values.size() == values.size();
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
    return from_rest.cwiseProduct(product_).sum();
  };
  return {part(false), part(true)};
}

}  // namespace batten::detail
