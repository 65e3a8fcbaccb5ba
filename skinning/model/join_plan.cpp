#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

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
  return at.empty() && !ends[0].open && !ends[1].open && bow.is_zero() &&
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

// Beside its ends a line gets narrower hats: there the surfaces turn most.
void halve_ends(std::vector<double>& at) {
  const double first = (at[0] + at[1]) / 2, last = (at[at.size() - 2] + at.back()) / 2;
  if (at.size() > 2) at.insert(at.end() - 1, last);
  at.insert(at.begin() + 1, first);
}

void plan_embedded(JoinPlan& plan, const JoinEdge& a, const JoinEdge& b, const Points& qa,
                   const Points& qb) {
  // The hats of the coarser side.
  plan.at = a.embedded() ? a.stations() : b.stations();
  if (a.embedded() && b.embedded() && b.stations().size() < plan.at.size()) plan.at = b.stations();
  plan.closed = a.closed();
  if (plan.at.size() < 4) plan.why_not = "it is shorter than the elements that it is embedded in";
  if (plan.closed && plan.at.back() < 1) plan.at.push_back(1);
  if (!plan.closed) halve_ends(plan.at);
  for (const double f : plan.at) {
    const Glue glue(a.slope(f), a.across_at(qa, f), b.across_at(qb, f));
    plan.gamma.push_back(glue.gamma);
    plan.delta.push_back(glue.delta);
    // Ends lie at corners, where an embedded line holds slopes only roughly.
    const bool end = f == plan.at.front() || f == plan.at.back();
    if (!end && !plan.given_up()) plan.why_not = glue.wrong("everywhere");
  }
}

// What another line of its region does where an embedded side ends.
struct Beyond {
  bool straight = false;  // one goes on there as the side does
  std::optional<Vec3> y;  // of the side, where one leaves at an angle
};
Beyond beyond(const RegionLayout& region, const JoinEdge& side, double end) {
  constexpr double same_place = 1e-7, sine = 0.05;  // of the size
  const Vec2 at = side.image(end), way = side.along_uv(end);
  Beyond found;
  // A line that begins here, or ends here: its slopes there in (u, v) and in space.
  const auto look = [&](const Vec2& place, Vec2 uv, Vec3 x, bool begins) {
    if ((place - at).norm() > same_place) return;
    const double turn = cross(uv, way) / (uv.norm() * way.norm());
    if (std::abs(turn) > sine) {
      Mat2 both;
      both << way, uv;
      Eigen::Matrix<double, 3, 2> slopes;
      slopes << side.slope(end), x;
      found.y = slopes * (both.inverse() * side.across_uv(end));
    } else {
      const bool goes_away = (uv.dot(way) > 0) == begins;
      found.straight = found.straight || goes_away == (end != 0);
    }
  };
  for (const EmbeddedLine& line : region.embedded())
    for (const bool begins : {true, false}) {
      const double t = begins ? line.image.start() : line.image.end();
      look(flat(line.image.evaluate(t)), flat(line.image.evaluate(t, 1)),
           line.fitted.evaluate(t, 1), begins);
    }
  for (const LineRun& run : region.runs())
    for (const bool begins : {true, false}) {
      const double t = begins ? run.parameters.front() : run.parameters.back();
      look(region.mesh()->vertices()[begins ? run.vertices.front() : run.vertices.back()],
           region.mesh()->displacement(run.vertices) /
               (run.parameters.back() - run.parameters.front()),
           run.fitted.evaluate(t, 1), begins);
    }
  return found;
}

