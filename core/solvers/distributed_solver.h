// SPDX-License-Identifier: MPL-2.0
// Linear systems that are distributed over several MPI processes, and the interface of the module
// that solves them with PETSc.
#pragma once

#include <string>

#include "batten/core/eigen.h"
#include "batten/core/solvers/linear_solver_backend.h"

extern "C" {

// Functions of the PETSc module. They return an error message for the user, or null on success; the
// message is valid until the next call. All functions except serve() are called in MPI process 0.
struct BattenDistributed {
  int rank, size;
  // Executes requests of MPI process 0 until that calls end(); called in all other processes.
  void (*serve)();
  // Factors a symmetric n×n matrix, whose lower triangle is given in compressed columns without
  // gaps: column starts `outer`, row indices `inner`, `values`. `id`: number of the new factor.
  const char* (*factorize)(int id, int n, const int* outer, const int* inner, const double* values);
  // Solves A x = b with the factor `id` of a matrix A: b (n×k, by columns) is overwritten by x.
  const char* (*solve)(int id, double* b, int k);
  void (*release)(int id);
  void (*end)();
};

// Initialises MPI and PETSc and fills in `module`. Returns an error message, or null on success.
// This entry point is looked up by name in the PETSc module (petsc_module.cpp), which is loaded
// only when a run has several MPI processes.
const char* batten_distributed(BattenDistributed* module);
}

namespace batten {

/// Linear solver whose factor is distributed over all MPI processes; used by process 0.
class DistributedSolver final : public LinearSolverBackend {
 public:
  /// Creates a solver that uses the functions `module` of the PETSc module. `module` must outlive
  /// the solver. `id`: number of the factor in the module, different for each solver.
  DistributedSolver(const BattenDistributed& module, int id) : module_(module), id_(id) {}
  ~DistributedSolver() override;
  DistributedSolver(const DistributedSolver&) = delete;
  DistributedSolver& operator=(const DistributedSolver&) = delete;

  bool factorize(const SparseMatrix& A) override;
  const std::string& message() const override { return message_; }
  /// Solves A x = b in place for the last factorized matrix A. Throws NoSolutionError if the PETSc
  /// module reports an error.
  void solve_in_place(Eigen::Ref<MatX> b) const override;

 private:
  const BattenDistributed& module_;
  int id_, rows_ = 0;
  std::string message_;
};

/// MPI processes of this run. Process 0 runs the program; the other processes only take part in
/// factorizations and solves.
class MpiProcesses {
 public:
  /// Number of processes of this run, from the environment of Open MPI or MPICH; 1 without mpirun.
  static int count();

  /// Starts the PETSc module. `start`: entry point of the module, batten_distributed(). Throws
  /// InputError if MPI or PETSc cannot be initialised.
  explicit MpiProcesses(const char* (*start)(BattenDistributed*));
  /// In MPI process 0: terminates all other MPI processes.
  ~MpiProcesses();
  MpiProcesses(const MpiProcesses&) = delete;
  MpiProcesses& operator=(const MpiProcesses&) = delete;

  int size() const { return module_.size; }
  /// True in all MPI processes except process 0; workers only call serve().
  bool is_worker() const { return module_.rank > 0; }
  /// Executes requests of MPI process 0 until that terminates; called in all other processes.
  void serve() { module_.serve(); }
  /// Factory of solvers that are distributed over all MPI processes. The solvers must not outlive
  /// this object.
  BackendFactory solvers();

 private:
  BattenDistributed module_{};
  int next_id_ = 0;
};

}  // namespace batten
