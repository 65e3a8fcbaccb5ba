// SPDX-License-Identifier: MPL-2.0
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/skinning/model/join.h"
#include "batten/skinning/model/join_edge.h"

namespace batten {
namespace {

// Flags vertices of a region at which lines of two directions meet, so that they determine x_u and
// x_v.
std::vector<char> corner_vertices(const RegionLayout& layout) {
  const ParametricMesh& mesh = *layout.mesh();
  std::vector<char> corner(static_cast<size_t>(mesh.vertex_count()), 0);
  std::map<int, Vec2> seen;
  for (const EdgeAlignedLine& aligned_line : layout.edge_aligned()) {
    const Vec2 d = mesh.chain_vector(aligned_line.vertices).normalized();
    for (const int v : aligned_line.vertices) {
      const auto [it, first] = seen.emplace(v, d);
      constexpr double straight = 1e-9;
      if (!first && std::abs(cross(it->second, d)) > straight) corner[v] = 1;
    }
  }
  return corner;
}

}  // namespace

bool JoinPlan::constant() const {
  constexpr double same = 1e-7;  // corresponds to less than 1e-5 degrees
  return at.empty() && !ends[0].open && !ends[1].open && gluing_correction.is_zero() &&
         std::abs(ends[0].gamma - ends[1].gamma) < same &&
         std::abs(ends[0].delta - ends[1].delta) < same;
}

namespace {

// The γ and δ that change two shapes least, and the angle between their tangent planes.
struct GluingFunctions {
  double gamma, delta, plane_angle_deg;
  GluingFunctions(const Vec3& slope, const Vec3& a, const Vec3& b) {
    const double s2 = slope.squaredNorm();
    const Vec3 across_a = a - a.dot(slope) / s2 * slope, across_b = b - b.dot(slope) / s2 * slope;
    gamma = across_a.norm() / across_b.norm();
    delta = (a + gamma * b).dot(slope) / s2;
    plane_angle_deg = degrees_between(across_a, -across_b);
  }
  // "", or the reason why the join has to be rejected.
  std::string rejection_reason(const JoinLine& line, const std::string& where) const {
    constexpr double kMaxGamma = 50;
    // A disc in the end of a tube becomes a dome.
    const double max_apart = line.neighbour() ? 150 : 90;
    if (gamma > 1 / kMaxGamma && gamma < kMaxGamma && std::isfinite(delta) &&
        plane_angle_deg <= max_apart)
      return "";
    return "the tangent planes of the adjacent faces differ by " + format_number(plane_angle_deg) +
           " degrees " + where;
  }
};

// Refines the hats next to the ends of a line, where the surfaces turn most.
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
  if (plan.at.size() < 4)
    plan.rejection_reason = "it is shorter than the elements in which it is embedded";
  if (plan.closed && plan.at.back() < 1) plan.at.push_back(1);
  if (!plan.closed) halve_ends(plan.at);
  for (const double f : plan.at) {
    const GluingFunctions gluing(a.slope(f), a.across_at(qa, f), b.across_at(qb, f));
    plan.gamma.push_back(gluing.gamma);
    plan.delta.push_back(gluing.delta);
    // Ends lie at corners, where an embedded line constrains slopes only approximately.
    const bool end = f == plan.at.front() || f == plan.at.back();
    if (!end && !plan.rejected())
      plan.rejection_reason = gluing.rejection_reason(plan.join_line, "along it");
  }
}

// How another line of the region continues at the end of an embedded side.
struct LineContinuation {
  bool straight = false;  // another line continues straight
  std::optional<Vec3> y;  // y of the side, if another line leaves at an angle
};
LineContinuation continuation_at(const RegionLayout& region, const JoinEdge& side, double end) {
  constexpr double kSamePoint = 1e-7, kStraightSine = 0.05;  // kSamePoint: distance in (u, v)
  const Vec2 at = side.pcurve(end), tangent = side.along_uv(end);
  LineContinuation found;
  // Examines a line that begins or ends here, with its derivatives in (u, v) and in space.
  const auto examine = [&](const Vec2& point, Vec2 uv, Vec3 x, bool begins) {
    if ((point - at).norm() > kSamePoint) return;
    const double sine_of_angle = cross(uv, tangent) / (uv.norm() * tangent.norm());
    if (std::abs(sine_of_angle) > kStraightSine) {
      Mat2 both;
      both << tangent, uv;
      Eigen::Matrix<double, 3, 2> slopes;
      slopes << side.slope(end), x;
      found.y = slopes * (both.inverse() * side.across_uv(end));
    } else {
      const bool goes_away = (uv.dot(tangent) > 0) == begins;
      found.straight = found.straight || goes_away == (end != 0);
    }
  };
  for (const EmbeddedLine& line : region.embedded())
    for (const bool begins : {true, false}) {
      const double t = begins ? line.pcurve.start() : line.pcurve.end();
      examine(drop_z(line.pcurve.evaluate(t)), drop_z(line.pcurve.evaluate(t, 1)),
              line.fitted.evaluate(t, 1), begins);
    }
  for (const EdgeAlignedLine& aligned_line : region.edge_aligned())
    for (const bool begins : {true, false}) {
      const double t = begins ? aligned_line.parameters.front() : aligned_line.parameters.back();
      examine(region.mesh()->vertices()[begins ? aligned_line.vertices.front()
                                               : aligned_line.vertices.back()],
              region.mesh()->chain_vector(aligned_line.vertices) /
                  (aligned_line.parameters.back() - aligned_line.parameters.front()),
              aligned_line.fitted.evaluate(t, 1), begins);
    }
  return found;
}

// Plans join lines from given shapes, in several passes.
class JoinPlanner {
 public:
  JoinPlanner(const std::vector<const RegionLayout*>& regions, const std::vector<Points>& shapes,
              double max_plane_angle_deg)
      : regions_(regions),
        shapes_(shapes),
        max_plane_angle_deg_(max_plane_angle_deg),
        sides_(regions) {
    for (const RegionLayout* region : regions)
      corner_.push_back(region ? corner_vertices(*region) : std::vector<char>());
  }

