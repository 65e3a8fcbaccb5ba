// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/surfaces/loft_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/core/geometry.h"
#include "batten/skinning/search/region_graph.h"
#include "batten/skinning/surfaces/section_region.h"

namespace batten {
namespace {

constexpr double kImpossible = std::numeric_limits<double>::infinity();

int start_node(const CurveNetwork& network, const OrientedEdge& use) {
  return network.edges()[use.edge].nodes[use.reversed];
}
int end_node(const CurveNetwork& network, const OrientedEdge& use) {
  return network.edges()[use.edge].nodes[!use.reversed];
}

EdgeLoop in_reverse(const EdgeLoop& loop) {
  EdgeLoop result(loop.rbegin(), loop.rend());
  for (OrientedEdge& use : result) use.reversed = !use.reversed;
  return result;
}

// Chains edges into one open or closed chain without branches; nullopt if they do not form one.
std::optional<LoftPlan::Section> as_chain(const CurveNetwork& network,
                                          const std::vector<int>& edges) {
  std::map<int, std::vector<OrientedEdge>> leaving;
  for (const int a : edges)
    for (const bool reversed : {false, true})
      leaving[network.edges()[a].nodes[reversed]].push_back({a, reversed});
  OrientedEdge first{-1, false};
  int ends = 0;
  for (const auto& [node, uses] : leaving) {
    if (uses.size() > 2) return std::nullopt;
    if (uses.size() == 2) continue;
    ++ends;
    if (first.edge < 0) first = uses[0];
  }
  if (edges.empty() || ends > 2) return std::nullopt;
  if (first.edge < 0) first = {edges[0], false};
  LoftPlan::Section section{{first}, ends == 0};
  while (section.edges.size() < edges.size()) {
    const OrientedEdge& last = section.edges.back();
    const auto& uses = leaving[end_node(network, last)];
    if (uses.size() < 2) return std::nullopt;
    section.edges.push_back(uses[uses[0].edge == last.edge]);
  }
  const std::set<int> distinct = [&] {
    std::set<int> all;
    for (const OrientedEdge& use : section.edges) all.insert(use.edge);
    return all;
  }();
  if (distinct.size() != edges.size()) return std::nullopt;
  return section;
}

std::vector<int> nodes_of(const CurveNetwork& network, const LoftPlan::Section& section) {
  std::vector<int> nodes;
  for (const OrientedEdge& use : section.edges) nodes.push_back(start_node(network, use));
  if (!section.closed) nodes.push_back(end_node(network, section.edges.back()));
  return nodes;
}

// True if the section has a corner between its edges i - 1 and i.
bool has_corner(const CurveNetwork& network, const LoftPlan::Section& section, size_t i) {
  const size_t n = section.edges.size();
  if (i == 0 && !section.closed) return false;
  const OrientedEdge &before = section.edges[(i + n - 1) % n], &after = section.edges[i];
  return network.edges()[before.edge].continuation[!before.reversed] !=
         EdgeEnd{after.edge, after.reversed};
}

int corner_count(const CurveNetwork& network, const LoftPlan::Section& section) {
  int count = 0;
  for (size_t i = 0; i < section.edges.size(); ++i) count += has_corner(network, section, i);
  return count;
}

// A section as a curve: the fraction f of its arc length runs from 0 to 1.
class SectionCurve {
 public:
  SectionCurve(const CurveNetwork& network, LoftPlan::Section section)
      : section_(std::move(section)) {
    for (const OrientedEdge& use : section_.edges) {
      starts_.push_back(total_);
      lengths_.emplace_back(network.edges()[use.edge].input);
      inputs_.push_back(network.edges()[use.edge].input);
      total_ += lengths_.back().total();
    }
    for (double& start : starts_) start /= total_;
    measure();
  }

  bool closed() const { return section_.closed; }
  const LoftPlan::Section& section() const { return section_; }
  double start_of_edge(size_t i) const { return starts_[i]; }

  Vec3 at(double f) const {
    f = closed() ? f - std::floor(f) : std::clamp(f, 0.0, 1.0);
    const auto i = static_cast<size_t>(std::upper_bound(starts_.begin() + 1, starts_.end(), f) -
                                       starts_.begin() - 1);
    const double s = std::clamp((f - starts_[i]) * total_, 0.0, lengths_[i].total());
    const bool reversed = section_.edges[i].reversed;
    return inputs_[i]->evaluate(lengths_[i].parameter(reversed ? lengths_[i].total() - s : s));
  }

