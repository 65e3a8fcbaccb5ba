// SPDX-License-Identifier: MPL-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>

#include <Eigen/LU>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/elements/quadrature.h"
#include "batten/skinning/model/join_edge.h"

namespace batten {
namespace {

// Vertices that are tied already, to avoid redundant constraints.
struct TiedVertices {
  std::set<std::pair<int, int>> pairs;  // pairs of vertices; with -1: a single one whose y is set
  std::map<int, int> lower;  // union-find: parent of each vertex, for vertices of one node
  int first(int v) const {
    for (auto it = lower.find(v); it != lower.end(); it = lower.find(v)) v = it->second;
    return v;
  }
  // Returns false if they are connected already.
  bool connect(int a, int b) {
    const auto [low, high] = std::minmax({first(a), first(b)});
    if (low == high) return false;
    lower[high] = low;
    return true;
  }
};

// Condition (1) at the vertices and edge midpoints of two edge-aligned lines.
class AlignedTies {
 public:
  AlignedTies(const JoinPlan& plan, const std::string& name, const JoinEdge& a, const JoinEdge& b,
              ConstraintSet& set)
      : name_(name), a_(a), b_(b), set_(set), gluing_correction_(plan.gluing_correction) {
    for (size_t e = 0; e < 2; ++e) {
      log_gamma_[e] = std::log(plan.ends[e].gamma);
      delta_[e] = plan.ends[e].delta;
    }
    if (!plan.constant()) return;
    log_gamma_[0] = log_gamma_[1] = 0.5 * (log_gamma_[0] + log_gamma_[1]);
    delta_[0] = delta_[1] = 0.5 * (delta_[0] + delta_[1]);
  }
  void vertex(int k) {
    const double f = a_.fraction(k);
    JoinRow row;
    row.across(a_, k, 1);
    row.across(b_, k, gamma(f));
    row.along(a_, k, -delta(f));
    row.add_to(set_, name_);
  }
  void middle(int k) {
    const double f = 0.5 * (a_.fraction(k) + a_.fraction(k + 1));
    JoinRow row;
    row.across_middle(a_, k, 1);
    row.across_middle(b_, k, gamma(f));
    row.along_middle(a_, k, -delta(f));
    row.add_to(set_, name_);
  }

