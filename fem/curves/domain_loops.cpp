// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/curves/domain_loops.h"

#include <algorithm>
#include <numeric>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"

namespace batten {

std::vector<PlanarCubic> planar_cubics(const HermiteCurve& curve) {
  std::vector<PlanarCubic> segments;
  for (int s = 0; s < curve.segment_count(); ++s) {
    const auto [p, a, b, q] = curve.bezier(s).b;
    segments.push_back({{drop_z(p), drop_z(a), drop_z(b), drop_z(q)}});
  }
  return segments;
}

DomainLoops::DomainLoops(std::vector<Loop> loops, Background background)
    : background_(background), loops_(std::move(loops)) {
  std::vector<size_t> first;
  for (const Loop& loop : loops_) {
    if (loop.empty()) throw InputError("a loop of the domain has no curves");
    first.push_back(segments_.size());
    for (const HermiteCurve& curve : loop) {
      if (!curve.dofs().col(2).isZero(0))
        throw InputError("a loop of the domain leaves the plane z = 0");
      for (const PlanarCubic& segment : planar_cubics(curve)) segments_.push_back(segment);
    }
  }
  for (const PlanarCubic& segment : segments_)
    for (const Vec2& p : segment.b) box_.extend(p);
  if (segments_.empty()) box_.extend(Vec2::Zero());
  first.push_back(segments_.size());
  const double size = box_.diagonal().norm();
  for (size_t l = 0; l < loops_.size(); ++l)
    for (size_t a = first[l]; a < first[l + 1]; ++a) {
      PlanarCubic& next = segments_[a + 1 < first[l + 1] ? a + 1 : first[l]];
      if (!((next.b[0] - segments_[a].b[3]).norm() <= 1e-9 * size))
        throw InputError("a loop of the domain is open at (" +
                         format_number(segments_[a].b[3].x()) + ", " +
                         format_number(segments_[a].b[3].y()) + ")");
      next.b[0] = segments_[a].b[3];  // exactly equal, so that a ray cannot pass between the arcs
    }
  for (size_t a = 0; a < segments_.size(); ++a) {
    const PlanarCubic& segment = segments_[a];
    const auto v = BernsteinCubic::coordinate(segment, 1);
    // Short parts have small boxes, so that few points need an evaluation of the cubic.
    constexpr int cuts = 8;
    std::vector<double> t{0};
    const auto parts = v.monotone_parts();
    for (size_t i = 0; i + 1 < parts.size(); ++i)
      for (int k = 1; k <= cuts; ++k)
        t.push_back(k == cuts ? parts[i + 1] : parts[i] + (parts[i + 1] - parts[i]) * k / cuts);
    double before = segment.b[0].y();
    for (size_t i = 0; i + 1 < t.size(); ++i) {
      const double after = i + 2 == t.size() ? segment.b[3].y() : v.at(t[i + 1]);
      const Box2 box = bounding_box(segment.part(t[i], t[i + 1]).b);
      if (before != after)
        monotone_.push_back(
            {static_cast<int>(a), t[i], t[i + 1], before, after, box.min().x(), box.max().x()});
      before = after;
    }
  }
  sort_into_bands();
}

void DomainLoops::sort_into_bands() {
  bands_.assign(monotone_.size() + 2, 0);
  const auto each = [&](const auto& visit) {
    for (size_t k = 0; k < monotone_.size(); ++k) {
      const auto [low, high] = std::minmax(monotone_[k].v0, monotone_[k].v1);
      for (size_t b = band(low); b <= band(high); ++b) visit(b, static_cast<int>(k));
    }
  };
  each([&](size_t b, int) { ++bands_[b + 1]; });
  std::partial_sum(bands_.begin(), bands_.end(), bands_.begin());
  in_bands_.resize(bands_.back());
  std::vector<size_t> next = bands_;
  each([&](size_t b, int part) { in_bands_[next[b]++] = part; });
}

size_t DomainLoops::band(double v) const {
  const auto count = static_cast<double>(bands_.size() - 1);
  const double height = box_.max().y() - box_.min().y();
  const double node = (v - box_.min().y()) / height * count;
  return node > 0 ? static_cast<size_t>(std::min(node, count - 1)) : 0;
}

bool DomainLoops::contains(const Vec2& p) const {
  int winding = background_ == Background::Inside ? 1 : 0;
  const size_t band = this->band(p.y());
  for (size_t k = bands_[band]; k < bands_[band + 1]; ++k) {
    const Monotone& m = monotone_[static_cast<size_t>(in_bands_[k])];
    if ((m.v0 > p.y()) == (m.v1 > p.y()) || p.x() > m.u_high) continue;
    if (p.x() >= m.u_low) {
      const PlanarCubic& segment = segments_[m.segment];
      const auto v = BernsteinCubic::coordinate(segment, 1, p.y());
      if (segment.at(v.zero(m.t0, m.t1)).x() <= p.x()) continue;
    }
    winding += m.v1 > m.v0 ? 1 : -1;
  }
  return winding > 0;
}

double DomainLoops::area() const {
  // ½ ∮ (u dv - v du), of degree 5 in t.
  constexpr double node = 0.7745966692414834;
  double twice = 0;
  for (const PlanarCubic& segment : segments_)
    for (const auto& [t, w] :
         {std::pair{0.5 * (1 - node), 5.0 / 18}, {0.5, 8.0 / 18}, {0.5 * (1 + node), 5.0 / 18}}) {
      const Vec2 c = segment.at(t), d = segment.slope(t);
      twice += w * (c.x() * d.y() - c.y() * d.x());
    }
  return 0.5 * twice;
}

}  // namespace batten