  // Maps a point from the surroundings of another section to those of this one.
  Vec3 carried(const Vec3& p, const SectionCurve& from) const {
    Vec3 x = (p - from.mean_) * (radius_ / from.radius_);
    const Vec3 axis = from.normal_.cross(normal_);
    constexpr double kParallel = 1e-9;
    if (is_flat_loop() && from.is_flat_loop() && axis.norm() > kParallel)
      x = rotated(to_rotation_vector(axis, std::atan2(axis.norm(), from.normal_.dot(normal_))), x);
    return mean_ + x;
  }

  // True if this section should be reversed to run like another one.
  bool runs_against(const SectionCurve& other) const {
    if (is_flat_loop() && other.is_flat_loop()) return normal_.dot(other.normal_) < 0;
    const Vec3 a = carried(other.at(0), other), b = carried(other.at(1), other);
    return (at(0) - a).norm() + (at(1) - b).norm() > (at(1) - a).norm() + (at(0) - b).norm();
  }

  double radius() const { return radius_; }

  // The fraction from `from` to `to` at which `measure` of the point is least.
  template <class Measure>
  double minimum(double from, double to, const Measure& measure) const {
    constexpr int kCount = 256;
    constexpr double kGolden = 0.6180339887498949;
    const double step = (to - from) / kCount;
    double best = from, least = kImpossible;
    for (int k = 0; k <= kCount; ++k)
      if (const double d = measure(at(from + k * step)); d < least)
        least = d, best = from + k * step;
    double low = std::max(from, best - step), high = std::min(to, best + step);
    for (int k = 0; k < 40; ++k) {
      const double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
      if (measure(at(a)) < measure(at(b)))
        high = b;
      else
        low = a;
    }
    return 0.5 * (low + high);
  }

 private:
  void measure() {
    constexpr int kSamples = 256;
    std::vector<Vec3> points;
    for (int k = 0; k < kSamples; ++k)
      points.push_back(at((k + (closed() ? 0.0 : 0.5)) / kSamples));
    for (const Vec3& p : points) mean_ += p / kSamples;
    double squared = 0;
    Vec3 area = Vec3::Zero();
    for (size_t i = 0; i < points.size(); ++i) {
      const Vec3 p = points[i] - mean_;
      squared += p.squaredNorm() / kSamples;
      area += 0.5 * p.cross(points[(i + 1) % points.size()] - mean_);
    }
    radius_ = std::sqrt(squared);
    normal_ = area.norm() > 0 ? Vec3(area.normalized()) : Vec3(Vec3::Zero());
    constexpr double kNearlyClosed = 0.25;  // gap between the ends, of the radius
    flat_loop_ = area.norm() > 0 && (closed() || (at(0) - at(1)).norm() < kNearlyClosed * radius_);
  }
  bool is_flat_loop() const { return flat_loop_; }

  LoftPlan::Section section_;
  std::vector<double> starts_;
  std::vector<ArcLength> lengths_;
  std::vector<std::shared_ptr<const InputCurve>> inputs_;
  double total_ = 0, radius_ = 1;
  Vec3 mean_ = Vec3::Zero(), normal_ = Vec3::Zero();
  bool flat_loop_ = false;  // closed, or nearly so, with a plane
};

// A point of a section through which a rail must run.
struct Knot {
  double f = 0;
  int guide = -1;  // -1: none
};

std::vector<Knot> knots_of(const CurveNetwork& network, const LoftPlan& plan, size_t index,
                           const SectionCurve& curve) {
  const LoftPlan::Section& section = curve.section();
  const std::vector<int> nodes = nodes_of(network, section);
  std::vector<Knot> knots;
  for (size_t i = 0; i < nodes.size(); ++i) {
    Knot knot{i < section.edges.size() ? curve.start_of_edge(i) : 1.0, -1};
    for (int g = 0; g < isize(plan.guides); ++g)
      if (plan.guides[static_cast<size_t>(g)][index] == nodes[i]) knot.guide = g;
    const bool end = !section.closed && (i == 0 || i + 1 == nodes.size());
    if (knot.guide >= 0 || end || has_corner(network, section, i % section.edges.size()))
      knots.push_back(knot);
  }
  return knots;
}

// Assigns the rails of one section to the next section.
class RailMatch {
 public:
  // `before`: fractions of the rails on the previous section, ascending, from the first one on.
  RailMatch(const SectionCurve& from, const std::vector<Knot>& before, const SectionCurve& to,
            const std::vector<Knot>& knots)
      : to_(to), before_(before), knots_(knots) {
    for (const Knot& rail : before) points_.push_back(to.carried(from.at(rail.f), from));
  }

