// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/network/curve_network.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/fem/curves/cubic.h"
#include "batten/skinning/network/network_edge.h"
#include "batten/skinning/network/network_nodes.h"

namespace batten::detail {

// Curves of edges: interpolate the nodes exactly, with constant speed and common tangents.

/// Input of make_edge_curve().
struct EdgeCurveInput {
  std::shared_ptr<const TrimmedCurve> input;
  Vec3 start, end;                  ///< node positions
  Vec3 start_tangent, end_tangent;  ///< unit tangents in the direction of the edge
};

struct EdgeCurve {
  HermiteCurve curve;
  double length = 0, deviation = 0;
};

/// Makes the curve of an edge from its input curve.
///
/// The input is displaced by the offsets between its ends and the nodes, faded out with 1 - 3σ² +
/// 2σ³ (σ: fraction of the arc length). It is then rotated to the end tangents by adding τ s (1 -
/// s/R)² near each end (τ: change of the unit tangent, s: arc length from the end). R is chosen so
/// that no point moves by more than half of `tolerance`. The result is interpolated by a Hermite
/// curve (position and unit tangent, uniform in arc length); intervals are halved until the curve
/// is within `fit`. Cost: O(segments).
EdgeCurve make_edge_curve(const EdgeCurveInput& plan, double size, double tolerance, double fit);

}  // namespace batten::detail

