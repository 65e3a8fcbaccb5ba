// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/network/network_nodes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"

namespace batten::detail {
namespace {

using Kind = NetworkDiagnostic::Kind;
using SplitPoint = NodeCandidates::SplitPoint;

class NodeBuilder {
 public:
  NodeBuilder(const SampledCurves& all, const Contacts& contacts, double tolerance,
              const std::vector<CharacterLine>& lines, std::vector<NetworkDiagnostic>& diagnostics)
      : all_(all),
        sampled_curves_(all.sampled_curves),
        contacts_(contacts),
        tolerance_(tolerance),
        lines_(lines),
        diagnostics_(all, tolerance, lines, diagnostics) {}

  NetworkTopology run() {
    make_candidates();
    merge_nodes();
    collapse();
    cut();
    remove_short_pieces();
    report_equal_lines();
    remove_duplicates();
    rejoin();
    diagnostics_.report_nodes(set_, result_);
    diagnostics_.report_near_misses(set_, contacts_);
    return std::move(result_);
  }

 private:
  // --- candidates and merging

  int add_interior_candidate(int sampled_curve, double s) {
    set_.candidates.push_back({sampled_curve, s, -1,
                               sampled_curves_[sampled_curve].point(
                                   sampled_curves_[sampled_curve].arc_length->parameter(s)),
                               true});
    return isize(set_.candidates) - 1;
  }

  void add_merge_candidate(int p, int q, double distance, bool contact) {
    // Ranks are rounded distances, so that rounding errors do not decide between equal distances.
    merge_candidates_.push_back({std::min(p, q), std::max(p, q),
                                 std::llround(distance / tolerance_ * (1 << 20)), distance,
                                 contact});
  }

  // True for a part of an input curve between two of its corners that is short but not degenerate:
  // it is a side that was drawn, not a gap.
  bool is_side_of_polyline(const SampledCurve& part, double length) const {
    constexpr double kDegenerate = 1e-3;  // of the tolerance
    return part.corner[0] && part.corner[1] && length == part.length &&
           length > kDegenerate * tolerance_;
  }

  void make_candidates() {
    for (int k = 0; k < isize(sampled_curves_); ++k) {
      set_.ends.push_back({-1, -1});
      for (int e = 0; e < 2 && !sampled_curves_[k].closed; ++e) {
        set_.ends[k][e] = isize(set_.candidates);
        set_.candidates.push_back({k, e ? sampled_curves_[k].length : 0, e,
                                   sampled_curves_[k].end_point(e), sampled_curves_[k].corner[e]});
      }
    }
    for (const auto& [p, q] : all_.corners)
      add_merge_candidate(set_.ends[p.first][p.second], set_.ends[q.first][q.second], 0, false);
    for (const Contact& c : contacts_.joined) {
      const int p = c.ea >= 0 ? set_.ends[c.a][c.ea] : add_interior_candidate(c.a, c.sa);
      const int q = c.eb >= 0 ? set_.ends[c.b][c.eb] : add_interior_candidate(c.b, c.sb);
      if (p != q) add_merge_candidate(p, q, c.distance, true);
    }
    // Candidates of one curve that lie within the tolerance along it.
    along_.resize(sampled_curves_.size());
    for (int m = 0; m < isize(set_.candidates); ++m)
      along_[set_.candidates[m].sampled_curve].push_back(m);
    for (auto& along : along_) {
      std::sort(along.begin(), along.end(), [&](int p, int q) {
        return std::tie(set_.candidates[p].s, p) < std::tie(set_.candidates[q].s, q);
      });
      const size_t n = along.size();
      for (size_t i = 0; n > 1 && i < n; ++i) {
        const SampledCurve& sampled_curve =
            sampled_curves_[set_.candidates[along[i]].sampled_curve];
        if (i + 1 == n && !sampled_curve.closed) break;
        const int p = along[i], q = along[(i + 1) % n];
        const double gap = sampled_curve.between(set_.candidates[p].s, set_.candidates[q].s);
        if (gap <= tolerance_ && !is_side_of_polyline(sampled_curve, gap))
          add_merge_candidate(p, q, gap, false);
      }
    }
    std::stable_sort(merge_candidates_.begin(), merge_candidates_.end(),
                     [](const MergeCandidate& p, const MergeCandidate& q) {
                       return std::tie(p.rank, p.p, p.q) < std::tie(q.rank, q.p, q.q);
                     });
  }

  // --- nodes

