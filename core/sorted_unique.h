// Lists of numbers in order.
#pragma once

#include <algorithm>
#include <vector>

namespace batten {

/// The numbers ascending, each once.
inline std::vector<int> sorted_unique(std::vector<int> values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

}  // namespace batten
