// Several processes of one run, under mpirun.
#pragma once

#include <memory>

#include "batten/core/solvers/sparse_cholesky.h"

namespace batten {

/// The processes that mpirun started. Process 0 does everything but what it hands to all: the factors of
/// its systems and solves with them, by PETSc. The module for that is loaded here, so that programs
/// that do not need it do not carry it.
class MpiProcesses {
 public:
  /// The processes of this run; null where there is only this one. Throws InputError: the module was
  /// not built (no PETSc), or does not start.
  static std::unique_ptr<MpiProcesses> detect();
  /// Ends the other processes.
  ~MpiProcesses();

  int size() const;
  /// Whether this process only helps; serve() is then all that it does.
  bool is_worker() const;
  void serve();
  /// Makes factors that all processes share. They must not outlive this object.
  BackendFactory factors();

 private:
  struct Plugin;
  explicit MpiProcesses(std::unique_ptr<Plugin> plugin);
  std::unique_ptr<Plugin> plugin_;
};

}  // namespace batten