namespace batten {
namespace {

using namespace detail;

// Renumbers the nodes in canonical order and removes nodes without edges. Returns the new number of
// each old node; -1: removed.
std::vector<int> canonical_nodes(const SampledCurves& sampled_curves, NetworkTopology& net) {
  std::vector<char> used(net.nodes.size(), 0);
  for (const CurveInterval& c : net.intervals)
    for (const int n : c.nodes) used[n] = 1;
  std::vector<std::pair<std::array<long long, 3>, int>> order;
  for (int n = 0; n < isize(net.nodes); ++n)
    if (used[n])
      order.emplace_back(sort_key(net.nodes[n], sampled_curves.origin, sampled_curves.size), n);
  std::sort(order.begin(), order.end());
  std::vector<int> number(net.nodes.size(), -1);
  for (size_t i = 0; i < order.size(); ++i) number[order[i].second] = static_cast<int>(i);
  for (CurveInterval& c : net.intervals)
    for (int& n : c.nodes) n = number[n];
  std::vector<Vec3> nodes;
  for (const auto& [key, n] : order) nodes.push_back(net.nodes[n]);
  net.nodes = std::move(nodes);
  return number;
}

struct EdgeDraft {
  const CurveInterval* interval;
  std::shared_ptr<const TrimmedCurve> input;
  double length;
  bool flipped;  // runs against its sampled curve
  std::array<int, 2> nodes;
  std::array<long long, 3> middle;
};

EdgeDraft make_edge_draft(const SampledCurves& sampled_curves, const CurveInterval& interval,
                          double size) {
  const SampledCurve& sampled_curve = sampled_curves.sampled_curves[interval.sampled_curve];
  const double period = sampled_curve.curve->end() - sampled_curve.curve->start();
  const auto parameter = [&](double s) {
    return s <= sampled_curve.length
               ? sampled_curve.arc_length->parameter(s)
               : sampled_curve.arc_length->parameter(s - sampled_curve.length) + period;
  };
  const auto point = [&](double f) {
    double s = interval.s0 + f * (interval.s1 - interval.s0);
    if (s > sampled_curve.length) s -= sampled_curve.length;
    return sampled_curve.point(sampled_curve.arc_length->parameter(s));
  };
  // Direction: from the node with the lower number. A closed edge is oriented by comparing points
  // equally far from either end.
  bool flipped = interval.nodes[0] > interval.nodes[1];
  if (interval.nodes[0] == interval.nodes[1])
    for (const double f : {0.25, 0.125, 0.375, 1.0 / 3, 0.05, 0.2, 0.45})
      if (const int c = compare(point(f), point(1 - f), 1e-9 * size); c != 0) {
        flipped = c > 0;
        break;
      }
  EdgeDraft draft{
      &interval,
      sampled_curve.curve->part(parameter(interval.s0), parameter(interval.s1), flipped),
      interval.s1 - interval.s0,
      flipped,
      interval.nodes,
      sort_key(point(0.5), sampled_curves.origin, size)};
  if (flipped) std::swap(draft.nodes[0], draft.nodes[1]);
  return draft;
}

// Unit tangent that points away from the node.
Vec3 outward_tangent(const EdgeDraft& draft, bool end) {
  const TrimmedCurve& c = *draft.input;
  return end ? Vec3(-tangent(c, c.end(), -1)) : tangent(c, c.start(), 1);
}

// Pairs the edge ends that continue each other: segments of one curve first, then the straightest.
void find_partners(const std::vector<EdgeDraft>& drafts, const std::vector<NetworkNode>& nodes,
                   const SampledCurves& sampled_curves, double tangent_angle,
                   std::vector<NetworkEdge>& edges) {
  struct Pair {
    int different_curve;  // 0: both are segments of one sampled curve, split here; 1: otherwise
    long long angle_deg;
    EdgeEnd p, q;
  };
  const auto position_along = [&](const EdgeEnd& e) {  // position along the sampled curve
    const CurveInterval& c = *drafts[e.edge].interval;
    const bool last = e.end != drafts[e.edge].flipped;
    const double length = sampled_curves.sampled_curves[c.sampled_curve].length;
    const double s = last ? c.s1 : c.s0;
    return std::pair(last, s > length ? s - length : s);
  };
  // True if both ends were one corner of an input curve.
  const auto is_corner = [&](const EdgeEnd& p, const EdgeEnd& q) {
    std::array<std::pair<int, int>, 2> ends;
    for (const auto& [e, end] : {std::pair(p, &ends[0]), std::pair(q, &ends[1])}) {
      const auto [last, s] = position_along(e);
      const int k = drafts[e.edge].interval->sampled_curve;
      const double length = sampled_curves.sampled_curves[k].length;
      if (std::abs(s - (last ? length : 0)) > 1e-9 * length) return false;
      *end = {k, last};
    }
    const auto& corners = sampled_curves.corners;
    return std::binary_search(corners.begin(), corners.end(), ends) ||
           std::binary_search(corners.begin(), corners.end(), std::array{ends[1], ends[0]});
  };
  for (const NetworkNode& node : nodes) {
    std::vector<Vec3> direction;
    for (const EdgeEnd& e : node.ends) direction.push_back(outward_tangent(drafts[e.edge], e.end));
    std::vector<Pair> pairs;
    for (size_t i = 0; i < node.ends.size(); ++i)
      for (size_t j = i + 1; j < node.ends.size(); ++j) {
        const EdgeEnd &p = node.ends[i], &q = node.ends[j];
        const double angle_deg = degrees_between(direction[i], -direction[j]);
        const auto [last_p, s_p] = position_along(p);
        const auto [last_q, s_q] = position_along(q);
        const int k = drafts[p.edge].interval->sampled_curve;
        const SampledCurve& sampled_curve = sampled_curves.sampled_curves[k];
        const bool one = k == drafts[q.edge].interval->sampled_curve && last_p != last_q &&
                         sampled_curve.between(s_p, s_q) <= 1e-9 * sampled_curve.length &&
                         (sampled_curve.closed || (s_p > 0 && s_p < sampled_curve.length));
        if (one || (angle_deg <= tangent_angle && !is_corner(p, q)))
          pairs.push_back({one ? 0 : 1, std::llround(angle_deg * (1 << 20)), p, q});
      }
    std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
      return std::tie(a.different_curve, a.angle_deg) < std::tie(b.different_curve, b.angle_deg);
    });
    for (const Pair& pair : pairs) {
      auto &p = edges[pair.p.edge].continuation[pair.p.end],
           &q = edges[pair.q.edge].continuation[pair.q.end];
      if (p.edge >= 0 || q.edge >= 0) continue;
      p = pair.q;
      q = pair.p;
    }
  }
}