  // Creates the plan without its ends: complete for embedded lines; for edge-aligned ones a check
  // of vertices.
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
      if (!same) plan.rejection_reason = "the adjacent faces have different mesh vertices along it";
    }
    return plan;
  }

  // Collects the neighbours that determine y at vertices where it is free.
  void collect_neighbours(const JoinPlan& plan) {
    for (int s = 0; s < 2; ++s) {
      const JoinSide &mine = plan.join_line.sides[s], &other = plan.join_line.sides[1 - s];
      const JoinEdge a = sides_(mine), b = sides_(other);
      for (int end = 0; end < 2; ++end) {
        const int v = a.end_vertex(end);
        if (!is_free(mine, v) || is_free(other, b.end_vertex(end))) continue;
        neighbours_[{mine.region, v}].push_back({other, end});
      }
    }
  }

  // Computes γ and δ at an end of a join of two edge-aligned lines.
  void plan_end(JoinPlan& plan, int end) {
    JoinEnd& at_end = plan.ends[end];
    std::array<Vec3, 2> y;
    int undetermined = 0;
    // Beside a given surface, a free y only has to lie in the tangent plane of that surface: its
    // length and direction stay those of the initial shape.
    const JoinEdge own = sides_(plan.join_line.sides[0]);
    const bool follows =
        plan.join_line.neighbour() && is_free(plan.join_line.sides[0], own.end_vertex(end));
    for (int s = 0; s < 2; ++s)
      if (s == 0 && follows)
        y[0] = end_across(own, shape(plan.join_line.sides[0]), end);
      else
        undetermined += !find_across(plan.join_line.sides[s], end, s, y[s], at_end);
    at_end.undetermined = undetermined > 0 || follows;
    if (undetermined > 0) return;
    const GluingFunctions gluing(own.slope(end), y[0], y[1]);
    at_end.gamma = gluing.gamma;
    at_end.delta = gluing.delta;
    if (follows) {
      plan.rejection_reason =
          gluing.rejection_reason(plan.join_line, end ? "at its end" : "at its start");
      return;
    }
    at_end.plane_angle_deg = gluing.plane_angle_deg;
    at_end.open = !(gluing.plane_angle_deg <= max_plane_angle_deg_);
    plan.rejection_reason =
        gluing.rejection_reason(plan.join_line, end ? "at its end" : "at its start");
  }

  // Fits the deviation of γ and δ from linear interpolation between their ends to the shapes.
  void plan_gluing_correction(JoinPlan& plan) {
    const JoinEdge a = sides_(plan.join_line.sides[0]), b = sides_(plan.join_line.sides[1]);
    if (!plan.join_line.neighbour() &&
        (a.closed() || plan.ends[0].undetermined || plan.ends[1].undetermined))
      return;
    // Shapes that meet at larger angles (degrees) do not predict the joined ones.
    constexpr double kTangent = 2, kNotTangent = 6;
    constexpr double kMost = 1;  // limit of a correction of log γ or δ
    constexpr double kNone = 1e-6;
    double mean_angle_deg = 0;
    Mat2 normal = Mat2::Zero();
    Eigen::Matrix<double, 2, 2> rhs = Eigen::Matrix<double, 2, 2>::Zero();
    for (int k = 1; k + 1 < a.count(); ++k) {
      const double f = a.fraction(k);
      const GluingFunctions gluing(a.slope(f), a.across(shape(plan.join_line.sides[0]), k),
                                   b.across(shape(plan.join_line.sides[1]), k));
      mean_angle_deg += gluing.plane_angle_deg / (a.count() - 2);
      if (!(gluing.plane_angle_deg <= 45)) continue;
      const double log_gamma = std::log(gluing.gamma) - (1 - f) * std::log(plan.ends[0].gamma) -
                               f * std::log(plan.ends[1].gamma);
      const double delta = gluing.delta - (1 - f) * plan.ends[0].delta - f * plan.ends[1].delta;
      const Vec2 basis = f * (1 - f) * Vec2(1, 2 * f - 1);
      normal += basis * basis.transpose();
      rhs.col(0) += std::clamp(log_gamma, -kMost, kMost) * basis;
      rhs.col(1) += std::clamp(delta, -kMost, kMost) * basis;
    }
    if (!(normal.determinant() > 1e-9 * normal.trace() * normal.trace())) return;
    const double weight =
        std::clamp((kNotTangent - mean_angle_deg) / (kNotTangent - kTangent), 0.0, 1.0);
    const Mat2 c = weight * (normal.inverse() * rhs);
    if (c.cwiseAbs().maxCoeff() < kNone) return;
    plan.gluing_correction = {{c(0, 0), c(1, 0)}, {c(0, 1), c(1, 1)}};
  }

  // Chooses the condition at an end of an embedded line.
  void plan_embedded_end(JoinPlan& plan, int end) {
    const std::array<JoinSide, 2>& sides = plan.join_line.sides;
    const auto e = static_cast<size_t>(end);
    bool straight = true, known = true;
    // Region and vertex of an edge-aligned side whose y is free.
    std::optional<std::pair<int, int>> free;
    Vec3 y[2];
    JoinEnd set;
    for (size_t s = 0; s < 2; ++s) {
      const JoinEdge side = sides_(sides[s]);
      if (side.neighbour()) {
        y[s] = side.neighbour_across(end);
      } else if (side.embedded()) {
        const LineContinuation other = continuation_at(*regions_[sides[s].region], side, end);
        straight = straight && other.straight;
        known = known && other.y;
        if (other.y) y[s] = *other.y;
      } else if (!find_across(sides[s], end, static_cast<int>(s), y[s], set)) {
        free = {sides[s].region, side.end_vertex(end)};
        if (const auto it = determined_.find(*free); it != determined_.end())
          y[s] = it->second;
        else
          y[s] = end_across(side, shape(sides[s]), end);
      }
    }
    using EndCondition = JoinPlan::EndCondition;
    plan.end_conditions[e] = straight ? EndCondition::Hat : EndCondition::None;
    if (!known) return;
    const Vec3 slope = sides_(sides[0]).slope(end);
    const GluingFunctions gluing(slope, y[0], y[1]);
    const bool follows = free && !determined_.count(*free);
    plan.ends[e].plane_angle_deg = follows ? 0 : gluing.plane_angle_deg;
    plan.ends[e].open = !(plan.ends[e].plane_angle_deg <= max_plane_angle_deg_);
    if (plan.ends[e].open || !gluing.rejection_reason(plan.join_line, "").empty()) return;
    plan.end_conditions[e] = EndCondition::Point;
    (end ? plan.gamma.back() : plan.gamma.front()) = gluing.gamma;
    (end ? plan.delta.back() : plan.delta.front()) = gluing.delta;
    if (!follows) return;
    // The free y is set to what (1) requires for the other side's y.
    const bool first = !sides[0].embedded;
    determined_[*free] = first ? Vec3(gluing.delta * slope - gluing.gamma * y[1])
                               : Vec3((gluing.delta * slope - y[0]) / gluing.gamma);
  }

 private:
  const Points& shape(const JoinSide& j) const { return shapes_[j.region]; }
  bool is_free(const JoinSide& j, int v) const { return !j.neighbour && !corner_[j.region][v]; }
  static Vec3 end_across(const JoinEdge& edge, const Points& q, int end) {
    return edge.across(q, end ? edge.count() - 1 : 0);
  }

  // Finds y of side s at an end: that of its shape or, if y is free there, the mean required by its
  // neighbours. Returns false if it is free and has no neighbours.
  bool find_across(const JoinSide& j, int end, int s, Vec3& y, JoinEnd& at_end) {
    const JoinEdge side = sides_(j);
    const int v = side.end_vertex(end);
    y = end_across(side, shape(j), end);
    if (!is_free(j, v)) return true;
    const auto it = neighbours_.find({j.region, v});
    if (it == neighbours_.end()) return false;
    y.setZero();
    for (const JoinEnd::Neighbour& other : it->second)
      y -= end_across(sides_(other.side), shape(other.side), other.end) /
           static_cast<double>(it->second.size());
    at_end.set[s] = it->second;
    return true;
  }

  const std::vector<const RegionLayout*>& regions_;
  const std::vector<Points>& shapes_;
  double max_plane_angle_deg_;
  JoinEdgeFactory sides_;
  std::vector<std::vector<char>> corner_;
  // By region and vertex.
  std::map<std::pair<int, int>, std::vector<JoinEnd::Neighbour>> neighbours_;
  // Y of edge-aligned sides, determined by the embedded side.
  std::map<std::pair<int, int>, Vec3> determined_;
};

}  // namespace

