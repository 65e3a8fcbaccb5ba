// SPDX-License-Identifier: MPL-2.0
// Moves one end of a strip of triangles: the strip follows, and its fixed end stays.
#include <batten/mesh/deform/form_feature_deformer.h>

#include <cstdio>

int main() {
  using namespace batten;
  constexpr int n = 10;
  Points points(2 * (n + 1), 3);
  std::vector<std::array<int, 3>> triangles;
  for (int i = 0; i <= n; ++i) {
    points.row(2 * i) << i, 0, 0;
    points.row(2 * i + 1) << i, 1, 0;
    if (i == n) break;
    triangles.push_back({2 * i, 2 * i + 2, 2 * i + 1});
    triangles.push_back({2 * i + 1, 2 * i + 2, 2 * i + 3});
  }
  DeformProblem problem;
  problem.fixed = {0, 1};
  problem.handles = {{"end", {2 * n, 2 * n + 1}}};
  FormFeatureDeformer deformer(TriangleMesh(points, triangles), problem);
  DeformEdit edit;
  edit.handles.resize(1);
  edit.handles[0].translation = Vec3(0, 0, 2);
  deformer.deform(edit);
  const Points moved = deformer.positions();
  std::printf("end at z = %.12f, fixed end at z = %.1e\n", moved(2 * n, 2), moved(0, 2));
  return moved(2 * n, 2) == 2 && moved(0, 2) == 0 ? 0 : 1;
}
