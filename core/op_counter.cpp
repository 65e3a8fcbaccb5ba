#include "batten/core/op_counter.h"

namespace batten {

std::string ScopedOpCount::text() const {
  constexpr std::array<const char*, kOpCounterCount> words = {
      "analyses",       "factorizations",      "solves",     "assembled elements",
      "triangulations", "hole triangulations", "allocations"};
  std::string text;
  for (size_t k = 0; k < words.size(); ++k)
    text += (k ? ", " : "") + std::to_string(of(static_cast<OpCounter>(k))) + " " + words[k];
  return text;
}

}  // namespace batten