// What join lines are planned from, and the steps that plan them.
class Planner {
 public:
  Planner(const std::vector<const RegionLayout*>& regions, const std::vector<Points>& shapes,
          double most_apart_deg)
      : regions_(regions), shapes_(shapes), most_apart_deg_(most_apart_deg), sides_(regions) {
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

  // How γ and δ of two runs differ between their ends from the linear run, as the shapes have it.
  void plan_bow(JoinPlan& plan) {
    const JoinEdge a = sides_(plan.join_line.sides[0]), b = sides_(plan.join_line.sides[1]);
    if (a.closed() || plan.ends[0].loose || plan.ends[1].loose) return;
    // Shapes that meet at larger angles say nothing about how the joined ones will run, degrees.
    constexpr double kTangent = 2, kNotTangent = 6;
    constexpr double kMost = 1;  // of a correction of log γ or δ
    constexpr double kNone = 1e-6;
    double apart = 0;
    Mat2 normal = Mat2::Zero();
    Eigen::Matrix<double, 2, 2> right = Eigen::Matrix<double, 2, 2>::Zero();
    for (int k = 1; k + 1 < a.count(); ++k) {
      const double f = a.fraction(k);
      const Glue glue(a.slope(f), a.across(shape(plan.join_line.sides[0]), k),
                      b.across(shape(plan.join_line.sides[1]), k));
      apart += glue.apart_deg / (a.count() - 2);
      if (!(glue.apart_deg <= 45)) continue;
      const double log_gamma = std::log(glue.gamma) - (1 - f) * std::log(plan.ends[0].gamma) -
                               f * std::log(plan.ends[1].gamma);
      const double delta = glue.delta - (1 - f) * plan.ends[0].delta - f * plan.ends[1].delta;
      const Vec2 basis = f * (1 - f) * Vec2(1, 2 * f - 1);
      normal += basis * basis.transpose();
      right.col(0) += std::clamp(log_gamma, -kMost, kMost) * basis;
      right.col(1) += std::clamp(delta, -kMost, kMost) * basis;
    }
    if (!(normal.determinant() > 1e-9 * normal.trace() * normal.trace())) return;
    const double share = std::clamp((kNotTangent - apart) / (kNotTangent - kTangent), 0.0, 1.0);
    const Mat2 c = share * (normal.inverse() * right);
    if (c.cwiseAbs().maxCoeff() < kNone) return;
    plan.bow = {{c(0, 0), c(1, 0)}, {c(0, 1), c(1, 1)}};
  }

  // What is imposed at an end of an embedded line.
  void plan_embedded_end(JoinPlan& plan, int end) {
    const std::array<JoinSide, 2>& sides = plan.join_line.sides;
    const auto e = static_cast<size_t>(end);
    bool straight = true, known = true;
    std::optional<std::pair<int, int>> free;  // region and vertex of a run whose y follows
    Vec3 y[2];
    JoinEnd set;
    for (size_t s = 0; s < 2; ++s) {
      const JoinEdge side = sides_(sides[s]);
      if (side.embedded()) {
        const Beyond other = beyond(*regions_[sides[s].region], side, end);
        straight = straight && other.straight;
        known = known && other.y;
        if (other.y) y[s] = *other.y;
      } else if (!find_across(sides[s], end, static_cast<int>(s), y[s], set)) {
        free = {sides[s].region, side.end_vertex(end)};
        if (const auto it = followed_.find(*free); it != followed_.end())
          y[s] = it->second;
        else
          y[s] = end_across(side, shape(sides[s]), end);
      }
    }
    using EndRow = JoinPlan::EndRow;
    plan.end_rows[e] = straight ? EndRow::Hat : EndRow::None;
    if (!known) return;
    const Vec3 slope = sides_(sides[0]).slope(end);
    const Glue glue(slope, y[0], y[1]);
    const bool follows = free && !followed_.count(*free);
    plan.ends[e].apart_deg = follows ? 0 : glue.apart_deg;
    plan.ends[e].open = !(plan.ends[e].apart_deg <= most_apart_deg_);
    if (plan.ends[e].open || !glue.wrong("").empty()) return;
    plan.end_rows[e] = EndRow::Point;
    (end ? plan.gamma.back() : plan.gamma.front()) = glue.gamma;
    (end ? plan.delta.back() : plan.delta.front()) = glue.delta;
    if (!follows) return;
    // The run's y becomes what (1) makes of the other side's.
    const bool first = !sides[0].embedded;
    followed_[*free] = first ? Vec3(glue.delta * slope - glue.gamma * y[1])
                             : Vec3((glue.delta * slope - y[0]) / glue.gamma);
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

  const std::vector<const RegionLayout*>& regions_;
  const std::vector<Points>& shapes_;
  double most_apart_deg_;
  JoinEdges sides_;
  std::vector<std::vector<char>> corner_;
  std::map<std::pair<int, int>, std::vector<JoinEnd::Neighbour>> wanted_;  // of region, vertex
  std::map<std::pair<int, int>, Vec3> followed_;  // y of runs that follow an embedded side's
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
      if (of_runs(plan))
        planner.plan_end(plan, end);
      else if (!plan.given_up() && !plan.closed)
        planner.plan_embedded_end(plan, end);
  for (JoinPlan& plan : plans)
    if (of_runs(plan)) planner.plan_bow(plan);
  return plans;
}

}  // namespace batten
