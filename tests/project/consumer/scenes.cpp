// SPDX-License-Identifier: MPL-2.0
// The surface through four curves, written to STEP: all libraries together.
#include <batten/batten.h>

#include <cstdio>

int main() {
  const batten::Model model = batten::skin({{"front", {{0, 0, 0}, {1, 0, 0}}},
                                            {"right", {{1, 0, 0}, {1, 1, 0.2}}},
                                            {"back", {{1, 1, 0.2}, {0, 1, 0}}},
                                            {"left", {{0, 1, 0}, {0, 0, 0}}}});
  const auto failed = model.save("consumer.step");
  std::printf("area %.6f, %zu failed checks\n", model.area(), failed.size());
  return failed.empty() && batten::load("consumer.step").faces().size() == 1 ? 0 : 1;
}