// Unit tangents at both ends of each edge, in its direction. Continuing ends get a common tangent.
std::vector<std::array<Vec3, 2>> end_tangents(const std::vector<EdgeDraft>& drafts,
                                              const std::vector<NetworkEdge>& edges) {
  std::vector<std::array<Vec3, 2>> along(edges.size());
  for (size_t i = 0; i < edges.size(); ++i)
    for (const bool end : {false, true})
      along[i][end] = (end ? -1 : 1) * outward_tangent(drafts[i], end);
  for (int i = 0; i < isize(edges); ++i)
    for (const bool end : {false, true}) {
      const EdgeEnd q = edges[i].continuation[end];
      if (q.edge < 0 || std::tuple(q.edge, q.end) < std::tuple(i, end)) continue;
      const Vec3 p_away = outward_tangent(drafts[i], end),
                 q_away = outward_tangent(drafts[q.edge], q.end);
      const Vec3 common = (p_away - q_away).normalized();  // points away from the node along p
      along[i][end] = (end ? -1 : 1) * common;
      along[q.edge][q.end] = (q.end ? 1 : -1) * common;
    }
  return along;
}

void report_disconnected_parts(const std::vector<NetworkEdge>& edges,
                               const std::vector<NetworkNode>& nodes,
                               const std::vector<CharacterLine>& lines,
                               std::vector<NetworkDiagnostic>& diagnostics) {
  DisjointSets groups(nodes.size());
  for (const auto& edge : edges) groups.unite(edge.nodes[0], edge.nodes[1]);
  std::map<int, std::vector<int>> parts;
  for (size_t i = 0; i < edges.size(); ++i)
    parts[groups.find(edges[i].nodes[0])].push_back(static_cast<int>(i));
  int largest = -1;
  for (const auto& [part, members] : parts)
    if (largest < 0 || members.size() > parts[largest].size()) largest = part;
  for (const auto& [part, members] : parts) {
    if (part == largest) continue;
    std::vector<std::string> names;
    for (const int i : members)
      if (const auto& name = lines[edges[i].line].name;
          std::find(names.begin(), names.end(), name) == names.end())
        names.push_back(name);
    const Vec3& p = nodes[part].position;
    std::string text = names.size() == 1 ? "curve '" : "curves '";
    constexpr size_t most = 4;
    for (size_t i = 0; i < std::min(most, names.size()); ++i)
      text += (i > 0 ? "', '" : "") + names[i];
    text += names.size() > most ? "', … (" + std::to_string(names.size()) + " curves)" : "'";
    diagnostics.push_back({NetworkDiagnostic::Kind::Disconnected, names, p, 0, false,
                           text + " near " + format_point(p) +
                               (names.size() == 1 ? " is" : " are") +
                               " not connected to the rest of the network"});
  }
}

void require_options(const NetworkOptions& options) {
  const auto check = [](const char* name, double value, bool fits, const char* expected) {
    if (!fits)
      throw InputError(std::string("network: found ") + name + " = " + format_number(value) +
                       ", expected " + expected);
  };
  for (const auto& [name, value] : {std::pair("gap_tolerance", options.tolerance),
                                    std::pair("fit_tolerance", options.fit_tolerance)})
    check(name, value, std::isfinite(value) && value >= 0, "0 (automatic) or more");
  for (const auto& [name, value] : {std::pair("corner_angle", options.corner_angle),
                                    std::pair("tangent_angle", options.tangent_angle)})
    check(name, value, value >= 0 && value <= 180, "0 to 180 degrees");
}

// Fraction of the gaps that are within a tolerance; 1 if there are no gaps.
double fraction_within(const std::vector<double>& gaps, double tolerance) {
  const auto within =
      std::count_if(gaps.begin(), gaps.end(), [&](double gap) { return gap <= tolerance; });
  return gaps.empty() ? 1 : static_cast<double>(within) / static_cast<double>(gaps.size());
}

// Derives the gap tolerance from the gaps at curve ends (see NetworkOptions::tolerance); `usual` if
// fewer than half of the gaps are below `largest`.
double tolerance_from_gaps(std::vector<double> gaps, double usual, double largest) {
  if (fraction_within(gaps, largest) < 0.5) return usual;
  std::sort(gaps.begin(), gaps.end());
  const size_t meeting =
      static_cast<size_t>(std::upper_bound(gaps.begin(), gaps.end(), largest) - gaps.begin());
  const double most = gaps[(4 * meeting + 4) / 5 - 1], all = gaps[meeting - 1];
  // A node joins ends that lie in a circle, not only a pair.
  constexpr double kAlike = 2, kMargin = 1.4;
  return std::clamp(kMargin * (all <= kAlike * most ? all : most), usual, largest);
}

