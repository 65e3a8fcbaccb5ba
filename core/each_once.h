// Lists of numbers in order.
#pragma once

#include <algorithm>
#include <vector>

namespace batten {

/// The numbers ascending, each once.
inline std::vector<int> each_once(std::vector<int> numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

}  // namespace batten
