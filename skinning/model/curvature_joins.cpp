#include "batten/skinning/model/curvature_joins.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "batten/elements/quadrature.h"
#include "batten/skinning/model/join_edge.h"

namespace batten {
namespace {

// A line that leaves an end of a join line: its unit tangent there, its curvature vector and chord.
struct Leaving {
  Vec3 way, curvature;
  double length;
};

// The slopes of a run at its start or end, away from there.
Leaving leaving(const LineRun& run, bool at_end) {
  const double p = at_end ? run.parameters.back() : run.parameters.front();
  const Vec3 d1 = (at_end ? -1 : 1) * run.fitted.evaluate(p, 1), d2 = run.fitted.evaluate(p, 2);
  const Vec3 way = d1.normalized();
  const Vec3 chord =
      run.fitted.evaluate(run.parameters.back()) - run.fitted.evaluate(run.parameters.front());
  return {way, (d2 - d2.dot(way) * way) / d1.squaredNorm(), chord.norm()};
}

// All lines of a side's region that leave an end of it, but for itself.
std::vector<Leaving> beside(const ModelLayout& layout, const JoinSide& side, bool at_end) {
  const auto& runs = layout.region(side.region).runs();
  const LineRun& own = runs[static_cast<size_t>(side.line)];
  const int v = at_end ? own.vertices.back() : own.vertices.front();
  std::vector<Leaving> all;
  for (const LineRun& run : runs) {
    if (&run == &own || run.fitted.closed()) continue;
    if (run.vertices.front() == v) all.push_back(leaving(run, false));
    if (run.vertices.back() == v) all.push_back(leaving(run, true));
  }
  return all;
}

}  // namespace

bool curvature_goes_on(const ModelLayout& layout, const JoinPlan& plan) {
  if (plan.given_up()) return false;
  const JoinLine& line = plan.join_line;
  if (line.curvature) return *line.curvature;
  if (line.sides[0].embedded || line.sides[1].embedded) return true;
  constexpr double straight_on = -0.9, least_angle = 0.3;  // cosine; sine
  constexpr double least_turn = 0.2;                       // radians
  double jump = 0, most = 0;
  for (const bool at_end : {false, true}) {
    const auto& run = layout.region(line.sides[0].region).runs()[line.sides[0].line];
    const Vec3 along = leaving(run, at_end).way;
    for (const Leaving& a : beside(layout, line.sides[0], at_end))
      for (const Leaving& b : beside(layout, line.sides[1], at_end)) {
        const Vec3 normal = along.cross(a.way);
        if (a.way.dot(b.way) > straight_on || normal.norm() < least_angle) continue;
        const double first = a.curvature.dot(normal.normalized()),
                     second = b.curvature.dot(normal.normalized());
        most += std::max(std::abs(first), std::abs(second));
        // Over the shorter line they turn by nearly the same.
        if (std::abs(first - second) * std::min(a.length, b.length) < least_turn) continue;
        jump += std::abs(first - second);
      }
  }
  return jump <= 0.5 * most;
}

std::vector<JoinPoint> curvature_joins(const ModelLayout& layout) {
  std::vector<const RegionLayout*> regions;
  for (int r = 0; r < layout.region_count(); ++r) regions.push_back(&layout.region(r));
  JoinEdges edges(regions);
  const SegmentRule gauss = gauss_legendre(2);
  std::vector<JoinPoint> points;
  for (const JoinPlan& plan : layout.join_plans()) {
    const bool goes_on = curvature_goes_on(layout, plan);
    if (plan.given_up() || (!goes_on && plan.at.empty())) continue;
    const JoinLine& line = plan.join_line;
    const JoinEdge sides[2] = {edges(line.sides[0]), edges(line.sides[1])};
    const std::vector<double> at = sides[sides[0].embedded() ? 1 : 0].stations();
    for (size_t k = 0; k + 1 < at.size(); ++k)
      for (long g = 0; g < gauss.weights.size(); ++g) {
        const double f = share(at[k], at[k + 1], gauss.s[g]);
        JoinPoint& point = points.emplace_back();
        point.curvature = goes_on;
        point.tangent = !plan.at.empty();
        for (size_t s = 0; s < 2; ++s) {
          point.at[s] = layout.in_model(line.sides[s].region, sides[s].where(f));
          point.way[s] = sides[s].along_uv(f);
        }
        point.weight = gauss.weights[g] * (at[k + 1] - at[k]) * sides[0].span();
      }
  }
  return points;
}

}  // namespace batten
