// Counts of the kernel's heavy steps: how much work a computation was, the same on any machine.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>

namespace batten {

/// A kind of work that is worth counting. Times say how fast a machine is; these counts say what
/// was done, so that work done twice is a test that fails and not a clock that nobody reads.
enum class OpCounter {
  Analysis,           ///< order and pattern of a sparse Cholesky factor
  Factorization,      ///< numbers of a sparse Cholesky factor
  Solve,              ///< pair of triangular solves, whole or in part, for all columns at once
  AssembledElement,   ///< element whose stiffness or mass was added to a matrix
  Triangulation,      ///< Delaunay or fan mesh of a domain, or of facets
  HoleTriangulation,  ///< triangulation of a loop of points in space, O(n³)
  Allocation          ///< call of malloc, in programs that count them (tests and benchmarks)
};
inline constexpr int kOpCounterCount = 7;

namespace detail {
inline std::array<std::atomic<std::int64_t>, kOpCounterCount> totals{};
}

/// Adds to the total of the process, from any thread. A few nanoseconds; allocates nothing.
inline void count(OpCounter kind, std::int64_t times = 1) {
  detail::totals[static_cast<size_t>(kind)].fetch_add(times, std::memory_order_relaxed);
}

/// The work of all threads since this object was made.
///
///     const ScopedOpCount work;
///     session.answer();
///     work.of(Work::Solve);  // 1
class ScopedOpCount {
 public:
  ScopedOpCount() {
    for (size_t k = 0; k < start_.size(); ++k) start_[k] = detail::totals[k];
  }
  std::int64_t of(OpCounter kind) const {
    const auto k = static_cast<size_t>(kind);
    return detail::totals[k] - start_[k];
  }
  /// All counts in words, as "2 analyses, 1 factorization, …", for messages.
  std::string text() const;

 private:
  std::array<std::int64_t, kOpCounterCount> start_{};
};

}  // namespace batten
