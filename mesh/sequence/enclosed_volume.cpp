#include "batten/mesh/sequence/enclosed_volume.h"

namespace batten {
namespace {

Vec3 at(const RowPoints& p, int v) { return p.row(v).transpose(); }

}  // namespace

double enclosed_volume(const std::vector<std::array<int, 3>>& triangles, const RowPoints& p) {
  if (triangles.empty()) return 0;
  const Vec3 from = at(p, triangles.front()[0]);  // far from the origin digits would be lost
  double sum = 0;
  for (const auto& t : triangles)
    sum += (at(p, t[0]) - from).dot((at(p, t[1]) - from).cross(at(p, t[2]) - from));
  return sum / 6;
}

void volume_gradient(const std::vector<std::array<int, 3>>& triangles, const RowPoints& p,
                     RowPoints& gradient) {
  gradient.setZero(p.rows(), 3);
  for (const auto& t : triangles) {
    // A third of the area vector: the sum over a closed fan does not depend on the origin.
    const Vec3 contribution = (at(p, t[1]) - at(p, t[0])).cross(at(p, t[2]) - at(p, t[0])) / 6;
    for (const int v : t) gradient.row(v) += contribution.transpose();
  }
}

}  // namespace batten