struct JoinTolerance {
  double tolerance, joined_fraction = 1;
};

// Gap tolerance: the option if it is set, otherwise the usual one. If the usual one joins less than
// half of the points at which curves end or cross, the tolerance is derived from the end gaps.
JoinTolerance find_join_tolerance(const std::vector<SampledCurve>& sampled_curves,
                                  const NetworkOptions& options, double size) {
  if (options.tolerance > 0.1 * size)
    throw InputError("network: found gap_tolerance = " + format_number(options.tolerance) +
                     ", expected at most a tenth of the network's size " + format_number(size));
  if (options.tolerance > 0) return {options.tolerance};
  const double usual = 1e-3 * size, largest = 2e-2 * size;
  std::vector<double> gaps = end_gaps(sampled_curves, largest);
  double fraction = fraction_within(gaps, usual);
  if (fraction >= 0.5) return {usual, fraction};
  // Curves that cross and overshoot a little are joined; the overshoot is not a drawing gap. If
  // curves cross far more often than they end, the crossings are intended, and the gaps of their
  // ends do not measure drawing accuracy either.
  const std::vector<Contact> met = find_contacts(sampled_curves, usual, size).joined;
  gaps = end_gaps(sampled_curves, largest, met);
  const auto crossing =
      std::count_if(met.begin(), met.end(), [](const Contact& c) { return c.ea < 0 && c.eb < 0; });
  std::vector<double> gaps_and_crossings = gaps;
  gaps_and_crossings.resize(gaps.size() + static_cast<size_t>(crossing), 0.0);
  fraction = fraction_within(gaps_and_crossings, usual);
  return {fraction < 0.5 ? tolerance_from_gaps(gaps, usual, largest) : usual, fraction};
}

double fit_of(const NetworkOptions& options, double size) {
  constexpr double kDefaultFit = 1e-4;  // of the network size
  return options.fit_tolerance > 0 ? options.fit_tolerance : kDefaultFit * size;
}

// Drafts of all edges in canonical order.
std::vector<EdgeDraft> draft_edges(const SampledCurves& sampled_curves,
                                   const std::vector<CurveInterval>& intervals,
                                   const std::vector<CharacterLine>& lines) {
  std::vector<EdgeDraft> drafts;
  for (const CurveInterval& interval : intervals)
    drafts.push_back(make_edge_draft(sampled_curves, interval, sampled_curves.size));
  const auto name_of = [&](const EdgeDraft& d) -> const std::string& {
    return lines[sampled_curves.sampled_curves[d.interval->sampled_curve].line].name;
  };
  std::stable_sort(drafts.begin(), drafts.end(), [&](const EdgeDraft& a, const EdgeDraft& b) {
    return std::tie(a.nodes, a.middle, name_of(a), a.interval->s0) <
           std::tie(b.nodes, b.middle, name_of(b), b.interval->s0);
  });
  return drafts;
}

// Makes edges without curves, names and continuations, and adds their ends to the nodes.
std::vector<NetworkEdge> make_edges(const std::vector<EdgeDraft>& drafts,
                                    const SampledCurves& sampled_curves,
                                    std::vector<NetworkNode>& nodes) {
  std::vector<NetworkEdge> edges(drafts.size());
  for (int i = 0; i < isize(drafts); ++i) {
    NetworkEdge& edge = edges[i];
    edge.line = sampled_curves.sampled_curves[drafts[i].interval->sampled_curve].line;
    edge.reversed = drafts[i].input->backwards();
    edge.input = drafts[i].input;
    edge.nodes = drafts[i].nodes;
    nodes[edge.nodes[0]].ends.push_back({i, false});
    nodes[edge.nodes[1]].ends.push_back({i, true});
  }
  return edges;
}

