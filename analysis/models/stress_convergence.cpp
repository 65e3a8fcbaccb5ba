// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/stress_convergence.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "batten/core/containers.h"

namespace batten {

std::vector<double> triangle_edge_lengths(const Surface& surface) {
  std::vector<double> lengths(static_cast<size_t>(surface.mesh().triangle_count()));
  for (int t = 0; t < isize(lengths); ++t)
    lengths[static_cast<size_t>(t)] = triangle_edge_length(surface, t);
  return lengths;
}

void StressConvergence::take(const ShellModel& shell, const ShellLoadCase& load_case,
                             const ShellCaseResult& result, const ShellStresses& stresses) {
  follow(shell, load_case, stresses, result.max_stress);
  constexpr int most = 20;
  for (int k = 0; k < most && is_singular(shell); ++k) {
    exclude(shell, peak_.at, peak_.where);
    follow(shell, load_case, stresses, stresses.largest_outside(places_));
  }
}

void StressConvergence::exclude(const ShellModel& shell, const Vec3& at, const Location& where) {
  const int first = first_.of(shell.layout(), where);
  places_.push_back({at, std::max(edge_lengths_[static_cast<size_t>(first)],
                                  shell.assembler().section(where.triangle).thickness)});
  values_.clear();
}

bool StressConvergence::is_singular(const ShellModel& shell) const {
  constexpr double small = 1.0 / 8;
  const int triangle = peak_.where.triangle;
  return grows_without_limit() ||
         (error_ > accuracy_ && triangle_edge_length(shell.assembler().surface(), triangle) <
                                    small * shell.assembler().section(triangle).thickness);
}

void StressConvergence::follow(const ShellModel& shell, const ShellLoadCase& load_case,
                               const ShellStresses& stresses, ShellStresses::Peak peak) {
  while (const auto point = singular_point_near(shell, load_case, places_, peak)) {
    exclude(shell, *point, peak.where);
    peak = stresses.largest_outside(places_);
  }
  peak_ = peak;
  values_.push_back(peak.value);
  error_ = 0;
  if (!(peak.value > 0)) return;
  error_ = peak.spread / peak.value;
  if (values_.size() > 1)
    error_ = std::max(error_, std::abs(peak.value - values_[values_.size() - 2]) / peak.value);
}

bool StressConvergence::grows_without_limit() const {
  constexpr size_t rounds = 2;
  constexpr double least = 0.02;
  if (values_.size() <= rounds) return false;
  std::vector<double> increases;
  for (size_t k = values_.size() - rounds; k < values_.size(); ++k)
    increases.push_back(values_[k] > 0 ? (values_[k] - values_[k - 1]) / values_[k] : 0);
  return *std::min_element(increases.begin(), increases.end()) > least &&
         increases.back() > 0.7 * increases.front();
}

void StressConvergence::mark(const Surface& surface, std::vector<int>& levels) const {
  if (error_ <= accuracy_) return;
  // The error of a stress falls with at least the first power of the area of the triangles.
  constexpr int most = 3;
  const int level = std::clamp(static_cast<int>(std::log2(error_ / accuracy_)), 1, most);
  constexpr double around = 2;  // in edge lengths
  const double reach = around * triangle_edge_length(surface, peak_.where.triangle);
  for (int t = 0; t < isize(levels); ++t)
    if ((surface.position({t, Vec3::Constant(1.0 / 3)}) - peak_.at).norm() <= reach)
      levels[static_cast<size_t>(t)] = std::max(levels[static_cast<size_t>(t)], level);
}

}  // namespace batten
