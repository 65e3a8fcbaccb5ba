#include "batten/fairing/wave_ease.h"

#include <algorithm>
#include <cmath>

#include "batten/core/index.h"
#include "batten/core/words.h"

namespace batten {
namespace {

// Unit tangents inside of segments, so never at a corner, in the order of u.
struct Tangents {
  std::vector<double> u;
  std::vector<Vec3> t;

  explicit Tangents(const HermiteCurve& curve) {
    constexpr int least = 64;
    const int segments = curve.segment_count(), each = 1 + (least - 1) / segments;
    for (int s = 0; s < segments; ++s)
      for (int k = 0; k < each; ++k) {
        const double f = (k + 0.5) / each;
        u.push_back(curve.parameters()[static_cast<size_t>(s)] + f * curve.mesh().length(s));
        t.push_back(curve.evaluate(CurveMesh::Where{s, f}, 1).normalized());
      }
  }
  // Of a closed curve without corners: once more before and after.
  void repeat(double length) {
    const std::vector<double> own = u;
    const std::vector<Vec3> tangents = t;
    u.clear();
    t.clear();
    for (const double shift : {-length, 0.0, length})
      for (size_t i = 0; i < own.size(); ++i) {
        u.push_back(own[i] + shift);
        t.push_back(tangents[i]);
      }
  }
};

// The turn from one tangent to another over the way between, by halves, so that half a circle is
// not taken for none.
double bend(const Tangents& tangents, size_t from, size_t to) {
  const double way = tangents.u[to] - tangents.u[from];
  const size_t middle = (from + to) / 2;
  return way > 0 ? (degrees_between(tangents.t[from], tangents.t[middle]) +
                    degrees_between(tangents.t[middle], tangents.t[to])) /
                       way
                 : 0;
}

}  // namespace

WaveEase::WaveEase(const HermiteCurve& curve, double wave, const WaveEase& before) {
  Tangents tangents(curve);
  u_ = tangents.u;
  const double length = curve.end() - curve.start();
  std::vector<double> stops = {-INFINITY};  // windows end there
  for (const int corner : curve.mesh().corners())
    stops.push_back(curve.parameters()[static_cast<size_t>(corner)]);
  stops.push_back(INFINITY);
  if (curve.closed() && stops.size() == 2) tangents.repeat(length);
  const auto first_from = [&](double u) {
    return std::lower_bound(tangents.u.begin(), tangents.u.end(), u) - tangents.u.begin();
  };
  double sum = 0;
  for (const double u : u_) {
    const double reach = 0.25 * wave * before.at((u - curve.start()) / length);
    const auto stop = std::upper_bound(stops.begin(), stops.end(), u);
    // A turn takes a few tangents.
    constexpr long fewest = 1;
    const long here = first_from(u);
    const long from = std::max(std::min(first_from(u - reach), here - fewest),
                               static_cast<long>(first_from(*(stop - 1))));
    const long to = std::min(std::max(first_from(u + reach) - 1, here + fewest),
                             static_cast<long>(first_from(*stop)) - 1);
    ease_.push_back(to > from ? bend(tangents, static_cast<size_t>(from), static_cast<size_t>(to))
                              : 0);
  }
  for (size_t i = 0; i < u_.size(); ++i) {
    const double a = i > 0 ? u_[i - 1] : curve.start();
    const double b = i + 1 < u_.size() ? u_[i + 1] : curve.end();
    sum += ease_[i] * (b - a) / 2;
  }
  const double mean = sum / length;
  constexpr double usual = 1.2;  // what noise makes of an even curve
  for (double& e : ease_) e = mean > 0 ? std::pow(std::max(1.0, e / (usual * mean)), -5 / 12.0) : 1;
  if (std::all_of(ease_.begin(), ease_.end(), [](double e) { return e == 1; })) ease_.clear();
  for (double& u : u_) u = (u - curve.start()) / length;
}

double WaveEase::at(double share) const {
  if (ease_.empty()) return 1;
  const auto above = std::upper_bound(u_.begin(), u_.end(), share);
  if (above == u_.begin()) return ease_.front();
  if (above == u_.end()) return ease_.back();
  const auto i = static_cast<size_t>(above - u_.begin());
  return ease_[i - 1] + (share - u_[i - 1]) / (u_[i] - u_[i - 1]) * (ease_[i] - ease_[i - 1]);
}

std::vector<double> WaveEase::of(const CurveMesh& mesh) const {
  std::vector<double> ease;
  if (even()) return ease;
  const double length = mesh.end() - mesh.start();
  for (const double u : mesh.parameters()) ease.push_back(at((u - mesh.start()) / length));
  // A closed curve goes on where it begins.
  if (mesh.closed()) ease.front() = ease.back() = (ease.front() + ease.back()) / 2;
  return ease;
}

}  // namespace batten