// Names the edges along their input curves. Returns the edges of each input curve, followed by the
// edges of other curves that coincide with it.
std::vector<std::vector<int>> name_edges(const std::vector<EdgeDraft>& drafts,
                                         const std::vector<CharacterLine>& lines,
                                         std::vector<NetworkEdge>& edges) {
  std::vector<std::vector<int>> edges_of_line(lines.size());
  for (int i = 0; i < isize(edges); ++i) edges_of_line[edges[i].line].push_back(i);
  for (size_t k = 0; k < lines.size(); ++k) {
    auto& of = edges_of_line[k];
    std::sort(of.begin(), of.end(),
              [&](int i, int j) { return drafts[i].input->first() < drafts[j].input->first(); });
    for (size_t i = 0; i < of.size(); ++i)
      edges[of[i]].name = lines[k].name + (of.size() > 1 ? "." + std::to_string(i + 1) : "");
  }
  for (int i = 0; i < isize(drafts); ++i)
    for (const int line : drafts[i].interval->shared)
      if (auto& of = edges_of_line[line]; std::find(of.begin(), of.end(), i) == of.end())
        of.push_back(i);
  return edges_of_line;
}

// Makes the curves of all edges, in parallel.
void make_edge_curves(const std::vector<EdgeDraft>& drafts, const std::vector<NetworkNode>& nodes,
                      double size, double tolerance, double fit, std::vector<NetworkEdge>& edges) {
  const auto along = end_tangents(drafts, edges);
  parallel_for(isize(edges), [&](int i) {
    NetworkEdge& edge = edges[i];
    EdgeCurve shape = make_edge_curve({drafts[i].input, nodes[edge.nodes[0]].position,
                                       nodes[edge.nodes[1]].position, along[i][0], along[i][1]},
                                      size, tolerance, fit);
    edge.curve = std::move(shape.curve);
    edge.length = shape.length;
    edge.deviation = shape.deviation;
  });
}

}  // namespace

CurveNetwork::CurveNetwork(const std::vector<CharacterLine>& lines, const NetworkOptions& options,
                           const Progress& progress)
    : lines_(lines) {
  require_options(options);
  progress.update("network", 0);
  const SampledCurves sampled_curves = make_sampled_curves(lines, options.corner_angle);
  size_ = sampled_curves.size;
  progress.update("network", 0.1);
  const JoinTolerance meeting = find_join_tolerance(sampled_curves.sampled_curves, options, size_);
  tolerance_ = meeting.tolerance;
  joined_fraction_ = meeting.joined_fraction;
  const Contacts contacts = find_contacts(sampled_curves.sampled_curves, tolerance_, size_);
  progress.update("network", 0.5);
  NetworkTopology net = make_nodes(sampled_curves, contacts, tolerance_, lines_, diagnostics_);
  if (net.intervals.empty())
    throw InputError("no curve of the network is longer than the gap tolerance " +
                     format_number(tolerance_));
  canonical_nodes(sampled_curves, net);
  for (const Vec3& p : net.nodes) nodes_.push_back({p, {}});

  const std::vector<EdgeDraft> drafts = draft_edges(sampled_curves, net.intervals, lines_);
  edges_ = make_edges(drafts, sampled_curves, nodes_);
  edges_of_line_ = name_edges(drafts, lines_, edges_);
  find_partners(drafts, nodes_, sampled_curves, options.tangent_angle, edges_);
  progress.update("network", 0.6);
  make_edge_curves(drafts, nodes_, size_, tolerance_, fit_of(options, size_), edges_);
  report_disconnected_parts(edges_, nodes_, lines_, diagnostics_);
  std::stable_sort(
      diagnostics_.begin(), diagnostics_.end(),
      [](const NetworkDiagnostic& a, const NetworkDiagnostic& b) { return a.kind < b.kind; });
  progress.update("network", 1);
}

double joined_fraction(const std::vector<CharacterLine>& lines, const NetworkOptions& options) {
  require_options(options);
  const SampledCurves sampled_curves = make_sampled_curves(lines, options.corner_angle);
  return find_join_tolerance(sampled_curves.sampled_curves, options, sampled_curves.size)
      .joined_fraction;
}

