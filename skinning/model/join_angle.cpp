#include <cmath>
#include <limits>

#include "batten/core/words.h"
#include "batten/skinning/model/join_edge.h"

namespace batten {

JoinAngle join_angle(const std::vector<const SkinnedRegion*>& regions, const JoinLine& join_line,
                     const std::array<bool, 2>& open, int samples) {
  JoinEdges sides(regions);
  const JoinEdge side[2] = {sides(join_line.sides[0]), sides(join_line.sides[1])};
  const auto normal = [&](int s, double f) {
    const JoinSide& j = join_line.sides[s];
    const Vec3 n = regions[j.region]->surface.jet(side[s].where(f)).normal();
    return Vec3(j.left ? n : -n);
  };
  std::vector<double> at = side[side[0].embedded() ? 1 : 0].stations();
  if (at.back() < 1) at.push_back(1);
  JoinAngle angle;
  double sum = 0;
  long count = 0;
  const size_t edges = at.size() - 1;
  for (size_t k = 0; k < edges; ++k)
    for (int j = 0; j <= samples; ++j) {
      const double f = share(at[k], at[k + 1], static_cast<double>(j) / samples);
      // Seen along the line, one side is to its left and the other to its right: their normals
      // agree where they point to the same side of the surface.
      const Vec3 na = normal(0, f), nb = -normal(1, f);
      const double deg = na.isZero() || nb.isZero() ? std::numeric_limits<double>::quiet_NaN()
                                                    : degrees_between(na, nb);
      const auto raise = [deg](double& most) {
        if (!(deg <= most) && !std::isnan(most)) most = deg;
      };
      raise(angle.max_deg);
      if (!(open[0] && k == 0) && !(open[1] && k + 1 == edges)) raise(angle.max_inside_deg);
      if (k == 0 && j == 0) angle.end_deg[0] = deg;
      if (k + 1 == edges && j == samples) angle.end_deg[1] = deg;
      sum += deg;
      ++count;
    }
  angle.mean_deg = count ? sum / static_cast<double>(count) : 0;
  return angle;
}

}  // namespace batten
