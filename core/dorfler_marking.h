// The few large among many values.
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

namespace batten {

/// Indices of the largest values, the largest first, that make at least this share of the sum
/// together; equal ones in their order. Values are 0 or above; without a sum above 0 there are none.
template <class Values>
std::vector<int> dorfler_marking(const Values& values, double fraction) {
  std::vector<int> order(static_cast<size_t>(values.size()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return values[a] > values[b]; });
  double sum = 0, taken = 0;
  for (const double value : values) sum += value;
  size_t count = 0;
  while (count < order.size() && taken < fraction * sum) taken += values[order[count++]];
  order.resize(count);
  return order;
}

}  // namespace batten
