// Distributed linear solves under mpirun.
#pragma once

#include <memory>

#include "batten/core/solvers/sparse_cholesky.h"

namespace batten {

/// The processes started by mpirun. Process 0 runs the program; the others take part in
/// factorizations and solves, by PETSc. The PETSc plugin is loaded here, so that programs that do
/// not use it do not depend on PETSc.
class MpiProcesses {
 public:
  /// The processes of this run; null if there is only one. Throws InputError if the plugin was not
  /// built (no PETSc) or cannot be started.
  static std::unique_ptr<MpiProcesses> detect();
  /// Terminates the other processes.
  ~MpiProcesses();

  /// Number of processes.
  int size() const;
  /// True for processes other than 0; they only call serve().
  bool is_worker() const;
  /// Processes the requests of process 0 until it terminates.
  void serve();
  /// Factory of solvers distributed over all processes. The solvers must not outlive this object.
  BackendFactory factors();

 private:
  struct Plugin;
  explicit MpiProcesses(std::unique_ptr<Plugin> plugin);
  std::unique_ptr<Plugin> plugin_;
};

}  // namespace batten
