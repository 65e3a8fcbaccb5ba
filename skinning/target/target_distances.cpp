#include "batten/skinning/target/target_distances.h"

#include <algorithm>
#include <cmath>

#include "batten/core/chunks.h"
#include "batten/core/index.h"
#include "batten/skinning/model/model_projector.h"

namespace batten {
namespace {

/// Barycentric coordinates with denominator 4: corners, edges and the inside of a triangle.
TriangleRule fifteen_points() {
  TriangleRule rule;
  rule.L.resize(15, 3);
  int row = 0;
  for (int i = 0; i <= 4; ++i)
    for (int j = 0; i + j <= 4; ++j) rule.L.row(row++) << i / 4.0, j / 4.0, (4 - i - j) / 4.0;
  rule.weights = VecX::Constant(15, 1.0 / 15);
  return rule;
}

/// Whether the way from a surface's point to another one leaves along the surface, as it does at rims.
bool leaves_sideways(const Vec3& way, const Vec3& normal, double hair) {
  constexpr double most = 0.1;  // of the way
  const double length = way.norm();
  return length > hair && (way - normal.dot(way) * normal).norm() > most * length;
}

/// Adds up distances in the order in which they are given.
class Sum {
 public:
  void add(double distance, const Vec3& at) {
    ++result_.points;
    squares_ += distance * distance;
    if (distance > result_.largest) {
      result_.largest = distance;
      result_.where = at;
    }
  }
  void add(const Distances& more) {
    result_.points += more.points;
    result_.beyond += more.beyond;
    squares_ += more.rms * more.rms * more.points;
    if (more.largest > result_.largest) {
      result_.largest = more.largest;
      result_.where = more.where;
    }
  }
  void beyond() { ++result_.beyond; }
  Distances get() {
    result_.rms = result_.points > 0 ? std::sqrt(squares_ / result_.points) : 0;
    return result_;
  }

 private:
  Distances result_;
  double squares_ = 0;
};

class Measuring {
 public:
  Measuring(const ModelLayout& layout, const Points& dofs, const TargetSurface& target)
      : layout_(layout),
        surface_(layout.surface(dofs)),
        target_(target),
        hair_(1e-12 * layout.size()),
        points_(fifteen_points()) {}

  void regions(TargetDistances& result, VecX* largest_of) const {
    const int triangles = layout_.mesh()->triangle_count();
    std::vector<Distances> each(triangles);
    for_each_in_chunks<64>(triangles, [&](int t) { each[t] = of_triangle(t); });
    std::vector<Sum> sums(layout_.region_count());
    for (int t = 0; t < triangles; ++t) sums[layout_.region_of(t)].add(each[t]);
    for (Sum& sum : sums) result.regions.push_back(sum.get());
    if (!largest_of) return;
    largest_of->resize(triangles);
    for (int t = 0; t < triangles; ++t) (*largest_of)[t] = each[t].largest;
  }

  void lines(TargetDistances& result) const {
    constexpr int samples = 8;  // of a segment
    for (const ModelLine& line : layout_.lines()) {
      const HermiteCurve& curve = layout_.curve(line.sides.front());
      const auto& breaks = curve.parameters();
      Sum sum;
      for (size_t s = 0; s + 1 < breaks.size(); ++s)
        for (int i = 0; i <= samples; ++i) {
          const Vec3 x = curve.evaluate(breaks[s] + (breaks[s + 1] - breaks[s]) * i / samples);
          if (const auto there = target_.nearest(x, Vec3::Zero()))
            sum.add((there->at - x).norm(), x);
        }
      result.lines.push_back(sum.get());
    }
  }

 private:
  Distances of_triangle(int t) const {
    const auto& trim = layout_.trim();
    Sum sum;
    if (trim && trim->side(t) == Trim::Side::Outside) return sum.get();
    constexpr int degree = 4;
    const bool cut = trim && trim->side(t) == Trim::Side::Cut;
    const TriangleRule inside = cut ? trim->rule(t, degree) : TriangleRule();
    const TriangleRule& points = cut ? inside : points_;
    for (long i = 0; i < points.L.rows(); ++i) {
      const SurfaceJet jet = surface_.jet({t, points.L.row(i).transpose()});
      const auto there = target_.nearest(jet.x, Vec3::Zero());
      if (!there || (there->at_rim && leaves_sideways(there->at - jet.x, there->normal, hair_)))
        sum.beyond();
      else
        sum.add((there->at - jet.x).norm(), jet.x);
    }
    return sum.get();
  }

  const ModelLayout& layout_;
  const Surface surface_;
  const TargetSurface& target_;
  const double hair_;
  const TriangleRule points_;
};

}  // namespace

double TargetDistances::there() const {
  double result = 0;
  for (const Distances& region : regions) result = std::max(result, region.largest);
  return result;
}

double TargetDistances::largest() const { return std::max(there(), back.largest); }

std::vector<double> target_sides(const ModelLayout& layout, const Points& dofs,
                                 const std::vector<const TargetSurface*>& targets) {
  const Surface surface = layout.surface(dofs);
  std::vector<double> shares(layout.mesh()->triangle_count(), 0.0);
  for_each_in_chunks<256>(count_of(shares), [&](int t) {
    if (layout.trim() && layout.trim()->side(t) == Trim::Side::Outside) return;
    const SurfaceJet jet = surface.jet({t, Vec3::Constant(1.0 / 3)});
    if (const auto there = targets[layout.region_of(t)]->nearest(jet.x, Vec3::Zero()))
      shares[t] = there->normal.dot(jet.area_vector());
  });
  std::vector<double> sides(layout.region_count(), 0.0);
  for (int t = 0; t < count_of(shares); ++t) sides[layout.region_of(t)] += shares[t];
  for (double& side : sides) side = side < 0 ? -1 : 1;
  return sides;
}

Distances way_back(const ModelLayout& layout, const Points& dofs, const TargetSurface& target,
                   VecX* largest_of) {
  const auto samples = target.samples();
  const std::vector<double> sides =
      target_sides(layout, dofs, std::vector<const TargetSurface*>(layout.region_count(), &target));
  const ModelProjector projector(layout, dofs);
  const double hair = 1e-12 * layout.size();
  constexpr double alike = 0.5;  // of the normals, a cosine
  struct Way {
    double distance = 0;
    int triangle = -1;  // of the layout's mesh; none: beyond
  };
  std::vector<Way> ways(samples.size());
  for_each_in_chunks<256>(count_of(samples), [&](int i) {
    const Vec3& p = samples[i].at;
    const auto there = projector.nearest(p);
    const int region = there.at.region;
    const SurfaceJet jet = projector.surface(region).jet(there.where);
    if (there.inside && !leaves_sideways(p - jet.x, jet.normal(), hair) &&
        sides[region] * jet.normal().dot(samples[i].normal) >= alike)
      ways[i] = {there.distance, layout.first_triangle(region) + there.where.triangle};
  });
  Sum sum;
  for (int i = 0; i < count_of(ways); ++i) {
    const auto& [distance, triangle] = ways[i];
    if (triangle < 0) {
      sum.beyond();
      continue;
    }
    sum.add(distance, samples[i].at);
    if (largest_of) (*largest_of)[triangle] = std::max((*largest_of)[triangle], distance);
  }
  return sum.get();
}

TargetDistances target_distances(const ModelLayout& layout, const Points& dofs,
                                 const TargetSurface& target, VecX* largest_of) {
  TargetDistances result;
  const Measuring measuring(layout, dofs, target);
  measuring.regions(result, largest_of);
  measuring.lines(result);
  return result;
}

}  // namespace batten
