// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/target/target_surface.h"

#include <algorithm>
#include <cmath>

#include "batten/core/containers.h"
#include "batten/core/parallel.h"
#include "batten/skinning/model/model_projector.h"

namespace batten {
namespace {

/// Barycentric coordinates with denominator 4: corners, edges and interior points of a triangle.
TriangleRule fifteen_points() {
  TriangleRule rule;
  rule.L.resize(15, 3);
  int row = 0;
  for (int i = 0; i <= 4; ++i)
    for (int j = 0; i + j <= 4; ++j) rule.L.row(row++) << i / 4.0, j / 4.0, (4 - i - j) / 4.0;
  rule.weights = VecX::Constant(15, 1.0 / 15);
  return rule;
}

/// True if an offset from a surface's point is not normal to the surface, as at boundaries.
bool leaves_sideways(const Vec3& offset, const Vec3& normal, double tolerance) {
  constexpr double most = 0.1;  // of the offset
  const double length = offset.norm();
  return length > tolerance && (offset - normal.dot(offset) * normal).norm() > most * length;
}

/// Accumulates distances in the given order.
class DistanceSum {
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
    result_.excluded += more.excluded;
    squares_ += more.rms * more.rms * more.points;
    if (more.largest > result_.largest) {
      result_.largest = more.largest;
      result_.where = more.where;
    }
  }
  void excluded() { ++result_.excluded; }
  Distances get() {
    result_.rms = result_.points > 0 ? std::sqrt(squares_ / result_.points) : 0;
    return result_;
  }

 private:
  Distances result_;
  double squares_ = 0;
};

class DistanceMeasurer {
 public:
  DistanceMeasurer(const ModelLayout& layout, const Points& dofs, const TargetSurface& target)
      : layout_(layout),
        surface_(layout.surface(dofs)),
        target_(target),
        tolerance_(1e-12 * layout.size()),
        points_(fifteen_points()) {}

  void regions(TargetDistances& result, VecX* largest_of) const {
    const int triangles = layout_.mesh()->triangle_count();
    std::vector<Distances> each(triangles);
    parallel_for_each<64>(triangles, [&](int t) { each[t] = of_triangle(t); });
    std::vector<DistanceSum> sums(layout_.region_count());
    for (int t = 0; t < triangles; ++t) sums[layout_.region_of(t)].add(each[t]);
    for (DistanceSum& sum : sums) result.regions.push_back(sum.get());
    if (!largest_of) return;
    largest_of->resize(triangles);
    for (int t = 0; t < triangles; ++t) (*largest_of)[t] = each[t].largest;
  }

  void lines(TargetDistances& result) const {
    constexpr int samples = 8;  // per segment
    for (const ModelLine& line : layout_.lines()) {
      const HermiteCurve& curve = layout_.curve(line.sides.front());
      const auto& breaks = curve.parameters();
      DistanceSum sum;
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
    DistanceSum sum;
    if (trim && trim->side(t) == Trim::Side::Outside) return sum.get();
    constexpr int degree = 4;
    const bool cut = trim && trim->side(t) == Trim::Side::Cut;
    const TriangleRule inside = cut ? trim->rule(t, degree) : TriangleRule();
    const TriangleRule& points = cut ? inside : points_;
    for (long i = 0; i < points.L.rows(); ++i) {
      const SurfaceJet jet = surface_.jet({t, points.L.row(i).transpose()});
      const auto there = target_.nearest(jet.x, Vec3::Zero());
      if (!there ||
          (there->at_boundary && leaves_sideways(there->at - jet.x, there->normal, tolerance_)))
        sum.excluded();
      else
        sum.add((there->at - jet.x).norm(), jet.x);
    }
    return sum.get();
  }

  const ModelLayout& layout_;
  const Surface surface_;
  const TargetSurface& target_;
  const double tolerance_;
  const TriangleRule points_;
};

}  // namespace

double TargetDistances::there() const {
  double result = 0;
  for (const Distances& region : regions) result = std::max(result, region.largest);
  return result;
}

double TargetDistances::largest() const { return std::max(there(), back.largest); }

std::vector<double> target_orientations(const ModelLayout& layout, const Points& dofs,
                                        const std::vector<const TargetSurface*>& targets) {
  const Surface surface = layout.surface(dofs);
  std::vector<double> oriented_areas(layout.mesh()->triangle_count(), 0.0);
  parallel_for_each<256>(isize(oriented_areas), [&](int t) {
    if (layout.trim() && layout.trim()->side(t) == Trim::Side::Outside) return;
    const SurfaceJet jet = surface.jet({t, Vec3::Constant(1.0 / 3)});
    if (const auto there = targets[layout.region_of(t)]->nearest(jet.x, Vec3::Zero()))
      oriented_areas[t] = there->normal.dot(jet.area_vector());
  });
  std::vector<double> sides(layout.region_count(), 0.0);
  for (int t = 0; t < isize(oriented_areas); ++t) sides[layout.region_of(t)] += oriented_areas[t];
  for (double& side : sides) side = side < 0 ? -1 : 1;
  return sides;
}

Distances distances_from_target(const ModelLayout& layout, const Points& dofs,
                                const TargetSurface& target, VecX* largest_of) {
  const auto samples = target.samples();
  const std::vector<double> sides = target_orientations(
      layout, dofs, std::vector<const TargetSurface*>(layout.region_count(), &target));
  const ModelProjector projector(layout, dofs);
  const double tolerance = 1e-12 * layout.size();
  constexpr double alike = 0.5;  // minimum cosine of the angle between the normals
  struct ClosestTriangle {
    double distance = 0;
    int triangle = -1;  // in the layout's mesh; -1: excluded
  };
  std::vector<ClosestTriangle> closest(samples.size());
  parallel_for_each<256>(isize(samples), [&](int i) {
    const Vec3& p = samples[i].at;
    const auto there = projector.nearest(p);
    const int region = there.at.region;
    const SurfaceJet jet = projector.surface(region).jet(there.where);
    if (there.inside && !leaves_sideways(p - jet.x, jet.normal(), tolerance) &&
        sides[region] * jet.normal().dot(samples[i].normal) >= alike)
      closest[i] = {there.distance, layout.first_triangle(region) + there.where.triangle};
  });
  DistanceSum sum;
  for (int i = 0; i < isize(closest); ++i) {
    const auto& [distance, triangle] = closest[i];
    if (triangle < 0) {
      sum.excluded();
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
  const DistanceMeasurer measuring(layout, dofs, target);
  measuring.regions(result, largest_of);
  measuring.lines(result);
  return result;
}

}  // namespace batten
