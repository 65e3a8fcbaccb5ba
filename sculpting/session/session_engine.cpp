#include "batten/sculpting/session/session_engine.h"

#include "batten/sculpting/session/displacement_weights.h"

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
  for (Points* p : {&e_, &next_, &F_, &product_}) p->setZero(n, 3);
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
  accelerator_.resize(n, std::move(sample));
  contraction_ratio_ = 0;
  dof_weights_ = displacement_weights(*system.parts->mesh, system.parts->trim.get());
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

}  // namespace batten::detail
