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

// What join lines are planned from, and the steps that plan them.
class Planner {
 public:
  Planner(const std::vector<const RegionLayout*>& regions, const std::vector<Points>& shapes,
          double most_apart_deg)
      : shapes_(shapes), most_apart_deg_(most_apart_deg), sides_(regions) {
    for (const RegionLayout* region : regions)
      corner_.push_back(region ? cornered(*region) : std::vector<char>());
  }

  // A join line without its ends: embedded lines whole, of runs whether they fit.
  JoinPlan begin(const JoinLine& join_line) {
    JoinPlan plan;
    plan.join_line = join_line;
    const JoinEdge a = sides_(join_line.sides[0]), b = sides_(join_line.sides[1]);
    if (a.embedded() || b.embedded()) {
      plan_embedded(plan, a, b, shape(join_line.sides[0]), shape(join_line.sides[1]));
    } else {
      bool same = a.count() == b.count() && a.closed() == b.closed();
      for (int k = 0; same && k < a.count(); ++k)
        same = std::abs(a.fraction(k) - b.fraction(k)) < 1e-9;
      if (!same) plan.why_not = "the regions beside it have different vertices on it";
    }
    return plan;
  }

  // Collects what the neighbours want of y at vertices where it is free.
  void collect_wishes(const JoinPlan& plan) {
    for (int s = 0; s < 2; ++s) {
      const JoinSide &mine = plan.join_line.sides[s], &other = plan.join_line.sides[1 - s];
      const JoinEdge a = sides_(mine), b = sides_(other);
      for (int end = 0; end < 2; ++end) {
        const int v = a.end_vertex(end);
        if (!is_free(mine, v) || is_free(other, b.end_vertex(end))) continue;
        wanted_[{mine.region, v}].push_back({other, end});
      }
    }
  }

  // γ and δ at an end of a join line of two runs.
  void plan_end(JoinPlan& plan, int end) {
    JoinEnd& at_end = plan.ends[end];
    std::array<Vec3, 2> y;
    int loose = 0;
    for (int s = 0; s < 2; ++s)
      loose += !find_across(plan.join_line.sides[s], end, s, y[s], at_end);
    at_end.loose = loose > 0;
    if (loose > 0) return;
    const Glue glue(sides_(plan.join_line.sides[0]).slope(end), y[0], y[1]);
    at_end.gamma = glue.gamma;
    at_end.delta = glue.delta;
    at_end.apart_deg = glue.apart_deg;
    at_end.open = !(glue.apart_deg <= most_apart_deg_);
    plan.why_not = glue.wrong(end ? "at its end" : "at its start");
  }

 private:
  const Points& shape(const JoinSide& j) const { return shapes_[j.region]; }
  bool is_free(const JoinSide& j, int v) const { return !corner_[j.region][v]; }
  static Vec3 end_across(const JoinEdge& edge, const Points& q, int end) {
    return edge.across(q, end ? edge.count() - 1 : 0);
  }

  // y of side s at an end: as its shape has it or, where it is free, as the neighbours want it on
  // the average. False where it is free and nobody wants anything.
  bool find_across(const JoinSide& j, int end, int s, Vec3& y, JoinEnd& at_end) {
    const JoinEdge side = sides_(j);
    const int v = side.end_vertex(end);
    y = end_across(side, shape(j), end);
    if (!is_free(j, v)) return true;
    const auto it = wanted_.find({j.region, v});
    if (it == wanted_.end()) return false;
    y.setZero();
    for (const JoinEnd::Neighbour& other : it->second)
      y -= end_across(sides_(other.side), shape(other.side), other.end) /
           static_cast<double>(it->second.size());
    at_end.set[s] = it->second;
    return true;
  }

  const std::vector<Points>& shapes_;
  double most_apart_deg_;
  JoinEdges sides_;
  std::vector<std::vector<char>> corner_;
  std::map<std::pair<int, int>, std::vector<JoinEnd::Neighbour>> wanted_;  // of region, vertex
};

}  // namespace

std::vector<JoinPlan> plan_joins(const std::vector<const RegionLayout*>& regions,
                                 const std::vector<Points>& shapes,
                                 const std::vector<JoinLine>& join_lines, double most_apart_deg) {
  Planner planner(regions, shapes, most_apart_deg);
  std::vector<JoinPlan> plans;
  for (const JoinLine& join_line : join_lines) plans.push_back(planner.begin(join_line));
  const auto of_runs = [](const JoinPlan& plan) { return !plan.given_up() && plan.at.empty(); };
  for (const JoinPlan& plan : plans)
    if (of_runs(plan)) planner.collect_wishes(plan);
  for (JoinPlan& plan : plans)
    for (int end = 0; end < 2; ++end)
      if (of_runs(plan)) planner.plan_end(plan, end);
  return plans;
}

}  // namespace batten
