#include "batten/sculpting/session/session_engine.h"

#include "batten/sculpting/session/change_weights.h"

namespace batten::live {

void symmetric_times(const SparseMatrix& S, const Points& x, Points& out) {
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

void Engine::bind(const System& system) {
  const int n = system.dofs(), m = system.reduction->free_count();
  const auto points = system.loose->A.cols();
  const auto rows = static_cast<long>(system.loose->rows.size());
  right_.setZero(system.base_right.rows(), 3);
  rate_.setZero(system.base_right.rows(), 3);
  hd_.setZero(m, 3);
  base_.setZero(m, 3);
  y_.setZero(m, 3);
  for (Points* p : {&e_, &next_, &F_, &product_}) p->setZero(n, 3);
  ae_.setZero(points, 3);
  ax_.setZero(points, 3);
  av_.setZero(points, 3);
  g_.setZero(rows);
  long soft = 0;
  for (const auto& row : system.loose->rows) soft += row.soft;
  stiffness_.setConstant(soft, -1);
  wanted_.setZero(soft);
  std::vector<int> sample;
  for (int v = 0; v < system.parts->mesh->vertex_count(); ++v)
    sample.push_back(system.parts->assembler.dofs().vertex(v));
  secants_.resize(n, std::move(sample));
  gain_ = 0;
  felt_ = change_weights(*system.parts->mesh, system.parts->trim.get());
  responses_.clear();
  responses_.resize(system.loads.size());
  known_response_.assign(system.loads.size(), 0);
  anchored_ = false;
  right_values_.clear();
}

void Engine::forget() {
  secants_.clear();
  gain_ = 0;
  stiffness_.setConstant(-1);
  known_response_.assign(known_response_.size(), 0);
  anchored_ = false;
}

}  // namespace batten::live