  Vec3 merged_position(const std::vector<int>& candidates) const {
    Vec3 own = Vec3::Zero(), any = Vec3::Zero();
    double owns = 0;
    for (const int m : candidates) {
      any += set_.candidates[m].point;
      if (set_.candidates[m].own) own += set_.candidates[m].point, owns += 1;
    }
    const Vec3 mean =
        owns > 0 ? Vec3(own / owns) : Vec3(any / static_cast<double>(candidates.size()));
    // If the points agree, the first one is kept bit by bit.
    const Vec3& first = set_.candidates[candidates[0]].point;
    return (mean - first).norm() <= 1e-14 * (all_.size + first.norm()) ? first : mean;
  }

  void merge_nodes() {
    const int n = isize(set_.candidates);
    DisjointSets groups(n);
    set_.members.resize(n);
    for (int m = 0; m < n; ++m) set_.members[m] = {m};
    for (const MergeCandidate& l : merge_candidates_) {
      const int p = groups.find(l.p), q = groups.find(l.q);
      if (p == q) continue;
      std::vector<int> both;
      std::merge(set_.members[p].begin(), set_.members[p].end(), set_.members[q].begin(),
                 set_.members[q].end(), std::back_inserter(both));
      const double far = set_.radius(both, merged_position(both));
      if (far > (1 + 1e-9) * tolerance_) {
        if (l.contact) set_.rejected.push_back(l);
        continue;
      }
      const int keep = std::min(p, q), gone = std::max(p, q);
      groups.unite(p, q);
      set_.members[keep] = std::move(both);
      set_.members[gone].clear();
    }
    set_.node_of.assign(n, -1);
    std::vector<std::vector<int>> members;  // by node
    for (int m = 0; m < n; ++m)
      if (!set_.members[m].empty()) {
        set_.node_of[m] = isize(members);
        result_.nodes.push_back(merged_position(set_.members[m]));
        members.push_back(std::move(set_.members[m]));
      }
    for (int m = 0; m < n; ++m) set_.node_of[m] = set_.node_of[groups.find(m)];
    set_.members = std::move(members);
  }

  // --- segments

  // Merges consecutive candidates of a curve that belong to the same node into one split point.
  void collapse() {
    set_.split_points.resize(sampled_curves_.size());
    for (int k = 0; k < isize(sampled_curves_); ++k) {
      const SampledCurve& sampled_curve = sampled_curves_[k];
      std::vector<std::vector<int>> groups;
      for (const int m : along_[k]) {
        if (!groups.empty() && set_.is_same_passage(all_, groups.back().back(), m, tolerance_))
          groups.back().push_back(m);
        else
          groups.push_back({m});
      }
      if (sampled_curve.closed && groups.size() > 1 &&
          set_.is_same_passage(all_, groups.back().back(), groups.front().front(), tolerance_)) {
        groups.front().insert(groups.front().begin(), groups.back().begin(), groups.back().end());
        groups.pop_back();
      }
      for (const auto& group : groups)
        if (!is_isolated(group))
          set_.split_points[k].push_back(split_point_of(sampled_curve, group));
      std::sort(set_.split_points[k].begin(), set_.split_points[k].end(),
                [](const SplitPoint& p, const SplitPoint& q) { return p.s < q.s; });
    }
  }

  // True for interior points with which nothing was merged.
  bool is_isolated(const std::vector<int>& group) {
    return std::none_of(group.begin(), group.end(),
                        [&](int m) { return set_.candidates[m].end >= 0; }) &&
           set_.members[set_.node_of[group[0]]].size() == group.size();
  }

  SplitPoint split_point_of(const SampledCurve& sampled_curve,
                            const std::vector<int>& group) const {
    const int node = set_.node_of[group[0]];
    for (const int m : group)
      if (set_.candidates[m].end >= 0) return {set_.candidates[m].s, node};
    double s = set_.candidates[group[group.size() / 2]].s;
    const Vec3 p = result_.nodes[node];
    if ((set_.candidates[group[group.size() / 2]].point - p).norm() > 1e-13 * all_.size) {
      const double reach = 2 * tolerance_;
      const double low = sampled_curve.arc_length->parameter(std::max(0.0, s - reach)),
                   high = sampled_curve.arc_length->parameter(
                       std::min(sampled_curve.length, s + reach));
      s = sampled_curve.arc_length->length_at(
          sampled_curve.closest_parameter(p, sampled_curve.arc_length->parameter(s), low, high));
    }
    return {s, node};
  }