std::vector<int> CurveNetwork::edges_of(const std::string& name) const {
  for (size_t k = 0; k < lines_.size(); ++k)
    if (lines_[k].name == name) return edges_of_line_[k];
  std::vector<std::string> names;
  for (size_t i = 0; i < edges_.size(); ++i) {
    if (edges_[i].name == name) return {static_cast<int>(i)};
    names.push_back(edges_[i].name);
  }
  for (const auto& line : lines_) names.push_back(line.name);
  throw InputError("the network has no curve '" + name + "'" + did_you_mean(name, names));
}

Vec3 CurveNetwork::direction(const EdgeEnd& end) const {
  const HermiteCurve& curve = edges_.at(end.edge).curve;
  return end.end ? Vec3(-curve.slope_in(curve.node_count() - 1).normalized())
                 : Vec3(curve.slope_out(0).normalized());
}

}  // namespace batten

namespace batten::detail {
namespace {

constexpr double kGrid = 1 << 30;  // parameters are multiples of 1/kGrid

/// The input curve, displaced to its nodes and rotated to their tangents.
class DisplacedCurve final : public InputCurve {
 public:
  DisplacedCurve(const EdgeCurveInput& plan, double tolerance)
      : input_(plan.input), arc_length_(plan.input), length_(arc_length_.total()) {
    const double a = input_->start(), b = input_->end();
    shift_ = {plan.start - input_->evaluate(a, 0), plan.end - input_->evaluate(b, 0)};
    tangent_change_ = {plan.start_tangent - tangent(*input_, a, 1),
                       plan.end_tangent - tangent(*input_, b, -1)};
    for (int e = 0; e < 2; ++e) {
      // The maximum of s (1 - s/R)² is 4/27 R.
      const double most = 0.5 * tolerance * 27 / 4, amount = tangent_change_[e].norm();
      reach_[e] = amount * length_ > most ? most / amount : length_;
    }
  }
  bool changes(double size) const {
    const double moved = std::max(shift_[0].norm(), shift_[1].norm());
    // Tangents are evaluated slightly inside the ends, so they differ by about 1e-7 on any curve.
    return moved > 1e-13 * size ||
           std::max(tangent_change_[0].norm(), tangent_change_[1].norm()) > 1e-7;
  }
  double start() const override { return input_->start(); }
  double end() const override { return input_->end(); }
  std::vector<double> breaks() const override { return input_->breaks(); }
  Vec3 evaluate(double t, int order) const override {
    const double s = arc_length_.length_at(t), f = s / length_, h = smooth_step(f),
                 dh = 6 * f * (1 - f) / length_;
    if (order == 0)
      return input_->evaluate(t, 0) + (1 - h) * shift_[0] + h * shift_[1] +
             tangent_correction(s, reach_[0], 0) * tangent_change_[0] -
             tangent_correction(length_ - s, reach_[1], 0) * tangent_change_[1];
    const Vec3 along = input_->evaluate(t, 1);  // higher derivatives are not used
    return along +
           along.norm() * (dh * (shift_[1] - shift_[0]) +
                           tangent_correction(s, reach_[0], 1) * tangent_change_[0] +
                           tangent_correction(length_ - s, reach_[1], 1) * tangent_change_[1]);
  }

 private:
  static double tangent_correction(double s, double reach, int order) {
    const double f = s / reach, rest = 1 - f;
    if (f >= 1) return 0;
    return order == 0 ? s * rest * rest : rest * (1 - 3 * f);
  }

  std::shared_ptr<const InputCurve> input_;
  ArcLength arc_length_;
  double length_;
  std::array<Vec3, 2> shift_, tangent_change_;
  std::array<double, 2> reach_{};
};

class Interpolation {
 public:
  Interpolation(const EdgeCurveInput& plan, std::shared_ptr<const InputCurve> curve, double size,
                double fit)
      : plan_(plan),
        curve_(std::move(curve)),
        arc_length_(curve_),
        breaks_(curve_->breaks()),
        size_(size),
        fit_(fit) {}

