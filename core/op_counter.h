// SPDX-License-Identifier: MPL-2.0
// Counters of the expensive operations of the kernel: a machine-independent measure of work.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>

namespace batten {

/// Kinds of operations that are counted. Unlike timings, which depend on the machine, counts are
/// reproducible: a test can check that no work is done twice.
enum class OpCounter {
  Analysis,          ///< symbolic analysis of a sparse Cholesky factor
  Factorization,     ///< numeric sparse Cholesky factorization
  Solve,             ///< one pair of triangular solves (full or partial) for all right-hand sides
  AssembledElement,  ///< element stiffness or mass matrix added to a global matrix
  Triangulation,  ///< mesh of a planar domain or of facets (Delaunay triangulation or triangle fan)
  HoleTriangulation,  ///< triangulation of a polygon in space with n corners, O(n³)
  Allocation          ///< call of malloc, in programs that count them (tests and benchmarks)
};
inline constexpr int kOpCounterCount = 7;

namespace detail {
inline std::array<std::atomic<std::int64_t>, kOpCounterCount> totals{};
}

/// Adds `times` to the process-wide count of one kind of operation. Thread-safe; takes a few
/// nanoseconds and allocates nothing.
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
  /// Number of operations of one kind, in all threads, since this object was constructed.
  std::int64_t of(OpCounter kind) const {
    const auto k = static_cast<size_t>(kind);
    return detail::totals[k] - start_[k];
  }
  /// All counts since construction of this object, as text: "2 analyses, 1 factorizations, …".
  std::string text() const {
    constexpr std::array<const char*, kOpCounterCount> words = {
        "analyses",       "factorizations",      "solves",     "assembled elements",
        "triangulations", "hole triangulations", "allocations"};
    std::string text;
    for (size_t k = 0; k < words.size(); ++k)
      text += (k ? ", " : "") + std::to_string(of(static_cast<OpCounter>(k))) + " " + words[k];
    return text;
  }

 private:
  std::array<std::int64_t, kOpCounterCount> start_{};
};

}  // namespace batten