  void cut() {
    for (int k = 0; k < isize(sampled_curves_); ++k) {
      const SampledCurve& sampled_curve = sampled_curves_[k];
      auto& split_points = set_.split_points[k];
      if (sampled_curve.closed) {
        if (split_points.empty()) {
          split_points.push_back({0, isize(result_.nodes)});
          result_.nodes.push_back(sampled_curve.x.front());
        }
        split_points.push_back(
            {split_points.front().s + sampled_curve.length, split_points.front().node});
      }
      for (size_t i = 0; i + 1 < split_points.size(); ++i)
        result_.intervals.push_back({k,
                                     split_points[i].s,
                                     split_points[i + 1].s,
                                     {split_points[i].node, split_points[i + 1].node},
                                     all_.duplicates[sampled_curve.line]});
      if (split_points.size() < 2)
        diagnostics_.add(Kind::Short, {diagnostics_.name_of(k)}, sampled_curve.x.front(),
                         sampled_curve.length, true,
                         "curve '" + diagnostics_.name_of(k) + "' was removed: its length " +
                             format_number(sampled_curve.length) +
                             " is less than the gap tolerance");
    }
  }

  void remove_short_pieces() {
    for (bool again = true; again;) {
      again = false;
      const std::vector<int> degree = result_.degrees();
      std::vector<CurveInterval> kept;
      for (const CurveInterval& c : result_.intervals) {
        const bool loose = degree[c.nodes[0]] == 1 || degree[c.nodes[1]] == 1;
        if (c.s1 - c.s0 > tolerance_ || !loose) {
          kept.push_back(c);
          continue;
        }
        again = true;
        const Vec3 where = result_.nodes[c.nodes[degree[c.nodes[0]] == 1 ? 0 : 1]];
        diagnostics_.add(Kind::Short, {diagnostics_.name_of(c.sampled_curve)}, where, c.s1 - c.s0,
                         true,
                         "a dangling segment of curve '" + diagnostics_.name_of(c.sampled_curve) +
                             "' of length " + format_number(c.s1 - c.s0) + " at " +
                             format_point(where) + " was removed");
      }
      result_.intervals = std::move(kept);
    }
    for (const CurveInterval& c : result_.intervals)
      if (c.s1 - c.s0 <= tolerance_ &&
          !is_side_of_polyline(sampled_curves_[c.sampled_curve], c.s1 - c.s0))
        diagnostics_.add(Kind::Short, {diagnostics_.name_of(c.sampled_curve)},
                         result_.nodes[c.nodes[0]], c.s1 - c.s0, false,
                         "a segment of curve '" + diagnostics_.name_of(c.sampled_curve) +
                             "' between two nodes at " + format_point(result_.nodes[c.nodes[0]]) +
                             " is only " + format_number(c.s1 - c.s0) + " long");
  }

  Vec3 point_of(const CurveInterval& c, double fraction) const {
    const SampledCurve& sampled_curve = sampled_curves_[c.sampled_curve];
    double s = c.s0 + fraction * (c.s1 - c.s0);
    if (s > sampled_curve.length) s -= sampled_curve.length;
    return sampled_curve.point(sampled_curve.arc_length->parameter(s));
  }

  // True if all of `c` lies near `other`; both have the same nodes.
  bool runs_along(const CurveInterval& c, const CurveInterval& other, bool back) const {
    const SampledCurve& sampled_curve = sampled_curves_[other.sampled_curve];
    constexpr int kSamples = 16;
    for (int k = 1; k < kSamples; ++k) {
      const double f = static_cast<double>(k) / kSamples;
      const Vec3 p = point_of(c, f);
      double best = (point_of(other, back ? 1 - f : f) - p).norm();
      double s = other.s0 + (back ? 1 - f : f) * (other.s1 - other.s0);
      if (s > sampled_curve.length) s -= sampled_curve.length;
      const double t =
          sampled_curve.closest_parameter(p, sampled_curve.arc_length->parameter(s),
                                          sampled_curve.t.front(), sampled_curve.t.back());
      best = std::min(best, (sampled_curve.point(t) - p).norm());
      if (best > 1.5 * tolerance_) return false;
    }
    return true;
  }

  bool is_duplicate(const CurveInterval& c, const CurveInterval& kept) const {
    const double a = c.s1 - c.s0, b = kept.s1 - kept.s0;
    if (std::abs(a - b) > 0.1 * std::max(a, b) + 4 * tolerance_) return false;
    for (const bool back : {false, true}) {
      if (c.nodes[0] != kept.nodes[back] || c.nodes[1] != kept.nodes[!back]) continue;
      if (runs_along(c, kept, back) && runs_along(kept, c, back)) return true;
    }
    return false;
  }

