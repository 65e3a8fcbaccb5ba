#include "batten/skinning/lines/line_samples.h"

#include <algorithm>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"

namespace batten {

CurveSamples sample_line(const CharacterLine& line, double corner_angle) {
  const InputCurve& curve = *line.curve;
  const auto segments = split_at_corners({line.name, line.curve}, std::min(corner_angle, 179.9));
  std::vector<ArcLength> arcs;
  double total = 0;
  for (const SmoothSegment& s : segments) {
    arcs.emplace_back(s.curve);
    total += arcs.back().total();
  }
  CurveSamples result;
  result.name = line.name;
  result.corners.emplace();
  constexpr int finer = 4;
  for (size_t k = 0; k < segments.size(); ++k) {
    const InputCurve& part = *segments[k].curve;
    const int spans = isize(part.breaks()) - 1;
    const int count = std::max({8, 8 * spans, static_cast<int>(200 * arcs[k].total() / total)});
    if (k > 0) result.corners->push_back(isize(result.points));
    for (int i = 0; i < finer * count; ++i) {
      const double s = arcs[k].total() * i / (finer * count);
      const Vec3 p = part.evaluate(i == 0 ? part.start() : arcs[k].parameter(s));
      (i % finer == 0 ? result.points : result.extra_points).push_back(p);
    }
  }
  result.points.push_back(curve.evaluate(curve.end()));
  result.closed = (result.points.back() - result.points.front()).norm() <= 1e-9 * total;
  if (*result.closed) {
    result.points.back() = result.points.front();
    const double turn =
        degrees_between(curve.evaluate(curve.end(), 1), curve.evaluate(curve.start(), 1));
    if (turn > corner_angle) result.corners->insert(result.corners->begin(), 0);
  }
  return result;
}

}  // namespace batten
