#include "batten/skinning/network/node_findings.h"

#include <algorithm>
#include <set>
#include <tuple>

#include "batten/core/words.h"

namespace batten::netting {
namespace {

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "'" : i + 1 == names.size() ? " and '" : ", '") + names[i] + "'";
  return text;
}

}  // namespace

double NodeMarks::radius(const std::vector<int>& some, const Vec3& p) const {
  double far = 0;
  for (const int m : some) far = std::max(far, (marks[m].point - p).norm());
  return far;
}

bool NodeMarks::same_place(const Strands& all, int p, int q, double tolerance) const {
  return node_of[p] == node_of[q] &&
         all.strands[marks[p].strand].between(marks[p].s, marks[q].s) <= 4 * tolerance;
}

void NodeFindings::tell(Kind kind, std::vector<std::string> names, const Vec3& where,
                        double distance, bool repaired, const std::string& text) {
  findings_.push_back({kind, std::move(names), where, distance, repaired, text});
}

// Names of strands without repetition, in canonical order.
std::vector<std::string> NodeFindings::names_of(const std::vector<int>& strands) const {
  std::vector<std::string> names;
  for (const int k : strands)
    if (std::find(names.begin(), names.end(), name_of(k)) == names.end())
      names.push_back(name_of(k));
  return names;
}

void NodeFindings::tell_of_nodes(const NodeMarks& marks, const NodesAndCuts& result) {
  const std::vector<int> left = result.degrees();
  for (size_t n = 0; n < marks.members.size(); ++n)
    if (marks.members[n].size() > 1)
      tell_of_node(marks, marks.members[n], result.nodes[n], left[n] == 0);
  tell_of_dangling(result, left);
}

void NodeFindings::tell_of_node(const NodeMarks& all, const std::vector<int>& members,
                                const Vec3& p, bool left_out) {
  const std::vector<Mark>& marks = all.marks;
  std::vector<int> end_marks, passes, at_end, passing;  // marks, then strands
  for (const int k : members) {
    if (!marks[k].own || marks[k].end >= 0) end_marks.push_back(k);
    // Several marks of one pass count once.
    if (marks[k].end < 0 && std::none_of(passes.begin(), passes.end(), [&](int o) {
          return marks[o].strand == marks[k].strand && all.same_place(all_, o, k, tolerance_);
        }))
      passes.push_back(k);
  }
  double gap = 0;
  for (const int a : end_marks)
    for (const int b : end_marks) gap = std::max(gap, (marks[a].point - marks[b].point).norm());
  for (const int k : end_marks) at_end.push_back(marks[k].strand);
  if (at_end.size() > 1 && gap > 1e-9 * all_.size)
    tell(Kind::EndsJoined, names_of(at_end), p, gap, true,
         "ends of " + listed(names_of(at_end)) + " lay " + number(gap) + " apart at " + at(p) +
             ": joined");
  // A strand that ends here does not pass through beside it.
  for (const int k : passes)
    if (std::none_of(end_marks.begin(), end_marks.end(), [&](int e) {
          return marks[e].strand == marks[k].strand && all.same_place(all_, e, k, tolerance_);
        }))
      passing.push_back(marks[k].strand);
  if (left_out || passing.empty()) return;
  const double far = all.radius(members, p);
  if (!at_end.empty()) {
    std::vector<int> both = at_end;
    both.insert(both.end(), passing.begin(), passing.end());
    tell(Kind::EndOnLine, names_of(both), p, far, true,
         (at_end.size() > 1 ? "ends of " : "an end of ") + listed(names_of(at_end)) + " meet" +
             (at_end.size() > 1 ? "" : "s") + " the middle of " + listed(names_of(passing)) +
             " at " + at(p) + ": cut there");
  } else if (passing.size() > 1) {
    const auto names = names_of(passing);
    const bool self = names.size() == 1;
    tell(
        self ? Kind::SelfCrossing : Kind::Crossing, names, p, 2 * far, true,
        (self ? "line " + listed(names) + " crosses itself" : "lines " + listed(names) + " cross") +
            " at " + at(p) + ": cut there");
  }
}

