#include "batten/fairing/bending_ease.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "batten/core/words.h"

namespace batten {

BendingEase::BendingEase(const HermiteCurve& curve, double wave, const BendingEase& before) {
  constexpr int each = 4, least = 200, most = 8000;
  const int count = std::clamp(each * curve.segment_count(), least, most);
  const double start = curve.start(), length = curve.end() - start;
  std::vector<double> stops;  // the window ends there
  if (!curve.closed()) stops = {start, curve.end()};
  for (const int corner : curve.mesh().corners())
    stops.push_back(curve.parameters()[static_cast<size_t>(corner)]);
  std::sort(stops.begin(), stops.end());
  std::vector<double> bend(static_cast<size_t>(count) + 1);
  for (int i = 0; i <= count; ++i) {
    const double u = start + length * i / count;
    const double reach = 0.25 * wave * std::pow(before.at(static_cast<double>(i) / count), 0.25);
    double from = u - reach, to = u + reach;
    for (const double stop : stops) {
      if (stop <= u) from = std::max(from, stop);
      if (stop >= u) to = std::min(to, stop);
    }
    const double window = to - from, hair = 1e-9 * length;
    if (!(window > 4 * hair)) continue;
    // Turns add up in halves, so that half a circle is not taken for none.
    const Vec3 a = curve.evaluate(from + hair, 1), b = curve.evaluate(0.5 * (from + to), 1),
               c = curve.evaluate(to - hair, 1);
    bend[static_cast<size_t>(i)] = (degrees_between(a, b) + degrees_between(b, c)) / window;
  }
  const double mean =
      std::accumulate(bend.begin(), bend.end(), 0.0) / static_cast<double>(bend.size());
  if (!(mean > 0)) return;
  constexpr double usual = 2;  // what noise alone makes of an even curve
  for (double& k : bend) k = std::pow(std::max(1.0, k / (usual * mean)), -1.5);
  ease_ = std::move(bend);
}

double BendingEase::at(double share) const {
  if (ease_.empty()) return 1;
  const double x = std::clamp(share, 0.0, 1.0) * static_cast<double>(ease_.size() - 1);
  const size_t i = std::min(static_cast<size_t>(x), ease_.size() - 2);
  return ease_[i] + (x - static_cast<double>(i)) * (ease_[i + 1] - ease_[i]);
}

std::vector<HermiteSegment::Linear> BendingEase::of(const CurveMesh& mesh) const {
  std::vector<HermiteSegment::Linear> ease;
  if (even()) return ease;
  const double length = mesh.end() - mesh.start();
  const auto at_node = [&](int i) {
    return at((mesh.parameters()[static_cast<size_t>(i)] - mesh.start()) / length);
  };
  for (int s = 0; s < mesh.segment_count(); ++s) ease.push_back({at_node(s), at_node(s + 1)});
  return ease;
}

}  // namespace batten