  EdgeCurve run() {
    const double whole = std::max(1.0, std::round(arc_length_.total() / size_ * kGrid)) / kGrid;
    while (deepest_ > 0 && whole / (1L << deepest_) < 64 / kGrid) --deepest_;
    Node first{0, plan_.start, plan_.start_tangent}, last{1, plan_.end, plan_.end_tangent};
    nodes_ = {first};
    halve(first, last, 0);
    const auto n = static_cast<long>(nodes_.size());
    std::vector<double> u;
    Points x(n, 3), slope(n, 3);
    for (long i = 0; i < n; ++i) {
      u.push_back(std::round(nodes_[i].fraction * whole * kGrid) / kGrid);
      x.row(i) = nodes_[i].x;
      slope.row(i) = size_ * nodes_[i].tangent;
    }
    u.back() = whole;
    HermiteCurve result(std::move(u), x, slope);
    return {std::move(result), arc_length_.total(), deviation_};
  }

 private:
  struct Node {
    double fraction;  // of the arc length
    Vec3 x, tangent;
  };

  // Unit tangent. At a tangent discontinuity, the mean of both sides, so that the result does not
  // depend on the direction of travel.
  Vec3 tangent_at(double t) const {
    const double range = curve_->end() - curve_->start();
    const auto near = std::lower_bound(breaks_.begin(), breaks_.end(), t - 1e-8 * range);
    const bool at_break = near != breaks_.end() && *near < t + 1e-8 * range;
    const Vec3 d = curve_->evaluate(t, 1);
    if (!at_break && d.norm() > 1e-6 * arc_length_.total() / range) return d.normalized();
    const double where = at_break ? *near : t;
    const Vec3 mean = tangent(*curve_, where, -1) + tangent(*curve_, where, 1);
    return mean.norm() > 0 ? Vec3(mean.normalized()) : tangent(*curve_, where, 1);
  }

  Node node_at(double fraction) const {
    const double t = arc_length_.parameter(fraction * arc_length_.total());
    return {fraction, curve_->evaluate(t, 0), tangent_at(t)};
  }

  void halve(const Node& a, const Node& b, int depth) {
    const double h = (b.fraction - a.fraction) * arc_length_.total();
    double off = 0, from_input = 0;
    for (const double s : {0.1, 0.25, 0.4, 0.5, 0.6, 0.75, 0.9}) {
      const double t =
          arc_length_.parameter((a.fraction + s * (b.fraction - a.fraction)) * arc_length_.total());
      const double r = 1 - s, r2 = r * r, s2 = s * s;
      const Vec3 p = (r2 * (1 + 2 * s)) * a.x + (s2 * (1 + 2 * r)) * b.x +
                     h * ((s * r2) * a.tangent - (s2 * r) * b.tangent);
      off = std::max(off, (p - curve_->evaluate(t, 0)).norm());
      from_input = std::max(from_input, (p - plan_.input->evaluate(t, 0)).norm());
    }
    constexpr double kSafetyFactor = 0.9;  // the largest error may lie between the sampled points
    if (off <= kSafetyFactor * fit_ || depth >= deepest_) {
      nodes_.push_back(b);
      const double at_end =
          (b.x - plan_.input->evaluate(arc_length_.parameter(b.fraction * arc_length_.total()), 0))
              .norm();
      deviation_ = std::max({deviation_, from_input, at_end});
      return;
    }
    const Node middle = node_at(0.5 * (a.fraction + b.fraction));
    halve(a, middle, depth + 1);
    halve(middle, b, depth + 1);
  }

  const EdgeCurveInput& plan_;
  std::shared_ptr<const InputCurve> curve_;
  ArcLength arc_length_;
  std::vector<double> breaks_;
  double size_, fit_;
  int deepest_ = 14;
  std::vector<Node> nodes_;
  double deviation_ = 0;
};

}  // namespace

EdgeCurve make_edge_curve(const EdgeCurveInput& plan, double size, double tolerance, double fit) {
  const auto drawn = std::make_shared<DisplacedCurve>(plan, tolerance);
  std::shared_ptr<const InputCurve> curve = plan.input;
  if (drawn->changes(size)) curve = drawn;
  EdgeCurve shape = Interpolation(plan, curve, size, fit).run();
  shape.deviation =
      std::max(shape.deviation, (plan.start - plan.input->evaluate(plan.input->start(), 0)).norm());
  return shape;
}

}  // namespace batten::detail