  void report_equal_lines() {
    std::vector<char> reported(lines_.size(), 0);
    for (const SampledCurve& sampled_curve : sampled_curves_) {
      if (std::exchange(reported[sampled_curve.line], 1)) continue;
      for (const int equal : all_.duplicates[sampled_curve.line]) {
        const std::string &a = lines_[equal].name, &b = lines_[sampled_curve.line].name;
        diagnostics_.add(Kind::Duplicate, {a, b}, sampled_curve.x[sampled_curve.x.size() / 2], 0,
                         true,
                         "curve '" + a + "' was removed: it is identical to curve '" + b + "'");
      }
    }
  }

  void remove_duplicates() {
    std::map<std::pair<int, int>, std::vector<size_t>> between;
    std::vector<char> gone(result_.intervals.size(), 0);
    std::map<int, int> pieces, lost;  // by input curve
    // (removed, kept) input curves: first such segment.
    std::map<std::pair<int, int>, size_t> overlap;
    for (const CurveInterval& c : result_.intervals)
      ++pieces[sampled_curves_[c.sampled_curve].line];
    for (size_t i = 0; i < result_.intervals.size(); ++i) {
      CurveInterval& c = result_.intervals[i];
      auto& others = between[std::minmax(c.nodes[0], c.nodes[1])];
      for (const size_t j : others)
        if (is_duplicate(c, result_.intervals[j])) {
          gone[i] = 1;
          const int line = sampled_curves_[c.sampled_curve].line;
          ++lost[line];
          auto& shared = result_.intervals[j].shared;
          shared.push_back(line);
          shared.insert(shared.end(), c.shared.begin(), c.shared.end());
          overlap.try_emplace({line, sampled_curves_[result_.intervals[j].sampled_curve].line}, i);
          break;
        }
      if (!gone[i]) others.push_back(i);
    }
    std::vector<std::pair<size_t, std::pair<int, int>>> reported;  // in canonical order
    for (const auto& [which, i] : overlap) reported.push_back({i, which});
    std::sort(reported.begin(), reported.end());
    for (const auto& [i, which] : reported) {
      const auto& [out, kept] = which;
      const Vec3 where = point_of(result_.intervals[i], 0.5);
      const std::string &a = lines_[out].name, &b = lines_[kept].name;
      if (out != kept && lost[out] == pieces[out])
        diagnostics_.add(Kind::Duplicate, {a, b}, where, 0, true,
                         "curve '" + a + "' was removed: it coincides with curve '" + b + "'");
      else if (out != kept)
        diagnostics_.add(Kind::Overlap, {a, b}, where, 0, true,
                         "curves '" + a + "' and '" + b + "' overlap near " + format_point(where) +
                             ": the common segment was kept once");
      else
        diagnostics_.add(Kind::Overlap, {a}, where, 0, true,
                         "curve '" + a + "' overlaps itself near " + format_point(where) +
                             ": the common segment was kept once");
    }
    std::vector<CurveInterval> intervals;
    for (size_t i = 0; i < gone.size(); ++i)
      if (!gone[i]) intervals.push_back(std::move(result_.intervals[i]));
    result_.intervals = std::move(intervals);
  }

  // Rejoins the two parts of a curve at a node whose other segments were removed.
  void rejoin() {
    const std::vector<int> degree = result_.degrees();
    std::vector<CurveInterval> intervals;
    for (CurveInterval& c : result_.intervals) {
      if (!intervals.empty() && intervals.back().sampled_curve == c.sampled_curve &&
          intervals.back().s1 == c.s0 && degree[c.nodes[0]] == 2 && c.nodes[0] != c.nodes[1] &&
          intervals.back().shared == c.shared) {
        intervals.back().s1 = c.s1;
        intervals.back().nodes[1] = c.nodes[1];
      } else {
        intervals.push_back(std::move(c));
      }
    }
    result_.intervals = std::move(intervals);
  }

  const SampledCurves& all_;
  const std::vector<SampledCurve>& sampled_curves_;
  const Contacts& contacts_;
  const double tolerance_;
  const std::vector<CharacterLine>& lines_;
  NodeDiagnostics diagnostics_;