  // The rails on the next section, in the same order; empty if the guides do not permit it. In
  // closed sections, fractions may exceed 1.
  std::vector<Knot> run() const {
    const auto [sum, rail_of] = to_.closed() ? best_cyclic() : best_from(0);
    if (!std::isfinite(sum)) return {};
    std::vector<double> f(before_.size(), -1);
    for (size_t i = 0; i < rail_of.size(); ++i) f[static_cast<size_t>(rail_of[i])] = knots_[i].f;
    place_others(f);
    std::vector<Knot> result;
    for (size_t j = 0; j < f.size(); ++j) result.push_back({f[j], before_[j].guide});
    return result;
  }

 private:
  double cost(size_t knot, size_t rail) const {
    const bool first = knot == 0, last = knot + 1 == knots_.size();
    if (!to_.closed() && (first != (rail == 0) || last != (rail + 1 == before_.size())))
      return kImpossible;
    if (knots_[knot].guide != before_[rail].guide) return kImpossible;
    return (to_.at(knots_[knot].f) - points_[rail]).squaredNorm();
  }

  // The cheapest assignment of all knots to rails in ascending order, starting at rail `first` and
  // going round. Dynamic programming.
  std::pair<double, std::vector<int>> best_from(size_t first) const {
    const size_t m = before_.size(), q = knots_.size();
    std::vector<std::vector<double>> sum(q + 1, std::vector<double>(m + 1, kImpossible));
    std::fill(sum[0].begin(), sum[0].end(), 0.0);
    for (size_t i = 1; i <= q; ++i)
      for (size_t j = i; j <= m; ++j)
        sum[i][j] = std::min(sum[i][j - 1], sum[i - 1][j - 1] + cost(i - 1, (first + j - 1) % m));
    std::vector<int> rail_of(q);
    for (size_t i = q, j = m; i > 0; --j) {
      if (j > i && sum[i][j] == sum[i][j - 1]) continue;
      rail_of[i - 1] = static_cast<int>((first + j - 1) % m);
      --i;
    }
    return {sum[q][m], rail_of};
  }

  std::pair<double, std::vector<int>> best_cyclic() const {
    std::pair<double, std::vector<int>> best{kImpossible, {}};
    // Rotations that differ by rounding only count as equal: the first one is taken.
    const double tie = 1e-6 * to_.radius() * to_.radius();
    for (size_t first = 0; first < before_.size(); ++first)
      if (auto other = best_from(first); other.first < best.first - tie || best.second.empty())
        best = std::move(other);
    return best;
  }

  // Places the rails without a knot at the nearest points between the rails beside them.
  void place_others(std::vector<double>& f) const {
    const size_t m = f.size();
    const auto fixed = std::find_if(f.begin(), f.end(), [](double x) { return x >= 0; });
    size_t anchor = static_cast<size_t>(fixed - f.begin());
    if (fixed == f.end()) {
      anchor = 0;
      f[0] = nearest(0, 0, 1);
    }
    // Unrolled from the anchor; in a closed section, the anchor follows again after one turn.
    std::vector<size_t> order;
    for (size_t k = 0; k < m; ++k) order.push_back((anchor + k) % m);
    double turn = f[anchor];
    for (const size_t j : order) {
      if (f[j] < 0) continue;
      while (f[j] < turn) f[j] += 1;
      turn = f[j];
    }
    for (size_t k = 0; k < m; ++k) {
      if (f[order[k]] >= 0) continue;
      size_t last = k;
      while (last < m && f[order[last]] < 0) ++last;
      const double low = f[order[k - 1]], high = last < m ? f[order[last]] : f[anchor] + 1;
      place(f, order, k, last, low, high);
      k = last - 1;
    }
  }

  double nearest(size_t rail, double low, double high) const {
    return to_.minimum(low, high, [&](const Vec3& p) { return (p - points_[rail]).squaredNorm(); });
  }

  // Rails order[first … last - 1] between two fractions: at the nearest points if these ascend, or
  // else in the proportions of the previous section.
  void place(std::vector<double>& f, const std::vector<size_t>& order, size_t first, size_t last,
             double low, double high) const {
    constexpr double kLeastGap = 0.02;  // of the interval
    double previous = low;
    bool ascending = true;
    for (size_t k = first; k < last; ++k) {
      f[order[k]] = nearest(order[k], low, high);
      ascending = ascending && f[order[k]] - previous > kLeastGap * (high - low);
      previous = f[order[k]];
    }
    if (ascending && high - previous > kLeastGap * (high - low)) return;
    const auto gap = [&](size_t k) {
      const double x = before_[order[k % order.size()]].f - before_[order[first - 1]].f;
      return x - std::floor(x);
    };
    const double whole = gap(last) > 0 ? gap(last) : 1;  // 1: around to the same rail
    for (size_t k = first; k < last; ++k) f[order[k]] = low + (high - low) * gap(k) / whole;
  }

