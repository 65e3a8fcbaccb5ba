#include "batten/core/work.h"

namespace batten {

std::string WorkCount::text() const {
  constexpr std::array<const char*, kinds_of_work> words = {
      "analyses",       "factorizations", "solves",     "assembled elements",
      "triangulations", "plain fillings", "allocations"};
  std::string text;
  for (size_t k = 0; k < words.size(); ++k)
    text += (k ? ", " : "") + std::to_string(of(static_cast<Work>(k))) + " " + words[k];
  return text;
}

}  // namespace batten
