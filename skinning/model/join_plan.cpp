#include <cmath>
#include <map>

#include "batten/core/errors.h"
#include "batten/core/words.h"
#include "batten/skinning/model/join_edge.h"

namespace batten {
namespace {

// Vertices of a region at which lines of two directions meet: x_u and x_v are given there.
std::vector<char> cornered(const RegionLayout& layout) {
  const ParametricMesh& mesh = *layout.mesh();
  std::vector<char> corner(static_cast<size_t>(mesh.vertex_count()), 0);
  std::map<int, Vec2> seen;
  for (const LineRun& run : layout.runs()) {
    const Vec2 d = mesh.displacement(run.vertices).normalized();
    for (const int v : run.vertices) {
      const auto [it, first] = seen.emplace(v, d);
      constexpr double straight = 1e-9;
      if (!first && std::abs(cross(it->second, d)) > straight) corner[v] = 1;
    }
  }
  return corner;
}

}  // namespace

bool JoinPlan::constant() const {
  constexpr double same = 1e-7;  // below 1e-5 degrees
  return at.empty() && !ends[0].open && !ends[1].open &&
         std::abs(ends[0].gamma - ends[1].gamma) < same &&
         std::abs(ends[0].delta - ends[1].delta) < same;
}

namespace {

// γ and δ that change two shapes least, and the angle between their planes.
struct Glue {
  double gamma, delta, apart_deg;
  Glue(const Vec3& slope, const Vec3& a, const Vec3& b) {
    const double s2 = slope.squaredNorm();
    const Vec3 across_a = a - a.dot(slope) / s2 * slope, across_b = b - b.dot(slope) / s2 * slope;
    gamma = across_a.norm() / across_b.norm();
    delta = (a + gamma * b).dot(slope) / s2;
    apart_deg = degrees_between(across_a, -across_b);
  }
  // "" or why the join line has to be given up.
  std::string wrong(const std::string& where) const {
    constexpr double most_gamma = 50, most_apart = 90;
    if (gamma > 1 / most_gamma && gamma < most_gamma && std::isfinite(delta) &&
        apart_deg <= most_apart)
      return "";
    return "the surfaces beside it do not go on into each other " + where +
           ": their planes differ by " + number(apart_deg) + " degrees";
  }
};

void plan_embedded(JoinPlan& plan, const JoinEdge& a, const JoinEdge& b, const Points& qa,
                   const Points& qb) {
  // The hats of the coarser side.
  plan.at = a.embedded() ? a.stations() : b.stations();
  if (a.embedded() && b.embedded() && b.stations().size() < plan.at.size()) plan.at = b.stations();
  if (a.closed() && plan.at.back() < 1) plan.at.push_back(1);
  for (const double f : plan.at) {
    const Glue glue(a.slope(f), a.across_at(qa, f), b.across_at(qb, f));
    plan.gamma.push_back(glue.gamma);
    plan.delta.push_back(glue.delta);
    // Ends lie at corners, where an embedded line holds slopes only roughly.
    const bool end = f == plan.at.front() || f == plan.at.back();
    if (!end && !plan.given_up()) plan.why_not = glue.wrong("everywhere");
  }
  if (plan.at.size() < 4) plan.why_not = "it is shorter than the elements that it is embedded in";
}

}  // namespace

std::vector<JoinPlan> plan_joins(const std::vector<const RegionLayout*>& regions,
                                 const std::vector<Points>& shapes,
                                 const std::vector<JoinLine>& join_lines, double most_apart_deg) {
  std::vector<std::vector<char>> corner;
  for (const RegionLayout* region : regions)
    corner.push_back(region ? cornered(*region) : std::vector<char>());
  const auto shape = [&](const JoinSide& j) -> const Points& { return shapes[j.region]; };

  JoinEdges sides(regions);
  std::vector<JoinPlan> plans;
  for (const JoinLine& join_line : join_lines) {
    JoinPlan plan;
    plan.join_line = join_line;
    const JoinEdge a = sides(join_line.sides[0]), b = sides(join_line.sides[1]);
    if (a.embedded() || b.embedded()) {
      plan_embedded(plan, a, b, shape(join_line.sides[0]), shape(join_line.sides[1]));
    } else {
      bool same = a.count() == b.count() && a.closed() == b.closed();
      for (int k = 0; same && k < a.count(); ++k)
        same = std::abs(a.fraction(k) - b.fraction(k)) < 1e-9;
      if (!same) plan.why_not = "the regions beside it have different vertices on it";
    }
    plans.push_back(std::move(plan));
  }

  const auto is_free = [&](const JoinSide& j, int v) { return !corner[j.region][v]; };
  // What the neighbours want of y at vertices where it is free.
  std::map<std::pair<int, int>, std::vector<JoinEnd::Neighbour>> wanted;
  for (const JoinPlan& plan : plans) {
    if (plan.given_up() || !plan.at.empty()) continue;
    for (int s = 0; s < 2; ++s) {
      const JoinSide &mine = plan.join_line.sides[s], &other = plan.join_line.sides[1 - s];
      const JoinEdge a = sides(mine), b = sides(other);
      for (int end = 0; end < 2; ++end) {
        const int v = a.end_vertex(end);
        if (!is_free(mine, v) || is_free(other, b.end_vertex(end))) continue;
        wanted[{mine.region, v}].push_back({other, end});
      }
    }
  }

  for (JoinPlan& plan : plans) {
    if (plan.given_up() || !plan.at.empty()) continue;
    for (int end = 0; end < 2; ++end) {
      JoinEnd& at_end = plan.ends[end];
      std::array<Vec3, 2> y;
      int loose = 0;
      for (int s = 0; s < 2; ++s) {
        const JoinSide& j = plan.join_line.sides[s];
        const JoinEdge side = sides(j);
        const int v = side.end_vertex(end);
        y[s] = side.across(shape(j), end ? side.count() - 1 : 0);
        if (!is_free(j, v)) continue;
        const auto it = wanted.find({j.region, v});
        if (it == wanted.end()) {
          ++loose;
          continue;
        }
        y[s].setZero();
        for (const JoinEnd::Neighbour& other : it->second) {
          const JoinEdge beside = sides(other.side);
          y[s] -= beside.across(shape(other.side), other.end ? beside.count() - 1 : 0) /
                  static_cast<double>(it->second.size());
        }
        at_end.set[s] = it->second;
      }
      at_end.loose = loose > 0;
      if (loose > 0) continue;
      const Glue glue(sides(plan.join_line.sides[0]).slope(end), y[0], y[1]);
      at_end.gamma = glue.gamma;
      at_end.delta = glue.delta;
      at_end.apart_deg = glue.apart_deg;
      at_end.open = !(glue.apart_deg <= most_apart_deg);
      plan.why_not = glue.wrong(end ? "at its end" : "at its start");
      if (plan.given_up()) break;
    }
  }
  return plans;
}

}  // namespace batten
