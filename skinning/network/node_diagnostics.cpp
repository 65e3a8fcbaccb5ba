#include "batten/skinning/network/node_diagnostics.h"

#include <algorithm>
#include <set>
#include <tuple>

#include "batten/core/format.h"

namespace batten::detail {
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

// Names of strands without repetition, in canonical order.
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
  std::vector<int> end_marks, passes, at_end, passing;  // marks, then strands
  for (const int k : members) {
    if (!candidates[k].own || candidates[k].end >= 0) end_marks.push_back(k);
    // Several marks of one pass count once.
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
        "ends of " + listed(names_of(at_end)) + " lay " + format_number(gap) + " apart at " +
            format_point(p) + ": joined");
  // A strand that ends here does not pass through beside it.
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
        (at_end.size() > 1 ? "ends of " : "an end of ") + listed(names_of(at_end)) + " meet" +
            (at_end.size() > 1 ? "" : "s") + " the middle of " + listed(names_of(passing)) +
            " at " + format_point(p) + ": cut there");
  } else if (passing.size() > 1) {
    const auto names = names_of(passing);
    const bool self = names.size() == 1;
    add(self ? Kind::SelfCrossing : Kind::Crossing, names, p, 2 * far, true,
        (self ? "line " + listed(names) + " crosses itself" : "lines " + listed(names) + " cross") +
            " at " + format_point(p) + ": cut there");
  }
}

void NodeDiagnostics::report_dangling_ends(const NetworkTopology& result,
                                           const std::vector<int>& degrees) {
  for (const CurveInterval& c : result.intervals)
    for (int e = 0; e < 2; ++e)
      if (degrees[c.nodes[e]] == 1) {
        const Vec3 p = result.nodes[c.nodes[e]];
        add(Kind::Dangling, {name_of(c.sampled_curve)}, p, 0, false,
            "an end of '" + name_of(c.sampled_curve) + "' at " + format_point(p) +
                " meets nothing");
      }
}

// Whether two strands have a common node near the places of a contact.
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
      names.size() == 1        ? "line " + listed(names) + " comes back to itself"
      : c.ea >= 0 && c.eb >= 0 ? "ends of " + listed(names) + " come near each other"
      : c.ea >= 0 || c.eb >= 0 ? "an end of '" + name_of(c.ea >= 0 ? c.a : c.b) + "' comes near '" +
                                     name_of(c.ea >= 0 ? c.b : c.a) + "'"
                               : "lines " + listed(names) + " pass near each other";
  add(Kind::NearMiss, names, where, c.distance, false,
      what + " at " + format_point(where) + ", " + format_number(c.distance) + " apart" +
          (rejected ? ": what lies there does not fit into one node within the tolerance of " +
                          format_number(tolerance_)
                    : ": not joined, the tolerance is " + format_number(tolerance_)));
}

void NodeDiagnostics::report_near_misses(const NodeCandidates& candidates,
                                         const Contacts& contacts) {
  // A node where several ends meet misses another node once, and a line once.
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
