// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/surfaces/normal_side.h"

#include <array>
#include <cmath>
#include <map>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/skinning/model/join.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {
namespace {

constexpr std::array<int, 3> kAxes{2, 0, 1};  // z first

// Integrals over one surface without its creases. The normal is interpolated linearly between the
// corners of an element, so that bending inside large elements is included:
//
//     ∫ div n dA = Σ over edges of  ½ (n_a + n_b) · (x_b - x_a) × N,     N: facet normal.
SideIntegrals of_region(const SkinnedRegion& region) {
  const Surface& surface = region.surface;
  const Trim* trim = surface.trim().get();
  SideIntegrals sum;
  for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
    poll_every<2048>(t);
    if (trim && trim->side(t) == Trim::Side::Outside) continue;
    std::array<Vec3, 3> x, n;
    for (int k = 0; k < 3; ++k) {
      const Location corner{t, Vec3::Unit(k)};
      x[k] = surface.position(corner);
      n[k] = surface.area_vector(corner);
    }
    const Vec3 area = 0.5 * (x[1] - x[0]).cross(x[2] - x[0]);
    if (!(area.norm() > 0) || !area.allFinite()) continue;
    const Vec3 flat = area.normalized();
    for (Vec3& normal : n) {
      const double length = normal.norm();
      // The normal is undefined where two sides meet in one tangent: use the facet normal.
      normal = length > 0 && std::isfinite(length) && normal.dot(flat) > 0 ? Vec3(normal / length)
                                                                           : flat;
    }
    sum.add_facet(x[0], x[1], x[2]);
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      sum.curvature += 0.25 * (n[k] + n[next]).dot((x[next] - x[k]).cross(flat));
    }
  }
  return sum;
}

// Half of the integral of the angle between the normals along shared lines.
double of_creases(const std::vector<const SkinnedRegion*>& regions) {
  std::map<std::string, std::vector<JoinSide>> sides;
  for (int r = 0; r < isize(regions); ++r)
    for (const auto& loop : regions[r]->boundary)
      for (const BoundarySegment& piece : loop) {
        const bool embedded = piece.kind == BoundarySegment::Kind::Embedded;
        const auto i = static_cast<size_t>(piece.index);
        const std::string& name =
            (embedded ? regions[r]->embedded[i].line : regions[r]->edge_aligned[i].line).name;
        if (const auto side = side_of(*regions[r], r, name)) sides[name].push_back(*side);
      }
  std::vector<JoinLine> lines;
  for (const auto& [name, two] : sides)
    if (two.size() == 2 && two[0].left != two[1].left) lines.push_back({name, {two[0], two[1]}});
  std::vector<double> turns(lines.size(), 0);
  parallel_for(isize(lines), [&](int l) {
    constexpr int kSamples = 2;  // per edge
    turns[l] = measure_join(regions, lines[l], {}, kSamples).convexity;
  });
  double sum = 0;
  for (const double turn : turns)
    if (std::isfinite(turn)) sum += 0.5 * turn;
  return sum;
}

}  // namespace

void SideIntegrals::add_facet(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 vector = 0.5 * (b - a).cross(c - a), middle = (a + b + c) / 3;
  const double size = vector.norm();
  area += size;
  area_vector += vector;
  first += size * middle;
  moments += middle * vector.transpose();
}

void SideIntegrals::add(const SideIntegrals& other, bool turn) {
  const double sign = turn ? -1 : 1;
  area += other.area;
  first += other.first;
  curvature += sign * other.curvature;
  area_vector += sign * other.area_vector;
  moments += sign * other.moments;
}

Eigen::Matrix3d SideIntegrals::central_moments() const {
  return area > 0 ? Eigen::Matrix3d(moments - first / area * area_vector.transpose()) : moments;
}

NormalSide normal_side(const SideIntegrals& integrals, bool closed) {
  // Relative to √A, A and A^1.5. Smaller values would not be stable if the surface were drawn
  // again.
  constexpr double kMinCurvature = 1e-2, kMinVector = 0.05, kMinMoment = 1e-3;
  NormalSide side;
  if (!(integrals.area > 0)) return side;
  const double A = integrals.area;
  side.mean = integrals.area_vector / A;
  const auto decided = [&](NormalSide::Rule rule, double value, double least) {
    if (!(std::abs(value) > least)) return false;
    side.rule = rule;
    side.agrees = value > 0;
    return true;
  };
  using Rule = NormalSide::Rule;
  const Eigen::Matrix3d moments = integrals.central_moments();
  const double moment = kMinMoment * std::pow(A, 1.5);
  constexpr double kMinVolume = 1e-6;
  if (closed && decided(Rule::Volume, moments.trace() / 3, kMinVolume * std::pow(A, 1.5)))
    return side;
  if (decided(Rule::Curvature, integrals.curvature, kMinCurvature * std::sqrt(A))) return side;
  for (const int axis : kAxes)
    if (decided(Rule::Axis, integrals.area_vector[axis], kMinVector * A)) return side;
  if (decided(Rule::Moment, moments.trace(), moment)) return side;
  for (const int i : kAxes)
    for (const int j : kAxes)
      if (decided(Rule::Moment, moments(i, j), moment)) return side;
  return side;
}

std::string NormalSide::text() const {
  if (rule == Rule::Volume) return agrees ? "outwards" : "inwards";
  if (rule == Rule::Curvature) return agrees ? "to the convex side" : "to the concave side";
  constexpr double kClear = 0.95;
  if (rule != Rule::Axis) return "to one of two equivalent sides";
  const Vec3 n = mean.normalized();
  for (int i = 0; i < 3; ++i)
    if (std::abs(n[i]) > kClear)
      return (n[i] > 0 ? "along +" : "along -") + std::string(1, "xyz"[i]);
  return "along " + format_point(((n * 100).array().round() / 100 + 0.0).matrix());
}

SideIntegrals side_integrals(const std::vector<const SkinnedRegion*>& regions) {
  std::vector<SideIntegrals> parts(regions.size());
  parallel_for(isize(regions), [&](int r) { parts[r] = of_region(*regions[r]); });
  SideIntegrals sum;
  for (const SideIntegrals& part : parts) sum.add(part);
  sum.curvature += of_creases(regions);
  return sum;
}

}  // namespace batten