std::vector<JoinPlan> plan_joins(const std::vector<const RegionLayout*>& regions,
                                 const std::vector<Points>& shapes,
                                 const std::vector<JoinLine>& join_lines,
                                 double max_plane_angle_deg) {
  JoinPlanner planner(regions, shapes, max_plane_angle_deg);
  std::vector<JoinPlan> plans;
  for (const JoinLine& join_line : join_lines) plans.push_back(planner.begin(join_line));
  const auto of_aligned = [](const JoinPlan& plan) { return !plan.rejected() && plan.at.empty(); };
  for (const JoinPlan& plan : plans)
    if (of_aligned(plan)) planner.collect_neighbours(plan);
  for (JoinPlan& plan : plans)
    for (int end = 0; end < 2; ++end)
      if (of_aligned(plan))
        planner.plan_end(plan, end);
      else if (!plan.rejected() && !plan.closed)
        planner.plan_embedded_end(plan, end);
  for (JoinPlan& plan : plans)
    if (of_aligned(plan)) planner.plan_gluing_correction(plan);
  return plans;
}

std::optional<JoinSide> side_of(const SkinnedRegion& made, int region, const std::string& name) {
  for (const auto& loop : made.boundary)
    for (const BoundarySegment& piece : loop) {
      const auto i = static_cast<size_t>(piece.index);
      const bool embedded = piece.kind == BoundarySegment::Kind::Embedded;
      if ((embedded ? made.embedded[i].line : made.edge_aligned[i].line).name != name) continue;
      const bool against = embedded && made.embedded[i].opposite_to_prescribed;
      return JoinSide{region, embedded, piece.index, piece.reversed == against};
    }
  return std::nullopt;
}

}  // namespace batten
