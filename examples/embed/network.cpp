// SPDX-License-Identifier: MPL-2.0
// A curve network: the surface through four curves, evaluated and written to STEP.
#include <batten/batten.h>

#include <cstdio>

int main(int, char**) {
  const batten::Model model =
      batten::skin({{"front", {{0, 0, 0}, {500, 0, 80}, {1000, 0, 0}}},
                    {"right", {{1000, 0, 0}, {1000, 800, 0}}},
                    {"back", {{1000, 800, 0}, {500, 800, 120}, {0, 800, 0}}},
                    {"left", {{0, 800, 0}, {0, 0, 0}}}});
  const batten::SurfacePoint top = model.nearest({500, 400, 1000});
  std::printf("area %.1f mm², height %.3f mm, curvatures %.3g and %.3g 1/mm\n", model.area(),
              top.position.z(), top.k1, top.k2);
  for (const std::string& failed : model.save("panel.step")) std::printf("%s\n", failed.c_str());
  return model.failed_checks().empty() ? 0 : 1;
}
