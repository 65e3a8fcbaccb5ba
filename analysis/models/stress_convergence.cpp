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
  const auto exclude = [&](const Vec3& at, const Location& where) {
    const int first = first_.of(shell.layout(), where);
    const double thickness = shell.assembler().section(where.triangle).thickness;
    places_.push_back({at, std::max(edge_lengths_[static_cast<size_t>(first)], thickness)});
    values_.clear();
    return stresses.largest_outside(places_);
  };
  ShellStresses::Peak peak = result.max_stress;
  while (const auto point = singular_point_near(shell, load_case, places_, peak))
    peak = exclude(*point, peak.where);
  follow(peak);
  if (!grows_without_limit()) return;
  peak = exclude(peak.at, peak.where);
  while (const auto point = singular_point_near(shell, load_case, places_, peak))
    peak = exclude(*point, peak.where);
  follow(peak);
}

void StressConvergence::follow(const ShellStresses::Peak& peak) {
  peak_ = peak;
  values_.push_back(peak.value);
  error_ = 0;
  if (!(peak.value > 0)) return;
  error_ = peak.spread / peak.value;
  if (values_.size() > 1)
    error_ = std::max(error_, std::abs(peak.value - values_[values_.size() - 2]) / peak.value);
}

bool StressConvergence::grows_without_limit() const {
  constexpr size_t rounds = 3;
  constexpr double least = 0.02;
  if (values_.size() <= rounds) return false;
  std::vector<double> increases;
  for (size_t k = values_.size() - rounds; k < values_.size(); ++k)
    increases.push_back(values_[k] > 0 ? (values_[k] - values_[k - 1]) / values_[k] : 0);
  return *std::min_element(increases.begin(), increases.end()) > least &&
         increases.back() > 0.5 * increases.front();
}

void StressConvergence::mark(const Surface& surface, double accuracy,
                             std::vector<int>& levels) const {
  if (error_ <= accuracy) return;
  // The error of a stress falls with at least the first power of the area of the triangles.
  constexpr int most = 3;
  const int level = std::clamp(static_cast<int>(std::log2(error_ / accuracy)), 1, most);
  constexpr double around = 2;  // in edge lengths
  const double reach = around * triangle_edge_length(surface, peak_.where.triangle);
  for (int t = 0; t < isize(levels); ++t)
    if ((surface.position({t, Vec3::Constant(1.0 / 3)}) - peak_.at).norm() <= reach)
      levels[static_cast<size_t>(t)] = std::max(levels[static_cast<size_t>(t)], level);
}

}  // namespace batten
