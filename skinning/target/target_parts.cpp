#include "batten/skinning/target/target_parts.h"

#include <algorithm>
#include <limits>

#include "batten/core/isize.h"
#include "batten/core/parallel_chunks.h"

namespace batten {
namespace {

std::vector<std::vector<Vec3>> points_on_lines(const ModelLayout& layout) {
  constexpr int samples = 4;  // of a segment
  std::vector<std::vector<Vec3>> points(layout.region_count());
  for (const ModelLine& line : layout.lines()) {
    const HermiteCurve& curve = layout.curve(line.sides.front());
    const auto& breaks = curve.parameters();
    for (size_t s = 0; s + 1 < breaks.size(); ++s)
      for (int i = 0; i <= samples; ++i) {
        const Vec3 x = curve.evaluate(breaks[s] + (breaks[s + 1] - breaks[s]) * i / samples);
        for (const LineSide& side : line.sides) points[side.region].push_back(x);
      }
  }
  return points;
}

/// The largest distance of points from a part; infinite as soon as one is farther away than `near`.
double distance(const std::vector<Vec3>& points, const TargetSurface& part, double near) {
  double largest = 0;
  // From both ends, since lines of neighbours often have their beginning in common.
  for (size_t i = 0; i < points.size(); ++i) {
    const Vec3& p = points[i % 2 == 0 ? i / 2 : points.size() - 1 - i / 2];
    const auto there = part.nearest(p, Vec3::Zero());
    if (!there || !((there->at - p).norm() <= near)) return std::numeric_limits<double>::infinity();
    largest = std::max(largest, (there->at - p).norm());
  }
  return largest;
}

}  // namespace

std::vector<const TargetSurface*> target_parts_of_regions(
    const ModelLayout& layout, const std::vector<std::shared_ptr<const TargetSurface>>& parts,
    double near) {
  const auto points = points_on_lines(layout);
  struct Candidate {
    int part;
    double distance;
  };
  std::vector<std::vector<Candidate>> candidates(points.size());
  parallel_for_each<1>(isize(points), [&](int r) {
    for (int p = 0; p < isize(parts) && !points[r].empty(); ++p) {
      const double far = distance(points[r], *parts[p], near);
      if (far <= near) candidates[r].push_back({p, far});
    }
  });
  std::vector<int> order(points.size());
  for (int r = 0; r < isize(order); ++r) order[r] = r;
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return candidates[a].size() < candidates[b].size(); });
  std::vector<const TargetSurface*> result(points.size(), nullptr);
  std::vector<char> taken(parts.size(), 0);
  for (const int r : order) {
    const auto best = std::min_element(
        candidates[r].begin(), candidates[r].end(), [&](const Candidate& a, const Candidate& b) {
          return std::pair(taken[a.part], a.distance) < std::pair(taken[b.part], b.distance);
        });
    if (best == candidates[r].end()) continue;
    taken[best->part] = 1;
    result[r] = parts[best->part].get();
  }
  return result;
}

namespace {

/// The boundary of a region in space and in its domain, as short chords.
class BoundaryParametrization {
 public:
  explicit BoundaryParametrization(const SkinnedRegion& region) {
    constexpr int samples = 8;  // of a segment
    for (const auto& loop : region.boundary)
      for (const BoundarySegment& piece : loop) {
        const HermiteCurve pcurve = boundary_pcurve(region, piece),
                           curve = boundary_curve(region, piece);
        const auto& breaks = curve.parameters();
        for (size_t s = 0; s + 1 < breaks.size(); ++s)
          for (int i = 0; i < samples; ++i)
            add(pcurve, curve, breaks[s] + (breaks[s + 1] - breaks[s]) * i / samples,
                breaks[s] + (breaks[s + 1] - breaks[s]) * (i + 1) / samples);
      }
  }

  struct Found {
    Vec2 uv;
    double distance;
  };
  Found nearest(const Vec3& p) const {
    Found best{Vec2::Zero(), std::numeric_limits<double>::infinity()};
    for (const Chord& chord : chords_) {
      const Vec3 offset = chord.to - chord.from;
      const double along = std::clamp(
          (p - chord.from).dot(offset) / std::max(offset.squaredNorm(), 1e-300), 0.0, 1.0);
      const double distance = (chord.from + along * offset - p).norm();
      if (distance >= best.distance) continue;
      best = {chord.from_uv + along * (chord.to_uv - chord.from_uv), distance};
    }
    return best;
  }

 private:
  struct Chord {
    Vec3 from, to;
    Vec2 from_uv, to_uv;
  };
  void add(const HermiteCurve& pcurve, const HermiteCurve& curve, double t, double next) {
    chords_.push_back({curve.evaluate(t), curve.evaluate(next), pcurve.evaluate(t).head<2>(),
                       pcurve.evaluate(next).head<2>()});
  }
  std::vector<Chord> chords_;
};

}  // namespace

std::vector<TargetSurface::Parametrization> parametrizations_of_regions(
    const ModelLayout& layout, const Points& dofs, const std::vector<const TargetSurface*>& parts,
    double near) {
  std::vector<TargetSurface::Parametrization> parametrizations(parts.size());
  parallel_for_each<1>(isize(parts), [&](int r) {
    if (!parts[r] || layout.region(r).mesh()->period() > 0) return;
    const BoundaryParametrization boundary(layout.skinned(r, dofs));
    double farthest = 0;
    auto map = parts[r]->parametrize([&](const Vec3& x) {
      const auto found = boundary.nearest(x);
      farthest = std::max(farthest, found.distance);
      return found.uv;
    });
    if (farthest <= near) parametrizations[r] = std::move(map);
  });
  return parametrizations;
}

}  // namespace batten
