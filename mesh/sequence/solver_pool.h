// Frame solvers for several threads. Internal.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "batten/mesh/sequence/frame_solver.h"

namespace batten {

/// Solvers that are alike, one for each thread that asks at the same time.
class SolverPool {
 public:
  SolverPool(const TriangleMesh& mesh, FrameConstraints constraints, const FrameOptions& options)
      : mesh_(&mesh), constraints_(std::move(constraints)), options_(options) {
    free_.push_back(std::make_unique<FrameSolver>(mesh, constraints_, options_));
    notes_ = free_.front()->notes();
  }
  /// Calls use(solver) with one that nobody else has meanwhile.
  template <class Use>
  void with(const Use& use) {
    std::unique_ptr<FrameSolver> solver;
    {
      const std::lock_guard lock(mutex_);
      if (!free_.empty()) {
        solver = std::move(free_.back());
        free_.pop_back();
      }
    }
    if (!solver) solver = std::make_unique<FrameSolver>(*mesh_, constraints_, options_);
    use(*solver);
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(solver));
  }
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  const TriangleMesh* mesh_;
  FrameConstraints constraints_;
  FrameOptions options_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<FrameSolver>> free_;
  std::vector<std::string> notes_;
};

}  // namespace batten
