#include "batten/apps/commands/lines/sampled_line.h"

#include <algorithm>

#include "batten/core/index.h"
#include "batten/core/words.h"
#include "batten/fairing/arc_length.h"
#include "batten/skinning/lines/line_fit.h"

namespace batten {

bool SampledLine::has_length() const {
  return std::any_of(points.begin(), points.end(),
                     [&](const Vec3& p) { return p != points.front(); });
}

SampledLine sampled(const SourceLine& line, double corner_angle) {
  if (!line.curve) return {line.points, {}, {}, {}};
  const InputCurve& curve = *line.curve;
  const auto stretches = cut_at_corners({line.name, line.curve}, std::min(corner_angle, 179.9));
  std::vector<ArcLength> arcs;
  double total = 0;
  for (const Stretch& s : stretches) {
    arcs.emplace_back(s.curve);
    total += arcs.back().total();
  }
  SampledLine result;
  result.corners.emplace();
  constexpr int finer = 4;
  for (size_t k = 0; k < stretches.size(); ++k) {
    const InputCurve& part = *stretches[k].curve;
    const int spans = count_of(part.breaks()) - 1;
    const int count = std::max({8, 8 * spans, static_cast<int>(200 * arcs[k].total() / total)});
    if (k > 0) result.corners->push_back(count_of(result.points));
    for (int i = 0; i < finer * count; ++i) {
      const double s = arcs[k].total() * i / (finer * count);
      const Vec3 p = part.evaluate(i == 0 ? part.start() : arcs[k].parameter(s));
      (i % finer == 0 ? result.points : result.between).push_back(p);
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

std::vector<double> nearest_in_order(const HermiteCurve& curve, const std::vector<Vec3>& points,
                                     const std::vector<double>& given) {
  std::vector<double> guess = given, result;
  // The last point of a closed list may be its first one again, at parameter 0.
  for (size_t i = 1; i < guess.size() && curve.closed(); ++i)
    while (guess[i] < guess[i - 1] - (curve.end() - curve.start()) / 2)
      guess[i] += curve.end() - curve.start();
  const double low = curve.start(), high = curve.end();
  const double least = 1e-3 * (high - low);
  for (size_t i = 0; i < points.size(); ++i) {
    const double before = i > 0 ? guess[i] - guess[i - 1] : 0;
    const double after = i + 1 < points.size() ? guess[i + 1] - guess[i] : 0;
    const double reach = 2 * std::max({before, after, least});
    std::vector<double> tries;
    constexpr int steps = 4;
    for (int k = -steps; k <= steps; ++k) tries.push_back(guess[i] + reach * k / steps);
    for (const int corner : curve.mesh().corners()) {
      const double u = curve.parameters()[corner];
      if (u > tries.front() && u < tries.back()) tries.push_back(u);
    }
    if (!curve.closed())
      for (double& u : tries) u = std::clamp(u, low, high);
    std::sort(tries.begin(), tries.end());
    tries.erase(std::unique(tries.begin(), tries.end()), tries.end());
    const double u = closest_on_curve([&](double t, int order) { return curve.evaluate(t, order); },
                                      tries, points[i])
                         .u;
    result.push_back(i > 0 ? std::max(u, result.back()) : u);
  }
  return result;
}

}  // namespace batten
