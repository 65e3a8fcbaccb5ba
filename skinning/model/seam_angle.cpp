#include <cmath>
#include <limits>

#include "batten/core/words.h"
#include "batten/skinning/model/seam_side.h"

namespace batten {

SeamAngle seam_angle(const std::vector<const SkinnedRegion*>& regions, const Seam& seam,
                     const std::array<bool, 2>& open, int samples) {
  SeamSides sides(regions);
  const SeamSide side[2] = {sides(seam.sides[0]), sides(seam.sides[1])};
  const auto normal = [&](int s, double f) {
    const JoinSide& j = seam.sides[static_cast<size_t>(s)];
    const Vec3 n = regions[static_cast<size_t>(j.region)]->surface.jet(side[s].where(f)).normal();
    return Vec3(j.left ? n : -n);
  };
  std::vector<double> at = side[side[0].embedded() ? 1 : 0].stations();
  if (at.back() < 1) at.push_back(1);
  SeamAngle angle;
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
