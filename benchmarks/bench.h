// SPDX-License-Identifier: MPL-2.0
// Shared by all benchmarks: clocks, medians, tables, checks.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/parallel.h"

// Present if BLAS is OpenBLAS (used by the peers' factorizations), and if a peer uses OpenMP:
// CHOLMOD requests four threads whatever the value of OMP_NUM_THREADS.
extern "C" __attribute__((weak)) void openblas_set_num_threads(int);
extern "C" __attribute__((weak)) void omp_set_max_active_levels(int);

namespace batten::bench {

/// One thread for all sides.
inline void one_thread() {
  set_thread_count(1);
  if (openblas_set_num_threads) openblas_set_num_threads(1);
  if (omp_set_max_active_levels) omp_set_max_active_levels(0);
}

/// Processor seconds of this process: on one thread, the wall-clock time of an idle machine, also
/// if others use the machine.
inline double seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

inline double cpu_seconds_of(const std::function<void()>& work) {
  const double start = seconds();
  work();
  return seconds() - start;
}

/// Wall-clock seconds, for work on several threads or in another process.
inline double wall_seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// For an even count, the mean of the two middle values.
inline double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  return n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

/// Median time of each of `works`, in seconds. They alternate, so that a slow phase of the machine
/// affects all of them; one warm-up round is not counted.
inline std::vector<double> side_by_side(int rounds,
                                        const std::vector<std::function<void()>>& works) {
  std::vector<std::vector<double>> times(works.size());
  for (int round = -1; round < rounds; ++round)
    for (size_t w = 0; w < works.size(); ++w) {
      const double t = cpu_seconds_of(works[w]);
      if (round >= 0) times[w].push_back(t);
    }
  std::vector<double> medians;
  for (auto& t : times) medians.push_back(median(std::move(t)));
  return medians;
}

/// sprintf into a string.
template <class... Values>
std::string text(const char* format, Values... values) {
  std::vector<char> buffer(static_cast<size_t>(std::snprintf(nullptr, 0, format, values...)) + 1);
  std::snprintf(buffer.data(), buffer.size(), format, values...);
  return buffer.data();
}

/// A table printed in columns of the required width; the first row is the header.
class Table {
 public:
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  void print() const {
    std::vector<size_t> width;
    for (const auto& row : rows_)
      for (size_t c = 0; c < row.size(); ++c) {
        if (c == width.size()) width.push_back(0);
        width[c] = std::max(width[c], row[c].size());
      }
    for (size_t r = 0; r < rows_.size(); ++r) {
      for (size_t c = 0; c < rows_[r].size(); ++c)
        std::printf(c ? "  %*s" : "%-*s", static_cast<int>(width[c]), rows_[r][c].c_str());
      std::printf("\n");
      if (r > 0) continue;
      for (size_t c = 0; c < width.size(); ++c)
        std::printf("%s%s", c ? "  " : "", std::string(width[c], '-').c_str());
      std::printf("\n");
    }
    std::printf("\n");
  }

 private:
  std::vector<std::vector<std::string>> rows_;
};

/// The checks of a benchmark: measured values against targets. A check without a value (the peer is
/// missing) fails.
class Checks {
 public:
  void at_least(const std::string& name, std::optional<double> value, double target) {
    list_.push_back({name, "at least", value, target, value && *value >= target});
  }
  void at_most(const std::string& name, std::optional<double> value, double target) {
    list_.push_back({name, "at most", value, target, value && *value <= target});
  }

  /// Prints a table, and one JSON object on the last line.
  void print(const std::string& bench) const {
    Table table;
    table.add({"check", "measured", "", "target", ""});
    for (const auto& p : list_)
      table.add({p.name, p.value ? text("%.4g", *p.value) : "none", p.sense, text("%g", p.target),
                 p.ok ? "ok" : "MISSED"});
    table.print();
    std::printf("{\"bench\": \"%s\", \"promises\": [", bench.c_str());
    for (size_t i = 0; i < list_.size(); ++i) {
      const auto& p = list_[i];
      std::printf("%s{\"name\": \"%s (%s)\", \"value\": %s, \"target\": %.10g, \"ok\": %s}",
                  i ? ", " : "", p.name.c_str(), p.sense.c_str(),
                  p.value ? text("%.10g", *p.value).c_str() : "null", p.target,
                  p.ok ? "true" : "false");
    }
    std::printf("]}\n");
  }

 private:
  struct Check {
    std::string name, sense;
    std::optional<double> value;
    double target;
    bool ok;
  };
  std::vector<Check> list_;
};

}  // namespace batten::bench