  NodeCandidates set_;
  std::vector<std::vector<int>> along_;  // candidates of each sampled curve, in order along it
  std::vector<MergeCandidate> merge_candidates_;
  NetworkTopology result_;
};

}  // namespace

std::vector<int> NetworkTopology::degrees() const {
  std::vector<int> degree(nodes.size(), 0);
  for (const CurveInterval& c : intervals)
    for (const int n : c.nodes) ++degree[n];
  return degree;
}

NetworkTopology make_nodes(const SampledCurves& sampled_curves, const Contacts& contacts,
                           double tolerance, const std::vector<CharacterLine>& lines,
                           std::vector<NetworkDiagnostic>& diagnostics) {
  return NodeBuilder(sampled_curves, contacts, tolerance, lines, diagnostics).run();
}

namespace {

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "'" : i + 1 == names.size() ? " and '" : ", '") + names[i] + "'";
  return text;
}

}  // namespace

double NodeCandidates::radius(const std::vector<int>& some, const Vec3& p) const {
  double far = 0;
  for (const int m : some) far = std::max(far, (candidates[m].point - p).norm());
  return far;
}

bool NodeCandidates::is_same_passage(const SampledCurves& all, int p, int q,
                                     double tolerance) const {
  return node_of[p] == node_of[q] && all.sampled_curves[candidates[p].sampled_curve].between(
                                         candidates[p].s, candidates[q].s) <= 4 * tolerance;
}

void NodeDiagnostics::add(Kind kind, std::vector<std::string> names, const Vec3& where,
                          double distance, bool repaired, const std::string& text) {
  diagnostics_.push_back({kind, std::move(names), where, distance, repaired, text});
}

// Names of the input curves of some sampled curves, without repetition, in canonical order.
std::vector<std::string> NodeDiagnostics::names_of(const std::vector<int>& sampled_curves) const {
  std::vector<std::string> names;
  for (const int k : sampled_curves)
    if (std::find(names.begin(), names.end(), name_of(k)) == names.end())
      names.push_back(name_of(k));
  return names;
}

void NodeDiagnostics::report_nodes(const NodeCandidates& candidates,
                                   const NetworkTopology& result) {
  const std::vector<int> left = result.degrees();
  for (size_t n = 0; n < candidates.members.size(); ++n)
    if (candidates.members[n].size() > 1)
      report_node(candidates, candidates.members[n], result.nodes[n], left[n] == 0);
  report_dangling_ends(result, left);
}

void NodeDiagnostics::report_node(const NodeCandidates& all, const std::vector<int>& members,
                                  const Vec3& p, bool left_out) {
  const std::vector<NodeCandidate>& candidates = all.candidates;
  std::vector<int> end_marks, passes, at_end, passing;  // candidates, candidates, curves, curves
  for (const int k : members) {
    if (!candidates[k].own || candidates[k].end >= 0) end_marks.push_back(k);
    // Several candidates of one passage count once.
    if (candidates[k].end < 0 && std::none_of(passes.begin(), passes.end(), [&](int o) {
          return candidates[o].sampled_curve == candidates[k].sampled_curve &&
                 all.is_same_passage(all_, o, k, tolerance_);
        }))
      passes.push_back(k);
  }
  double gap = 0;
  for (const int a : end_marks)
    for (const int b : end_marks)
      gap = std::max(gap, (candidates[a].point - candidates[b].point).norm());
  for (const int k : end_marks) at_end.push_back(candidates[k].sampled_curve);
  if (at_end.size() > 1 && gap > 1e-9 * all_.size)
    add(Kind::EndsJoined, names_of(at_end), p, gap, true,
        "ends of " + listed(names_of(at_end)) + " at " + format_point(p) +
            " were joined across a gap of " + format_number(gap));
  // A curve that ends here does not also pass through.
  for (const int k : passes)
    if (std::none_of(end_marks.begin(), end_marks.end(), [&](int e) {
          return candidates[e].sampled_curve == candidates[k].sampled_curve &&
                 all.is_same_passage(all_, e, k, tolerance_);
        }))
      passing.push_back(candidates[k].sampled_curve);
  if (left_out || passing.empty()) return;
  const double far = all.radius(members, p);
  if (!at_end.empty()) {
    std::vector<int> both = at_end;
    both.insert(both.end(), passing.begin(), passing.end());
    add(Kind::EndOnLine, names_of(both), p, far, true,
        (at_end.size() > 1 ? "ends of " : "an end of ") + listed(names_of(at_end)) +
            (at_end.size() > 1 ? " lie" : " lies") + " in the interior of " +
            listed(names_of(passing)) + " at " + format_point(p) + ": split there");
  } else if (passing.size() > 1) {
    const auto names = names_of(passing);
    const bool self = names.size() == 1;
    add(self ? Kind::SelfCrossing : Kind::Crossing, names, p, 2 * far, true,
        (self ? "curve " + listed(names) + " intersects itself"
              : "curves " + listed(names) + " intersect") +
            " at " + format_point(p) + ": split there");
  }
}

