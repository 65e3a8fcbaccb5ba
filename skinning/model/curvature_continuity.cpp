#include "batten/skinning/model/curvature_continuity.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "batten/elements/quadrature.h"
#include "batten/skinning/model/join_edge.h"

namespace batten {
namespace {

// A line that leaves an end of a join line: its unit tangent there, its curvature vector and chord.
struct CrossingLine {
  Vec3 direction, curvature;
  double length;
};

// The slopes of a run at its start or end, away from there.
CrossingLine crossing_line(const EdgeAlignedLine& aligned_line, bool at_end) {
  const double p = at_end ? aligned_line.parameters.back() : aligned_line.parameters.front();
  const Vec3 d1 = (at_end ? -1 : 1) * aligned_line.fitted.evaluate(p, 1),
             d2 = aligned_line.fitted.evaluate(p, 2);
  const Vec3 direction = d1.normalized();
  const Vec3 chord = aligned_line.fitted.evaluate(aligned_line.parameters.back()) -
                     aligned_line.fitted.evaluate(aligned_line.parameters.front());
  return {direction, (d2 - d2.dot(direction) * direction) / d1.squaredNorm(), chord.norm()};
}

// All lines of a side's region that leave an end of it, but for itself.
std::vector<CrossingLine> crossing_lines(const ModelLayout& layout, const JoinSide& side,
                                         bool at_end) {
  const auto& edge_aligned = layout.region(side.region).edge_aligned();
  const EdgeAlignedLine& own = edge_aligned[static_cast<size_t>(side.line)];
  const int v = at_end ? own.vertices.back() : own.vertices.front();
  std::vector<CrossingLine> all;
  for (const EdgeAlignedLine& aligned_line : edge_aligned) {
    if (&aligned_line == &own || aligned_line.fitted.closed()) continue;
    if (aligned_line.vertices.front() == v) all.push_back(crossing_line(aligned_line, false));
    if (aligned_line.vertices.back() == v) all.push_back(crossing_line(aligned_line, true));
  }
  return all;
}

}  // namespace

bool is_curvature_continuous(const ModelLayout& layout, const JoinPlan& plan) {
  if (plan.rejected()) return false;
  const JoinLine& line = plan.join_line;
  if (line.curvature) return *line.curvature;
  if (line.sides[0].embedded || line.sides[1].embedded) return true;
  constexpr double kStraightCosine = -0.9, kMinCrossingSine = 0.3;  // cosine; sine
  constexpr double kMinTurningAngle = 0.2;                          // radians
  double jump = 0, most = 0;
  for (const bool at_end : {false, true}) {
    const auto& aligned_line =
        layout.region(line.sides[0].region).edge_aligned()[line.sides[0].line];
    const Vec3 along = crossing_line(aligned_line, at_end).direction;
    for (const CrossingLine& a : crossing_lines(layout, line.sides[0], at_end))
      for (const CrossingLine& b : crossing_lines(layout, line.sides[1], at_end)) {
        const Vec3 normal = along.cross(a.direction);
        if (a.direction.dot(b.direction) > kStraightCosine || normal.norm() < kMinCrossingSine)
          continue;
        const double first = a.curvature.dot(normal.normalized()),
                     second = b.curvature.dot(normal.normalized());
        most += std::max(std::abs(first), std::abs(second));
        // Over the shorter line they turn by nearly the same.
        if (std::abs(first - second) * std::min(a.length, b.length) < kMinTurningAngle) continue;
        jump += std::abs(first - second);
      }
  }
  return jump <= 0.5 * most;
}

std::vector<JoinPoint> curvature_join_points(const ModelLayout& layout) {
  std::vector<const RegionLayout*> regions;
  for (int r = 0; r < layout.region_count(); ++r) regions.push_back(&layout.region(r));
  JoinEdgeFactory edges(regions);
  const SegmentRule gauss = gauss_legendre(2);
  std::vector<JoinPoint> points;
  for (const JoinPlan& plan : layout.join_plans()) {
    const bool goes_on = is_curvature_continuous(layout, plan);
    if (plan.rejected() || (!goes_on && plan.at.empty())) continue;
    const JoinLine& line = plan.join_line;
    const JoinEdge sides[2] = {edges(line.sides[0]), edges(line.sides[1])};
    const std::vector<double> at = sides[sides[0].embedded() ? 1 : 0].stations();
    for (size_t k = 0; k + 1 < at.size(); ++k)
      for (long g = 0; g < gauss.weights.size(); ++g) {
        const double f = lerp(at[k], at[k + 1], gauss.s[g]);
        JoinPoint& point = points.emplace_back();
        point.curvature = goes_on;
        point.tangent = !plan.at.empty();
        for (size_t s = 0; s < 2; ++s) {
          point.at[s] = layout.to_model_location(line.sides[s].region, sides[s].where(f));
          point.direction[s] = sides[s].along_uv(f);
        }
        point.weight = gauss.weights[g] * (at[k + 1] - at[k]) * sides[0].span();
      }
  }
  return points;
}

}  // namespace batten
