// SPDX-License-Identifier: MPL-2.0
// Skins three straight curves: the result is the flat triangle.
#include <batten/fairing/curves/curve_through_points.h>
#include <batten/sculpting/session/sculpting_session.h>
#include <batten/skinning/region/skinned_region.h>

#include <cmath>
#include <cstdio>

int main() {
  using namespace batten;
  const std::vector<Vec3> corner = {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}};
  std::vector<CharacterLine> lines;
  for (int i = 0; i < 3; ++i)
    lines.push_back({"side " + std::to_string(i),
                     curve_through_points("side", {corner[i], corner[(i + 1) % 3]})});
  SkinOptions options;
  options.mesher = SkinOptions::Mesher::Fan;
  const RegionLayout layout("triangle", lines, options);
  const SculptResult result = sculpt(layout, {});
  const double area = measure(layout.region(result.dofs)).area;
  std::printf("area %.12f\n", area);
  return std::abs(area - 1) < 1e-9 ? 0 : 1;
}