void NodeDiagnostics::report_dangling_ends(const NetworkTopology& result,
                                           const std::vector<int>& degrees) {
  for (const CurveInterval& c : result.intervals)
    for (int e = 0; e < 2; ++e)
      if (degrees[c.nodes[e]] == 1) {
        const Vec3 p = result.nodes[c.nodes[e]];
        add(Kind::Dangling, {name_of(c.sampled_curve)}, p, 0, false,
            "an end of curve '" + name_of(c.sampled_curve) + "' at " + format_point(p) +
                " is not connected to any other curve");
      }
}

// True if two curves have a common node near the points of a contact.
bool NodeDiagnostics::meet_nearby(const NodeCandidates& candidates, const Contact& c) const {
  const double near = 10 * tolerance_;
  for (const NodeCandidates::SplitPoint& p : candidates.split_points[c.a]) {
    if (sampled_curves_[c.a].between(std::min(p.s, sampled_curves_[c.a].length), c.sa) > near)
      continue;
    for (const NodeCandidates::SplitPoint& q : candidates.split_points[c.b])
      if (q.node == p.node &&
          sampled_curves_[c.b].between(std::min(q.s, sampled_curves_[c.b].length), c.sb) <= near &&
          (c.a != c.b || sampled_curves_[c.a].between(p.s, q.s) > near))
        return true;
  }
  return false;
}

void NodeDiagnostics::report_near_miss(const Contact& c, bool rejected) {
  const Vec3 where = 0.5 * (sampled_curves_[c.a].point(c.ta) + sampled_curves_[c.b].point(c.tb));
  const auto names = names_of({c.a, c.b});
  const std::string what =
      names.size() == 1        ? "curve " + listed(names) + " comes close to itself"
      : c.ea >= 0 && c.eb >= 0 ? "ends of " + listed(names) + " are close to each other"
      : c.ea >= 0 || c.eb >= 0 ? "an end of '" + name_of(c.ea >= 0 ? c.a : c.b) +
                                     "' is close to '" + name_of(c.ea >= 0 ? c.b : c.a) + "'"
                               : "curves " + listed(names) + " pass close to each other";
  add(Kind::NearMiss, names, where, c.distance, false,
      what + " at " + format_point(where) + ", " + format_number(c.distance) + " apart" +
          (rejected ? ": not joined, the points there do not fit into one node within the gap "
                      "tolerance " +
                          format_number(tolerance_)
                    : ": not joined, the gap tolerance is " + format_number(tolerance_)));
}

void NodeDiagnostics::report_near_misses(const NodeCandidates& candidates,
                                         const Contacts& contacts) {
  // A node at which several ends meet reports another node once, and each curve once.
  std::set<std::tuple<bool, int, int>> reported;
  const auto miss = [&](const Contact& c, bool rejected) {
    if (meet_nearby(candidates, c)) return;
    const int p = c.ea >= 0 ? candidates.node_of[candidates.ends[c.a][c.ea]] : -1,
              q = c.eb >= 0 ? candidates.node_of[candidates.ends[c.b][c.eb]] : -1;
    if (p >= 0 && q >= 0 && !reported.insert({true, std::min(p, q), std::max(p, q)}).second) return;
    if (p >= 0 && q < 0 && !reported.insert({false, p, sampled_curves_[c.b].line}).second) return;
    if (q >= 0 && p < 0 && !reported.insert({false, q, sampled_curves_[c.a].line}).second) return;
    report_near_miss(c, rejected);
  };
  for (const MergeCandidate& l : candidates.rejected) {
    if (candidates.node_of[l.p] == candidates.node_of[l.q]) continue;
    const NodeCandidate &p = candidates.candidates[l.p], &q = candidates.candidates[l.q];
    Contact c{p.sampled_curve, q.sampled_curve};
    c.sa = p.s;
    c.sb = q.s;
    c.ta = sampled_curves_[p.sampled_curve].arc_length->parameter(p.s);
    c.tb = sampled_curves_[q.sampled_curve].arc_length->parameter(q.s);
    c.ea = p.end;
    c.eb = q.end;
    c.distance = l.distance;
    miss(c, true);
  }
  for (const Contact& c : contacts.near_misses) miss(c, false);
}

}  // namespace batten::detail