void NodeFindings::tell_of_dangling(const NodesAndCuts& result, const std::vector<int>& degrees) {
  for (const Cut& c : result.cuts)
    for (int e = 0; e < 2; ++e)
      if (degrees[c.nodes[e]] == 1) {
        const Vec3 p = result.nodes[c.nodes[e]];
        tell(Kind::Dangling, {name_of(c.strand)}, p, 0, false,
             "an end of '" + name_of(c.strand) + "' at " + at(p) + " meets nothing");
      }
}

// Whether two strands have a common node near the places of a contact.
bool NodeFindings::meet_nearby(const NodeMarks& marks, const Contact& c) const {
  const double near = 10 * tolerance_;
  for (const NodeMarks::Stop& p : marks.stops[c.a]) {
    if (strands_[c.a].between(std::min(p.s, strands_[c.a].length), c.sa) > near) continue;
    for (const NodeMarks::Stop& q : marks.stops[c.b])
      if (q.node == p.node &&
          strands_[c.b].between(std::min(q.s, strands_[c.b].length), c.sb) <= near &&
          (c.a != c.b || strands_[c.a].between(p.s, q.s) > near))
        return true;
  }
  return false;
}

void NodeFindings::tell_of_miss(const Contact& c, bool refused) {
  const Vec3 where = 0.5 * (strands_[c.a].point(c.ta) + strands_[c.b].point(c.tb));
  const auto names = names_of({c.a, c.b});
  const std::string what =
      names.size() == 1        ? "line " + listed(names) + " comes back to itself"
      : c.ea >= 0 && c.eb >= 0 ? "ends of " + listed(names) + " come near each other"
      : c.ea >= 0 || c.eb >= 0 ? "an end of '" + name_of(c.ea >= 0 ? c.a : c.b) + "' comes near '" +
                                     name_of(c.ea >= 0 ? c.b : c.a) + "'"
                               : "lines " + listed(names) + " pass near each other";
  tell(Kind::NearMiss, names, where, c.distance, false,
       what + " at " + at(where) + ", " + number(c.distance) + " apart" +
           (refused ? ": what lies there does not fit into one node within the tolerance of " +
                          number(tolerance_)
                    : ": not joined, the tolerance is " + number(tolerance_)));
}

void NodeFindings::tell_of_misses(const NodeMarks& marks, const Contacts& contacts) {
  // A node where several ends meet misses another node once, and a line once.
  std::set<std::tuple<bool, int, int>> told;
  const auto miss = [&](const Contact& c, bool refused) {
    if (meet_nearby(marks, c)) return;
    const int p = c.ea >= 0 ? marks.node_of[marks.ends[c.a][c.ea]] : -1,
              q = c.eb >= 0 ? marks.node_of[marks.ends[c.b][c.eb]] : -1;
    if (p >= 0 && q >= 0 && !told.insert({true, std::min(p, q), std::max(p, q)}).second) return;
    if (p >= 0 && q < 0 && !told.insert({false, p, strands_[c.b].line}).second) return;
    if (q >= 0 && p < 0 && !told.insert({false, q, strands_[c.a].line}).second) return;
    tell_of_miss(c, refused);
  };
  for (const Link& l : marks.refused) {
    if (marks.node_of[l.p] == marks.node_of[l.q]) continue;
    const Mark &p = marks.marks[l.p], &q = marks.marks[l.q];
    Contact c{p.strand, q.strand};
    c.sa = p.s;
    c.sb = q.s;
    c.ta = strands_[p.strand].arc->parameter(p.s);
    c.tb = strands_[q.strand].arc->parameter(q.s);
    c.ea = p.end;
    c.eb = q.end;
    c.distance = l.distance;
    miss(c, true);
  }
  for (const Contact& c : contacts.missed) miss(c, false);
}

}  // namespace batten::netting
