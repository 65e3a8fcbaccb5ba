// SPDX-License-Identifier: MPL-2.0
#include "batten/core/solvers/distributed_solver.h"

#include <cstdlib>

#include "batten/core/errors.h"

namespace batten {

DistributedSolver::~DistributedSolver() {
  if (rows_ > 0) module_.release(id_);
}

bool DistributedSolver::factorize(const SparseMatrix& A) {
  SparseMatrix lower = A.triangularView<Eigen::Lower>();
  lower.makeCompressed();
  rows_ = static_cast<int>(lower.rows());
  const char* failed =
      module_.factorize(id_, rows_, lower.outerIndexPtr(), lower.innerIndexPtr(), lower.valuePtr());
  message_ = failed ? failed : "";
  return !failed;
}

void DistributedSolver::solve_in_place(Eigen::Ref<MatX> b) const {
  MatX columns = b;  // contiguous
  if (const char* failed = module_.solve(id_, columns.data(), static_cast<int>(columns.cols())))
    throw NoSolutionError(failed);
  b = columns;
}

int MpiProcesses::count() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"})
    if (const char* value = std::getenv(name)) return std::atoi(value);
  return 1;
}

MpiProcesses::MpiProcesses(const char* (*start)(BattenDistributed*)) {
  if (const char* failed = start(&module_)) throw InputError(failed);
}

MpiProcesses::~MpiProcesses() {
  if (!is_worker()) module_.end();
}

BackendFactory MpiProcesses::solvers() {
  return [this] { return std::make_unique<DistributedSolver>(module_, next_id_++); };
}

}  // namespace batten