 private:
  double gamma(double f) const {
    return std::exp(lerp(log_gamma_[0], log_gamma_[1], f) +
                    GluingCorrection::at(gluing_correction_.log_gamma, f));
  }
  double delta(double f) const {
    return lerp(delta_[0], delta_[1], f) + GluingCorrection::at(gluing_correction_.delta, f);
  }
  const std::string& name_;
  const JoinEdge &a_, &b_;
  ConstraintSet& set_;
  const GluingCorrection& gluing_correction_;
  double log_gamma_[2], delta_[2];
};

void tie_aligned(const JoinPlan& plan, const std::string& name, JoinEdgeFactory& sides, bool free,
                 TiedVertices& tied, ConstraintSet& set) {
  const JoinEdge a = sides(plan.join_line.sides[0]), b = sides(plan.join_line.sides[1]);
  AlignedTies ties(plan, name, a, b, set);
  const int last = a.count() - 1;
  for (int k = 1; k < last; ++k) ties.vertex(k);
  for (int k = 0; k < last; ++k) ties.middle(k);
  for (size_t e = 0; e < 2; ++e) {
    const JoinEnd& end = plan.ends[e];
    const int k = e ? last : 0;
    const int va = a.position_dof(k), vb = b.position_dof(k);
    if (end.undetermined && tied.pairs.insert(std::minmax(va, vb)).second) ties.vertex(k);
    const bool by_lines =
        !end.open && !end.undetermined && end.set[0].empty() && end.set[1].empty();
    if (free && by_lines && tied.connect(va, vb)) ties.vertex(k);
    for (size_t s = 0; s < 2; ++s) {
      if (end.set[s].empty() || !tied.pairs.insert({s ? vb : va, -1}).second) continue;
      JoinRow row;
      row.across(s ? b : a, k, 1);
      for (const JoinEnd::Neighbour& other : end.set[s]) {
        const JoinEdge beside = sides(other.side);
        row.across(beside, other.end ? beside.count() - 1 : 0,
                   1 / static_cast<double>(end.set[s].size()));
      }
      row.add_to(set, name);
    }
  }
}

// Adds constraints on the average over each hat along a line. `add(f, weight, interval, fraction of
// it, row)` adds the terms of one Gauss point.
template <class Add>
void add_hat_averages(const std::vector<double>& at, bool closed,
                      const std::array<bool, 2>& with_ends, const std::string& name, const Add& add,
                      ConstraintSet& set) {
  for (const std::vector<HatQuadraturePoint>& hat : hats(at, closed, with_ends)) {
    JoinRow row;
    double weight = 0;
    for (const HatQuadraturePoint& p : hat) {
      add(p.f, p.weight, p.interval, p.fraction, row);
      weight += p.weight;
    }
    row.scale(1 / weight);
    row.add_to(set, name);
  }
}

// Adds factor · (y_A + γ y_B - δ x_t) at a fraction f of an embedded line, which is the fraction s
// of interval i.
void add_condition(const JoinPlan& plan, const JoinEdge& a, const JoinEdge& b, double f,
                   double factor, size_t i, double s, JoinRow& row) {
  const bool along_b = a.embedded() && !b.embedded();
  const double gamma = lerp(plan.gamma[i], plan.gamma[i + 1], s),
               delta = lerp(plan.delta[i], plan.delta[i + 1], s);
  row.at(a, f, factor, along_b ? 0 : -factor * delta);
  row.at(b, f, factor * gamma, along_b ? -factor * delta : 0);
}

// Calls visit(f, weight, interval, fraction of it) at the Gauss points of all intervals, each split
// into `parts`.
template <class Visit>
void over_intervals(const JoinPlan& plan, const SegmentRule& gauss, int parts, const Visit& visit) {
  for (size_t i = 0; i + 1 < plan.at.size(); ++i)
    for (int part = 0; part < parts; ++part)
      for (long g = 0; g < gauss.weights.size(); ++g) {
        const double s = (part + gauss.s[g]) / parts, length = plan.at[i + 1] - plan.at[i];
        visit(plan.at[i] + s * length, gauss.weights[g] * length / parts, i, s);
      }
}

void tie_hats(const JoinPlan& plan, const std::string& name, const JoinEdge& a, const JoinEdge& b,
              ConstraintSet& set) {
  using EndCondition = JoinPlan::EndCondition;
  const auto add = [&](double f, double w, size_t i, double s, JoinRow& row) {
    add_condition(plan, a, b, f, w, i, s, row);
  };
  add_hat_averages(
      plan.at, a.closed(),
      {plan.end_conditions[0] == EndCondition::Hat, plan.end_conditions[1] == EndCondition::Hat},
      name, add, set);
  for (size_t e = 0; e < 2; ++e) {
    if (plan.end_conditions[e] != EndCondition::Point) continue;
    const auto f = static_cast<double>(e);
    JoinRow across;
    add(f, 1, e ? plan.at.size() - 2 : 0, f, across);
    across.add_to(set, name);
    if (b.neighbour()) continue;
    JoinRow along;
    along.at(a, f, 0, 1);
    along.at(b, f, 0, -1);
    along.add_to(set, name);
  }
}

// Normal curvature of a surface with normal n in the direction perpendicular to `tangent`; NaN if
// the surface is singular.
double curvature_across(const SurfaceJet& jet, const Vec3& n, const Vec3& tangent) {
  const Vec3 across = n.cross(tangent).normalized();
  Eigen::Matrix<double, 3, 2> X;
  X << jet.x_u, jet.x_v;
  const Vec2 c = (X.transpose() * X).inverse() * (X.transpose() * across);
  return n.dot(c[0] * c[0] * jet.x_uu + 2 * c[0] * c[1] * jet.x_uv + c[1] * c[1] * jet.x_vv);
}

}  // namespace

JoinQuality measure_join(const std::vector<const SkinnedRegion*>& regions,
                         const JoinLine& join_line, const std::array<bool, 2>& open, int samples) {
  // Built for these two regions only, because a model measures thousands of joins.
  const std::vector<const SkinnedRegion*> two{regions[join_line.sides[0].region],
                                              regions[join_line.sides[1].region]};
  JoinEdgeFactory sides(two);
  const auto side_of = [&](int s) {
    JoinSide own = join_line.sides[s];
    own.region = s;
    return sides(own);
  };
  const JoinEdge side[2] = {side_of(0), side_of(1)};
  const auto jet = [&](int s, double f) { return two[s]->surface.jet(side[s].where(f)); };
  // A side at a fraction of the line. Seen along the line, one side is to its left and the other to
  // its right; the normals of both point to the same side of the surface.
  struct Point {
    Vec3 x, normal;
    double curvature = 0;  // across the line
  };
  const auto point = [&](int s, double f, bool with_curvature) -> Point {
    if (const NeighbourEdge* neighbour = side[s].neighbour()) {
      const Vec3 along = side[s].slope(f),
                 normal = neighbour->into(f, along).cross(along).normalized();
      return {jet(0, f).x, normal, neighbour->curvature(f).dot(normal)};
    }
    const SurfaceJet own = jet(s, f);
    const Vec3 normal = join_line.sides[s].left == (s == 0) ? own.normal() : Vec3(-own.normal());
    if (!with_curvature) return {own.x, normal};
    const Vec3 tangent = jet(0, std::min(1.0, f + 1e-4)).x - jet(0, std::max(0.0, f - 1e-4)).x;
    return {own.x, normal, curvature_across(own, normal, tangent)};
  };
  std::vector<double> at = side[side[0].embedded() ? 1 : 0].stations();
  if (at.back() < 1) at.push_back(1);
  JoinQuality quality;
  std::vector<double> jumps;
  double sum = 0, length = 0;
  const size_t edges = at.size() - 1;
  for (size_t k = 0; k < edges; ++k) {
    Vec3 before = Vec3::Zero();
    double deg_before = 0, signed_angle_before = 0;
    for (int j = 0; j <= samples; ++j) {
      const double f = lerp(at[k], at[k + 1], static_cast<double>(j) / samples);
      const bool inside = !(open[0] && k == 0) && !(open[1] && k + 1 == edges);
      const Point a = point(0, f, inside), b = point(1, f, inside);
      const Vec3 &na = a.normal, &nb = b.normal;
      const double deg = na.isZero() || nb.isZero() ? std::numeric_limits<double>::quiet_NaN()
                                                    : degrees_between(na, nb);
      const auto raise_to_maximum = [deg](double& most) {
        if (!(deg <= most) && !std::isnan(most)) most = deg;
      };
      quality.max_gap = std::max(quality.max_gap, (a.x - b.x).norm());
      raise_to_maximum(quality.max_deg);
      if (inside) {
        raise_to_maximum(quality.max_inside_deg);
        jumps.push_back(std::abs(a.curvature - b.curvature));
      }
      if (k == 0 && j == 0) quality.end_deg[0] = deg;
      if (k + 1 == edges && j == samples) quality.end_deg[1] = deg;
      // Signed angle, with the sign seen along the line from the side of the normals: outwards of
      // the left region.
      const Vec3 outwards = (join_line.sides[0].left ? 1 : -1) * side[0].slope(f).cross(na);
      const double signed_angle = std::copysign(deg * std::numbers::pi / 180, nb.dot(outwards));
      if (j > 0) {
        const double ds = (a.x - before).norm();
        length += ds;
        sum += 0.5 * (deg_before + deg) * ds;
        quality.convexity += 0.5 * (signed_angle_before + signed_angle) * ds;
      }
      before = a.x;
      deg_before = deg;
      signed_angle_before = signed_angle;
    }
  }
  if (join_line.neighbour())
    quality.max_gap = std::max(quality.max_gap, join_line.neighbour()->distance());
  quality.mean_deg = length > 0 ? sum / length : 0;
  std::erase_if(jumps, [](double jump) { return std::isnan(jump); });
  if (!jumps.empty()) {
    std::sort(jumps.begin(), jumps.end());
    quality.median_curvature_jump = jumps[jumps.size() / 2];
    quality.max_curvature_jump = jumps.back();
  }
  return quality;
}

void add_join_constraints(const std::vector<const RegionLayout*>& regions,
                          const std::vector<DofOffsets>& numbers,
                          const std::vector<JoinPlan>& plans, bool free, ConstraintSet& set) {
  JoinEdgeFactory sides(regions, numbers);
  TiedVertices tied;
  for (const JoinPlan& plan : plans) {
    if (plan.rejected()) continue;
    const std::string name = "smooth curve " + plan.join_line.name;
    if (plan.at.empty())
      tie_aligned(plan, name, sides, free, tied, set);
    else
      tie_hats(plan, name, sides(plan.join_line.sides[0]), sides(plan.join_line.sides[1]), set);
  }
}

JoinPenalty join_penalty(const std::vector<const RegionLayout*>& regions,
                         const std::vector<DofOffsets>& dof_offsets,
                         const std::vector<JoinPlan>& plans, double size, int dofs) {
  constexpr double kPenalty = 1000;
  constexpr int parts = 4;  // per interval, because element boundaries are anywhere
  const SegmentRule gauss = gauss_legendre(6);
  JoinEdgeFactory sides(regions, dof_offsets);
  std::vector<const JoinPlan*> embedded;
  std::vector<std::array<JoinEdge, 2>> edges;
  for (const JoinPlan& plan : plans) {
    if (plan.rejected() || plan.at.empty()) continue;
    embedded.push_back(&plan);
    edges.push_back({sides(plan.join_line.sides[0]), sides(plan.join_line.sides[1])});
  }
  struct PlanTerms {
    std::vector<Triplet> stiffness;
    std::vector<std::pair<int, Vec3>> load;
  };
  std::vector<PlanTerms> of_plan(embedded.size());
  parallel_for(isize(embedded), [&](int j) {
    const JoinPlan& plan = *embedded[j];
    const JoinEdge &a = edges[j][0], &b = edges[j][1];
    const RegionLayout& region = *regions[plan.join_line.sides[0].region];
    const double scale = std::pow(size / region.size(), 2);
    over_intervals(plan, gauss, parts, [&](double f, double w, size_t i, double s) {
      JoinRow row;
      add_condition(plan, a, b, f, 1, i, s, row);
      const double thickness = std::sqrt(2 * region.mesh()->shape(a.where(f).triangle).area);
      const double weight = kPenalty * scale * w * a.span() / (thickness * a.along_uv(f).norm());
      const ConstraintEntries entries = row.entries();
      for (const auto& p : entries) {
        for (const auto& q : entries)
          if (p.dof >= q.dof)
            of_plan[j].stiffness.emplace_back(p.dof, q.dof, weight * p.coefficient * q.coefficient);
        if (b.neighbour())
          of_plan[j].load.emplace_back(p.dof, -weight * p.coefficient * row.constant());
      }
    });
  });
  JoinPenalty penalty{SparseMatrix(dofs, dofs), Points::Zero(dofs, 3)};
  std::vector<Triplet> entries;
  for (const PlanTerms& own : of_plan) {
    entries.insert(entries.end(), own.stiffness.begin(), own.stiffness.end());
    for (const auto& [dof, force] : own.load) penalty.load.row(dof) += force.transpose();
  }
  penalty.stiffness.setFromTriplets(entries.begin(), entries.end());
  return penalty;
}

std::vector<std::vector<HatQuadraturePoint>> hats(const std::vector<double>& at, bool closed,
                                                  const std::array<bool, 2>& with_ends) {
  const SegmentRule gauss = gauss_legendre(6);
  const int intervals = isize(at) - 1;
  const int first = closed || !with_ends[0] ? 1 : 0;
  const int end = closed || with_ends[1] ? intervals + 1 : intervals;
  std::vector<std::vector<HatQuadraturePoint>> all;
  for (int h = first; h < end; ++h) {
    all.emplace_back();
    for (int half = 0; half < 2; ++half) {
      int i = h - 1 + half;
      if (closed) i %= intervals;
      if (i < 0 || i >= intervals) continue;
      const double from = at[i], to = at[static_cast<size_t>(i) + 1];
      for (long g = 0; g < gauss.weights.size(); ++g) {
        const double s = gauss.s[g];
        all.back().push_back({from + s * (to - from),
                              gauss.weights[g] * (to - from) * (half ? 1 - s : s),
                              static_cast<size_t>(i), s});
      }
    }
  }
  return all;
}

std::vector<double> tie_stations(const JoinEdge& a, const JoinEdge& b) {
  std::vector<double> at = (a.embedded() ? a : b).stations();
  if (a.embedded() && b.embedded() && b.stations().size() < at.size()) at = b.stations();
  if (a.closed() && at.back() < 1) at.push_back(1);
  return at;
}

void add_line_ties(const std::vector<const RegionLayout*>& regions,
                   const std::vector<DofOffsets>& numbers, const JoinLine& line,
                   ConstraintSet& set) {
  JoinEdgeFactory sides(regions, numbers);
  const JoinEdge a = sides(line.sides[0]), b = sides(line.sides[1]);
  const std::string name = "joined curve " + line.name;
  if (!a.embedded() && !b.embedded()) {
    for (int k = 0; k < a.count(); ++k) {
      ConstraintEntries position, slope;
      a.add_position(k, 1, position);
      b.add_position(k, -1, position);
      a.add_along(k, 1, slope);
      b.add_along(k, -1, slope);
      set.add(name, std::move(position), Vec3::Zero());
      set.add(name, std::move(slope), Vec3::Zero());
    }
    return;
  }
  const auto add = [&](double f, double w, size_t, double, JoinRow& row) {
    row.position(a, f, w);
    row.position(b, f, -w);
  };
  add_hat_averages(tie_stations(a, b), a.closed(), {true, true}, name, add, set);
}

}  // namespace batten