  const SectionCurve& to_;
  const std::vector<Knot>&before_, &knots_;
  std::vector<Vec3> points_;  // of the rails, carried to the next section
};

// The sections as curves that all run in the same direction.
std::vector<SectionCurve> aligned_curves(const CurveNetwork& network, const LoftPlan& plan) {
  std::vector<SectionCurve> curves;
  for (LoftPlan::Section section : plan.sections) {
    SectionCurve curve(network, section);
    if (!curves.empty() && curve.runs_against(curves.back())) {
      section.edges = in_reverse(section.edges);
      curve = SectionCurve(network, section);
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

// The rails on each section; empty if the guides contradict the order of the corners.
std::vector<std::vector<Knot>> matched_rails(const CurveNetwork& network, const LoftPlan& plan,
                                             const std::vector<SectionCurve>& curves) {
  std::vector<std::vector<Knot>> rails;
  for (size_t k = 0; k < curves.size(); ++k) rails.push_back(knots_of(network, plan, k, curves[k]));
  const auto most = std::max_element(
      rails.begin(), rails.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
  if (most->empty()) return {};
  const auto reference = static_cast<size_t>(most - rails.begin());
  const auto match = [&](size_t from, size_t to) {
    rails[to] = RailMatch(curves[from], rails[from], curves[to], rails[to]).run();
    return !rails[to].empty();
  };
  for (size_t k = reference + 1; k < curves.size(); ++k)
    if (!match(k - 1, k)) return {};
  for (size_t k = reference; k > 0; --k)
    if (!match(k, k - 1)) return {};
  return rails;
}

// A name "rail n" that no curve has yet.
std::string next_rail_name(const CurveNetwork& network, int& number) {
  for (;;) {
    const std::string name = "rail " + std::to_string(++number);
    if (std::none_of(network.lines().begin(), network.lines().end(),
                     [&](const CharacterLine& line) { return line.name == name; }))
      return name;
  }
}

}  // namespace

std::vector<CharacterLine> loft_rails(const CurveNetwork& network, const LoftPlan& plan) {
  const std::vector<SectionCurve> curves = aligned_curves(network, plan);
  const std::vector<std::vector<Knot>> knots = matched_rails(network, plan, curves);
  if (knots.empty()) return {};
  const size_t count = knots[0].size();
  std::vector<CharacterLine> rails;
  int number = 0;
  for (size_t j = 0; j < count; ++j) {
    if (knots[0][j].guide >= 0) continue;
    std::vector<Vec3> points;
    for (size_t k = 0; k < curves.size(); ++k) points.push_back(curves[k].at(knots[k][j].f));
    rails.push_back(rail_through(next_rail_name(network, number), points));
  }
  if (count > 1 || !curves[0].closed()) return rails;
  std::vector<Vec3> noses;
  for (size_t k = 0; k < curves.size(); ++k) {
    const double f = knots[k][0].f;
    const Vec3 corner = curves[k].at(f);
    noses.push_back(curves[k].at(
        curves[k].minimum(f, f + 1, [&](const Vec3& p) { return -(p - corner).squaredNorm(); })));
  }
  rails.push_back(rail_through(next_rail_name(network, number), noses));
  return rails;
}

namespace {

std::vector<Vec3> samples_of_section(const CurveNetwork& network,
                                     const LoftPlan::Section& section) {
  constexpr int kSamples = 64;
  const SectionCurve curve(network, section);
  std::vector<Vec3> points;
  for (int k = 0; k < kSamples; ++k)
    points.push_back(curve.at(section.closed ? k / double(kSamples) : k / (kSamples - 1.0)));
  return points;
}

// Puts the sections of a plan in the order of the loft. Returns false if they do not face each
// other.
bool put_in_order(const CurveNetwork& network, std::vector<LoftPlan::Section>& sections) {
  std::vector<std::vector<Vec3>> samples;
  for (const auto& section : sections) samples.push_back(samples_of_section(network, section));
  const std::vector<int> order = loft_order(samples, sections[0].closed);
  std::vector<LoftPlan::Section> row;
  for (const int k : order) row.push_back(std::move(sections[static_cast<size_t>(k)]));
  sections = std::move(row);
  return !sections.empty();
}

// Parts of a network that edges connect, as chains; empty if one of them is no chain.
std::vector<LoftPlan::Section> chains_of(const CurveNetwork& network,
                                         const std::vector<int>& edges) {
  DisjointSets parts(network.nodes().size());
  for (const int a : edges) parts.unite(network.edges()[a].nodes[0], network.edges()[a].nodes[1]);
  std::map<int, std::vector<int>> edges_of_part;
  for (const int a : edges) edges_of_part[parts.find(network.edges()[a].nodes[0])].push_back(a);
  std::vector<LoftPlan::Section> chains;
  for (const auto& [part, members] : edges_of_part) {
    auto chain = as_chain(network, members);
    if (!chain) return {};
    chains.push_back(std::move(*chain));
  }
  return chains;
}

bool all_closed(const std::vector<LoftPlan::Section>& sections, bool closed) {
  return std::all_of(sections.begin(), sections.end(),
                     [&](const LoftPlan::Section& section) { return section.closed == closed; });
}

// True if the corners suffice to define rails: closed sections need one, open ones without guides
// the same number, at least one.
bool corners_define_rails(const CurveNetwork& network, const LoftPlan& plan) {
  std::vector<int> counts;
  for (const auto& section : plan.sections) counts.push_back(corner_count(network, section));
  const auto [least, most] = std::minmax_element(counts.begin(), counts.end());
  if (plan.sections[0].closed) return *most > 0;
  return !plan.guides.empty() || (*least > 0 && *least == *most);
}

// The guide made of bridges: its node on each section; empty if they form no single guide.
std::vector<int> guide_of_bridges(const CurveNetwork& network,
                                  const std::vector<LoftPlan::Section>& sections,
                                  const std::vector<int>& bridges) {
  std::map<int, int> section_at;
  for (int k = 0; k < isize(sections); ++k)
    for (const int node : nodes_of(network, sections[static_cast<size_t>(k)])) section_at[node] = k;
  std::vector<int> guide(sections.size(), -1);
  // Contracts the bridges between nodes that lie on no section.
  DisjointSets parts(network.nodes().size());
  for (const int a : bridges) parts.unite(network.edges()[a].nodes[0], network.edges()[a].nodes[1]);
  std::set<int> all;
  for (const int a : bridges)
    for (const int node : network.edges()[a].nodes) {
      all.insert(parts.find(node));
      const auto on = section_at.find(node);
      if (on == section_at.end()) {
        if (network.nodes()[node].ends.size() != 2) return {};
        continue;
      }
      int& at = guide[static_cast<size_t>(on->second)];
      if (at >= 0 && at != node) return {};
      at = node;
    }
  if (all.size() != 1 || std::find(guide.begin(), guide.end(), -1) != guide.end()) return {};
  return guide;
}

std::optional<LoftPlan> find_closed_loft(const CurveNetwork& network) {
  const RegionGraph graph(network);
  std::vector<int> bridges, others;
  for (int a = 0; a < isize(network.edges()); ++a)
    (graph.bridge[a] ? bridges : others).push_back(a);
  LoftPlan plan{chains_of(network, others), {}};
  if (plan.sections.size() < 2 || !all_closed(plan.sections, true)) return std::nullopt;
  if (!put_in_order(network, plan.sections)) return std::nullopt;
  if (!bridges.empty()) {
    plan.guides = {guide_of_bridges(network, plan.sections, bridges)};
    if (plan.guides[0].empty()) return std::nullopt;
  }
  if (!corners_define_rails(network, plan)) return std::nullopt;
  return plan;
}

bool is_planar_network(const CurveNetwork& network) {
  std::vector<Vec3> points;
  constexpr int kSamples = 16;
  for (const NetworkEdge& edge : network.edges())
    for (int k = 0; k <= kSamples; ++k)
      points.push_back(edge.curve.evaluate(edge.curve.end() * k / kSamples));
  const PrincipalAxes axes = principal_axes(points);
  constexpr double kFlat = 1e-3;  // of the size
  return std::all_of(points.begin(), points.end(), [&](const Vec3& p) {
    return std::abs((p - axes.mean).dot(axes.axes.col(0))) <= kFlat * network.size();
  });
}

// Edges of the given curves.
std::vector<int> edges_of_lines(const CurveNetwork& network, const std::set<int>& lines) {
  std::vector<int> edges;
  for (int a = 0; a < isize(network.edges()); ++a)
    if (lines.count(network.edges()[a].line)) edges.push_back(a);
  return edges;
}

// The nodes of a curve on each section; empty if it does not meet each of them once.
std::vector<int> guide_nodes(const CurveNetwork& network,
                             const std::vector<LoftPlan::Section>& sections, int line) {
  std::set<int> on_line;
  for (const int a : edges_of_lines(network, {line}))
    on_line.insert(network.edges()[a].nodes.begin(), network.edges()[a].nodes.end());
  std::vector<int> nodes;
  for (const auto& section : sections) {
    std::vector<int> common;
    for (const int node : nodes_of(network, section))
      if (on_line.count(node)) common.push_back(node);
    if (common.size() != 1) return {};
    nodes.push_back(common[0]);
  }
  return nodes;
}

// All curves but one are open sections, and that one is the guide.
std::optional<LoftPlan> find_guided_loft(const CurveNetwork& network) {
  if (is_planar_network(network)) return std::nullopt;
  const int count = isize(network.lines());
  for (int guide = 0; guide < count; ++guide) {
    std::set<int> lines;
    for (int k = 0; k < count; ++k)
      if (k != guide) lines.insert(k);
    LoftPlan plan{chains_of(network, edges_of_lines(network, lines)), {}};
    if (plan.sections.size() < 2 || !all_closed(plan.sections, false)) continue;
    if (guide_nodes(network, plan.sections, guide).empty()) continue;
    if (!put_in_order(network, plan.sections)) return std::nullopt;
    plan.guides = {guide_nodes(network, plan.sections, guide)};
    return plan;
  }
  return std::nullopt;
}

// All closed curves are sections, and every other curve is a guide that meets each of them once.
std::optional<LoftPlan> find_crossed_loft(const CurveNetwork& network) {
  LoftPlan plan;
  std::vector<int> others;
  for (int k = 0; k < isize(network.lines()); ++k) {
    const std::vector<int> edges = edges_of_lines(network, {k});
    if (edges.empty()) continue;  // a duplicate
    auto section = as_chain(network, edges);
    if (section && section->closed)
      plan.sections.push_back(std::move(*section));
    else
      others.push_back(k);
  }
  if (plan.sections.size() < 2 || others.empty() || !put_in_order(network, plan.sections))
    return std::nullopt;
  for (const int line : others) {
    plan.guides.push_back(guide_nodes(network, plan.sections, line));
    if (plan.guides.back().empty()) return std::nullopt;
  }
  if (!corners_define_rails(network, plan)) return std::nullopt;
  return plan;
}

std::optional<LoftPlan> find_open_loft(const CurveNetwork& network) {
  std::vector<int> all;
  for (int a = 0; a < isize(network.edges()); ++a) all.push_back(a);
  LoftPlan plan{chains_of(network, all), {}};
  if (plan.sections.size() < 2) return find_guided_loft(network);
  if (!all_closed(plan.sections, false) || !corners_define_rails(network, plan) ||
      !put_in_order(network, plan.sections))
    return std::nullopt;
  return plan;
}

}  // namespace

std::optional<LoftPlan> find_loft(const CurveNetwork& network) {
  for (const CharacterLine& line : network.lines())
    if (line.role != CharacterLine::Role::Outline) return std::nullopt;
  if (auto plan = find_closed_loft(network)) return plan;
  if (auto plan = find_crossed_loft(network)) return plan;
  return find_open_loft(network);
}

std::optional<LoftPlan> loft_through(const CurveNetwork& network,
                                     const std::vector<std::string>& sections) {
  LoftPlan plan;
  std::set<int> guides;
  for (int k = 0; k < isize(network.lines()); ++k) guides.insert(k);
  for (const std::string& name : sections) {
    const auto& lines = network.lines();
    const auto line = std::find_if(lines.begin(), lines.end(),
                                   [&](const CharacterLine& l) { return l.name == name; });
    if (line == lines.end()) return std::nullopt;
    const int index = static_cast<int>(line - lines.begin());
    guides.erase(index);
    auto section = as_chain(network, edges_of_lines(network, {index}));
    if (!section) return std::nullopt;
    plan.sections.push_back(std::move(*section));
  }
  if (plan.sections.size() < 2 || !all_closed(plan.sections, plan.sections[0].closed))
    return std::nullopt;
  for (const int line : guides) {
    plan.guides.push_back(guide_nodes(network, plan.sections, line));
    if (plan.guides.back().empty()) return std::nullopt;
  }
  if (!corners_define_rails(network, plan)) return std::nullopt;
  return plan;
}

namespace {

// The edges of a section from one of its nodes to another one, in its direction.
EdgeLoop path_between(const CurveNetwork& network, const LoftPlan::Section& section, int from,
                      int to) {
  EdgeLoop path;
  const size_t n = section.edges.size();
  size_t i = 0;
  while (i < n && start_node(network, section.edges[i]) != from) ++i;
  for (size_t k = 0; k < n && i + k < (section.closed ? 2 * n : n); ++k) {
    path.push_back(section.edges[(i + k) % n]);
    if (end_node(network, path.back()) == to) return path;
  }
  return {};
}

// A rail or guide in a network: its nodes on the sections, and its edges between them.
struct RailEdges {
  std::vector<int> nodes;
  std::vector<EdgeLoop> edges;
};

std::optional<RailEdges> edges_of_rail(const CurveNetwork& network, const std::string& name,
                                       size_t sections) {
  RailEdges rail;
  for (const int a : network.edges_of(name))
    rail.edges.push_back({{a, network.edges()[a].reversed}});
  if (rail.edges.size() + 1 != sections) return std::nullopt;
  for (const EdgeLoop& edge : rail.edges) rail.nodes.push_back(start_node(network, edge[0]));
  rail.nodes.push_back(end_node(network, rail.edges.back()[0]));
  return rail;
}

// The shortest path between two nodes over the given edges, by number of edges; empty if there is
// none. Breadth-first search.
EdgeLoop shortest_path(const CurveNetwork& network, const std::vector<int>& edges, int from,
                       int to) {
  std::map<int, OrientedEdge> reached;
  for (std::vector<int> front{from}; !front.empty() && !reached.count(to);) {
    std::vector<int> next;
    for (const int node : front)
      for (const int a : edges)
        for (const bool reversed : {false, true}) {
          const OrientedEdge use{a, reversed};
          const int there = end_node(network, use);
          if (start_node(network, use) != node || there == from) continue;
          if (reached.emplace(there, use).second) next.push_back(there);
        }
    front = std::move(next);
  }
  EdgeLoop path;
  for (int node = to; node != from; node = start_node(network, path.back())) {
    const auto by = reached.find(node);
    if (by == reached.end()) return {};
    path.push_back(by->second);
  }
  return {path.rbegin(), path.rend()};
}

// The sections of a plan in a network that splits its curves further, all in the same direction.
std::vector<LoftPlan::Section> sections_in(const CurveNetwork& network, const CurveNetwork& planned,
                                           const LoftPlan& plan) {
  LoftPlan result;
  for (const auto& section : plan.sections) {
    std::set<int> lines;
    for (const OrientedEdge& use : section.edges) lines.insert(planned.edges()[use.edge].line);
    auto chain = as_chain(network, edges_of_lines(network, lines));
    if (!chain || chain->closed != section.closed) return {};
    result.sections.push_back(std::move(*chain));
  }
  std::vector<LoftPlan::Section> sections;
  for (const SectionCurve& curve : aligned_curves(network, result))
    sections.push_back(curve.section());
  return sections;
}

void count_free_edges(const CurveNetwork& network, FoundRegions& found) {
  std::vector<int> uses(network.edges().size(), 0);
  for (const NetworkRegion& region : found.regions)
    for (const OrientedEdge& use : region.loops[0]) ++uses[use.edge];
  for (int a = 0; a < isize(uses); ++a)
    if (uses[a] < 2) (uses[a] == 0 ? found.unused_edges : found.free_edges).push_back(a);
}

// The guides of a plan in a network that splits its curves further.
std::vector<RailEdges> guides_in(const CurveNetwork& network, const CurveNetwork& planned,
                                 const LoftPlan& plan,
                                 const std::vector<LoftPlan::Section>& sections) {
  std::set<int> on_sections;
  for (const auto& section : sections)
    for (const OrientedEdge& use : section.edges) on_sections.insert(use.edge);
  std::vector<int> others;
  for (int a = 0; a < isize(network.edges()); ++a)
    if (!on_sections.count(a)) others.push_back(a);
  std::vector<RailEdges> guides;
  for (const std::vector<int>& nodes : plan.guides) {
    RailEdges guide;
    for (size_t k = 0; k < sections.size(); ++k) {
      const Vec3& at = planned.nodes()[nodes[k]].position;
      const std::vector<int> own = nodes_of(network, sections[k]);
      guide.nodes.push_back(*std::min_element(own.begin(), own.end(), [&](int a, int b) {
        return (network.nodes()[a].position - at).norm() <
               (network.nodes()[b].position - at).norm();
      }));
      if (k > 0)
        guide.edges.push_back(shortest_path(network, others, guide.nodes[k - 1], guide.nodes[k]));
    }
    guides.push_back(std::move(guide));
  }
  return guides;
}

// The face between two sections and two rails, in bay k; no loop if they do not bound one.
NetworkRegion face_between(const CurveNetwork& network,
                           const std::vector<LoftPlan::Section>& sections, const RailEdges& left,
                           const RailEdges& right, size_t k) {
  EdgeLoop loop = path_between(network, sections[k], left.nodes[k], right.nodes[k]);
  const EdgeLoop far =
      path_between(network, sections[k + 1], left.nodes[k + 1], right.nodes[k + 1]);
  NetworkRegion region;
  if (loop.empty() || far.empty() || left.edges[k].empty() || right.edges[k].empty()) return region;
  for (const EdgeLoop& side : {right.edges[k], in_reverse(far), in_reverse(left.edges[k])})
    loop.insert(loop.end(), side.begin(), side.end());
  region.loops = {std::move(loop)};
  return region;
}

}  // namespace

std::optional<FoundRegions> loft_faces(const CurveNetwork& network, const CurveNetwork& planned,
                                       const LoftPlan& plan,
                                       const std::vector<CharacterLine>& rails) {
  const std::vector<LoftPlan::Section> sections = sections_in(network, planned, plan);
  if (sections.empty()) return std::nullopt;
  std::vector<RailEdges> all = guides_in(network, planned, plan, sections);
  for (const CharacterLine& line : rails) {
    auto rail = edges_of_rail(network, line.name, sections.size());
    if (!rail) return std::nullopt;
    all.push_back(std::move(*rail));
  }
  // The rails in their order along the first section.
  const std::vector<int> nodes = nodes_of(network, sections[0]);
  const auto position = [&](const RailEdges& rail) {
    return std::find(nodes.begin(), nodes.end(), rail.nodes[0]) - nodes.begin();
  };
  std::sort(all.begin(), all.end(),
            [&](const RailEdges& a, const RailEdges& b) { return position(a) < position(b); });
  FoundRegions found;
  const size_t strips = all.size() - !sections[0].closed;
  for (size_t k = 0; k + 1 < sections.size(); ++k)
    for (size_t j = 0; j < strips; ++j) {
      found.regions.push_back(
          face_between(network, sections, all[j], all[(j + 1) % all.size()], k));
      if (found.regions.back().loops.empty()) return std::nullopt;
    }
  if (!plan.guides.empty() && sections[0].closed)
    for (const auto& end : {sections.front(), sections.back()}) {
      NetworkRegion cap;
      cap.loops = {end.edges};
      found.regions.push_back(std::move(cap));
    }
  for (size_t r = 0; r < found.regions.size(); ++r)
    found.regions[r].name = "face " + std::to_string(r + 1);
  count_free_edges(network, found);
  return found;
}

double rail_tolerance(const std::vector<CharacterLine>& rails) {
  constexpr double kFraction = 0.1;  // of the least distance between the ends of two rails
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < rails.size(); ++i)
    for (size_t j = i + 1; j < rails.size(); ++j)
      for (const bool end : {false, true}) {
        const InputCurve &a = *rails[i].curve, &b = *rails[j].curve;
        least = std::min(
            least,
            (a.evaluate(end ? a.end() : a.start()) - b.evaluate(end ? b.end() : b.start())).norm());
      }
  return kFraction * least;
}

namespace {

// True if a rail runs through a corner of a section.
bool meets_corner(const CurveNetwork& network, const LoftPlan& plan, const CharacterLine& rail) {
  const std::vector<double> at = rail.curve->breaks();
  for (size_t k = 0; k < plan.sections.size(); ++k) {
    const LoftPlan::Section& section = plan.sections[k];
    const Vec3 p = rail.curve->evaluate(at[k]);
    for (size_t i = 0; i < section.edges.size(); ++i) {
      const Vec3& corner = network.nodes()[start_node(network, section.edges[i])].position;
      if (has_corner(network, section, i) && (corner - p).norm() <= network.tolerance())
        return true;
    }
  }
  return false;
}

}  // namespace

std::vector<std::string> rails_at_corners(const CurveNetwork& network, const LoftPlan& plan,
                                          const std::vector<CharacterLine>& rails) {
  std::vector<std::string> names;
  for (const CharacterLine& rail : rails)
    if (meets_corner(network, plan, rail)) names.push_back(rail.name);
  return names;
}

}  // namespace batten
