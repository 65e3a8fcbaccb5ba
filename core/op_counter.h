// Counters of the expensive operations of the kernel: a machine-independent measure of work.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>

namespace batten {

/// Kinds of operations that are counted. Unlike timings, which depend on the machine, counts show
/// what was done: a test can check that no work is done twice.
enum class OpCounter {
  Analysis,           ///< symbolic analysis of a sparse Cholesky factor
  Factorization,      ///< numeric sparse Cholesky factorization
  Solve,              ///< pair of triangular solves, full or partial, all columns
  AssembledElement,   ///< element stiffness or mass matrix added to a matrix
  Triangulation,      ///< Delaunay or fan mesh of a domain, or of facets
  HoleTriangulation,  ///< triangulation of a 3D polygon, O(n³)
  Allocation          ///< call of malloc, in programs that count them (tests and benchmarks)
};
inline constexpr int kOpCounterCount = 7;

namespace detail {
inline std::array<std::atomic<std::int64_t>, kOpCounterCount> totals{};
}

/// Adds to the process-wide total of one kind. Thread-safe; takes a few nanoseconds and allocates
/// nothing.
inline void count(OpCounter kind, std::int64_t times = 1) {
  detail::totals[static_cast<size_t>(kind)].fetch_add(times, std::memory_order_relaxed);
}

/// Counts the operations of all threads since this object was constructed.
///
///     const ScopedOpCount ops;
///     session.solve_preview();
///     ops.of(OpCounter::Solve);  // 1
class ScopedOpCount {
 public:
  ScopedOpCount() {
    for (size_t k = 0; k < start_.size(); ++k) start_[k] = detail::totals[k];
  }
  /// Number of operations of one kind since construction.
  std::int64_t of(OpCounter kind) const {
    const auto k = static_cast<size_t>(kind);
    return detail::totals[k] - start_[k];
  }
  /// All counts as text for messages: "2 analyses, 1 factorizations, …".
  std::string text() const;

 private:
  std::array<std::int64_t, kOpCounterCount> start_{};
};

}  // namespace batten
