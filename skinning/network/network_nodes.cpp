#include "batten/skinning/network/network_nodes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

#include "batten/core/words.h"

namespace batten::netting {
namespace {

using Kind = NetworkFinding::Kind;

/// A place of a strand that may become part of a node.
struct Mark {
  int strand = 0;
  double s = 0;
  int end = -1;  ///< 0, 1: of the strand; -1: inside of it
  Vec3 point;
  bool own = false;  ///< inside of its line, or a corner of it: the line passes through
};

struct Link {
  int p, q;  ///< marks
  long long rank;
  double distance;
  bool contact;
};

class Builder {
 public:
  Builder(const Strands& all, const Contacts& contacts, double tolerance,
          const std::vector<CharacterLine>& lines, std::vector<NetworkFinding>& findings)
      : all_(all),
        strands_(all.strands),
        contacts_(contacts),
        tolerance_(tolerance),
        lines_(lines),
        findings_(findings) {}

  NodesAndCuts run() {
    make_marks();
    unite();
    collapse();
    cut();
    leave_out_short();
    leave_out_doubled();
    rejoin();
    tell_of_nodes();
    tell_of_misses();
    return std::move(result_);
  }

 private:
  const std::string& name_of(int strand) const { return lines_[strands_[strand].line].name; }

  void tell(Kind kind, std::vector<std::string> names, const Vec3& where, double distance,
            bool repaired, const std::string& text) {
    findings_.push_back({kind, std::move(names), where, distance, repaired, text});
  }

  // --- marks and links

  int interior_mark(int strand, double s) {
    marks_.push_back(
        {strand, s, -1, strands_[strand].point(strands_[strand].arc->parameter(s)), true});
    return static_cast<int>(marks_.size()) - 1;
  }

  void link(int p, int q, double distance, bool contact) {
    // In steps, so that rounding does not decide between equal distances.
    links_.push_back({std::min(p, q), std::max(p, q),
                      std::llround(distance / tolerance_ * (1 << 20)), distance, contact});
  }

  void make_marks() {
    for (int k = 0; k < static_cast<int>(strands_.size()); ++k) {
      ends_.push_back({-1, -1});
      for (int e = 0; e < 2 && !strands_[k].closed; ++e) {
        ends_[k][e] = static_cast<int>(marks_.size());
        marks_.push_back(
            {k, e ? strands_[k].length : 0, e, strands_[k].end_point(e), strands_[k].corner[e]});
      }
    }
    for (const auto& [p, q] : all_.corners)
      link(ends_[p.first][p.second], ends_[q.first][q.second], 0, false);
    for (const Contact& c : contacts_.joined) {
      const int p = c.ea >= 0 ? ends_[c.a][c.ea] : interior_mark(c.a, c.sa);
      const int q = c.eb >= 0 ? ends_[c.b][c.eb] : interior_mark(c.b, c.sb);
      if (p != q) link(p, q, c.distance, true);
    }
    // Places of one strand that lie within the tolerance along it.
    along_.resize(strands_.size());
    for (int m = 0; m < static_cast<int>(marks_.size()); ++m) along_[marks_[m].strand].push_back(m);
    for (auto& along : along_) {
      std::sort(along.begin(), along.end(),
                [&](int p, int q) { return std::tie(marks_[p].s, p) < std::tie(marks_[q].s, q); });
      const size_t n = along.size();
      for (size_t i = 0; n > 1 && i < n; ++i) {
        const Strand& strand = strands_[marks_[along[i]].strand];
        if (i + 1 == n && !strand.closed) break;
        const int p = along[i], q = along[(i + 1) % n];
        const double gap = strand.between(marks_[p].s, marks_[q].s);
        if (gap <= tolerance_) link(p, q, gap, false);
      }
    }
    std::stable_sort(links_.begin(), links_.end(), [](const Link& p, const Link& q) {
      return std::tie(p.rank, p.p, p.q) < std::tie(q.rank, q.p, q.q);
    });
  }

  // --- nodes

  int find(int mark) {
    while (root_[mark] != mark) mark = root_[mark] = root_[root_[mark]];
    return mark;
  }

  Vec3 middle_of(const std::vector<int>& marks) const {
    Vec3 own = Vec3::Zero(), any = Vec3::Zero();
    double owns = 0;
    for (const int m : marks) {
      any += marks_[m].point;
      if (marks_[m].own) own += marks_[m].point, owns += 1;
    }
    const Vec3 mean = owns > 0 ? Vec3(own / owns) : Vec3(any / static_cast<double>(marks.size()));
    // Places that agree keep their bits.
    const Vec3& first = marks_[marks[0]].point;
    return (mean - first).norm() <= 1e-14 * (all_.size + first.norm()) ? first : mean;
  }

  double radius(const std::vector<int>& marks, const Vec3& p) const {
    double far = 0;
    for (const int m : marks) far = std::max(far, (marks_[m].point - p).norm());
    return far;
  }

  void unite() {
    const int n = static_cast<int>(marks_.size());
    root_.resize(n);
    std::iota(root_.begin(), root_.end(), 0);
    members_.resize(n);
    for (int m = 0; m < n; ++m) members_[m] = {m};
    for (const Link& l : links_) {
      const int p = find(l.p), q = find(l.q);
      if (p == q) continue;
      std::vector<int> both;
      std::merge(members_[p].begin(), members_[p].end(), members_[q].begin(), members_[q].end(),
                 std::back_inserter(both));
      const double far = radius(both, middle_of(both));
      if (far > (1 + 1e-9) * tolerance_) {
        if (l.contact) refused_.push_back(l);
        continue;
      }
      const int keep = std::min(p, q), gone = std::max(p, q);
      root_[gone] = keep;
      members_[keep] = std::move(both);
      members_[gone].clear();
    }
    node_of_.assign(n, -1);
    for (int m = 0; m < n; ++m)
      if (find(m) == m) {
        node_of_[m] = static_cast<int>(result_.nodes.size());
        result_.nodes.push_back(middle_of(members_[m]));
      }
    for (int m = 0; m < n; ++m) node_of_[m] = node_of_[find(m)];
  }

  // --- pieces

  struct Stop {
    double s;
    int node;
  };

  // Marks of a strand that follow each other and are of one node become one place.
  void collapse() {
    stops_.resize(strands_.size());
    for (int k = 0; k < static_cast<int>(strands_.size()); ++k) {
      const Strand& strand = strands_[k];
      std::vector<std::vector<int>> groups;
      for (const int m : along_[k]) {
        if (!groups.empty() && same_place(groups.back().back(), m))
          groups.back().push_back(m);
        else
          groups.push_back({m});
      }
      if (strand.closed && groups.size() > 1 &&
          same_place(groups.back().back(), groups.front().front())) {
        groups.front().insert(groups.front().begin(), groups.back().begin(), groups.back().end());
        groups.pop_back();
      }
      for (const auto& group : groups)
        if (!alone(group)) stops_[k].push_back(stop_of(strand, group));
      std::sort(stops_[k].begin(), stops_[k].end(),
                [](const Stop& p, const Stop& q) { return p.s < q.s; });
    }
  }

  // A place inside of a line at which nothing else came to be joined.
  bool alone(const std::vector<int>& group) {
    return std::none_of(group.begin(), group.end(), [&](int m) { return marks_[m].end >= 0; }) &&
           members_[find(group[0])].size() == group.size();
  }

  bool same_place(int p, int q) const {
    return node_of_[p] == node_of_[q] &&
           strands_[marks_[p].strand].between(marks_[p].s, marks_[q].s) <= 4 * tolerance_;
  }

  Stop stop_of(const Strand& strand, const std::vector<int>& group) const {
    const int node = node_of_[group[0]];
    for (const int m : group)
      if (marks_[m].end >= 0) return {marks_[m].s, node};
    double s = marks_[group[group.size() / 2]].s;
    const Vec3 p = result_.nodes[node];
    if ((marks_[group[group.size() / 2]].point - p).norm() > 1e-13 * all_.size) {
      const double reach = 2 * tolerance_;
      const double low = strand.arc->parameter(std::max(0.0, s - reach)),
                   high = strand.arc->parameter(std::min(strand.length, s + reach));
      s = strand.arc->length_at(strand.foot(p, strand.arc->parameter(s), low, high));
    }
    return {s, node};
  }

  void cut() {
    for (int k = 0; k < static_cast<int>(strands_.size()); ++k) {
      const Strand& strand = strands_[k];
      auto& stops = stops_[k];
      if (strand.closed) {
        if (stops.empty()) {
          stops.push_back({0, static_cast<int>(result_.nodes.size())});
          result_.nodes.push_back(strand.x.front());
        }
        stops.push_back({stops.front().s + strand.length, stops.front().node});
      }
      for (size_t i = 0; i + 1 < stops.size(); ++i)
        result_.cuts.push_back(
            {k, stops[i].s, stops[i + 1].s, {stops[i].node, stops[i + 1].node}, {}});
      if (stops.size() < 2)
        tell(Kind::Short, {name_of(k)}, strand.x.front(), strand.length, true,
             "line '" + name_of(k) + "' is " + number(strand.length) +
                 " long, less than the tolerance: left out");
    }
  }

  std::vector<int> degrees() const {
    std::vector<int> degree(result_.nodes.size(), 0);
    for (const Cut& c : result_.cuts)
      for (const int n : c.nodes) ++degree[n];
    return degree;
  }

  void leave_out_short() {
    for (bool again = true; again;) {
      again = false;
      const std::vector<int> degree = degrees();
      std::vector<Cut> kept;
      for (const Cut& c : result_.cuts) {
        const bool loose = degree[c.nodes[0]] == 1 || degree[c.nodes[1]] == 1;
        if (c.s1 - c.s0 > tolerance_ || !loose) {
          kept.push_back(c);
          continue;
        }
        again = true;
        const Vec3 where = result_.nodes[c.nodes[degree[c.nodes[0]] == 1 ? 0 : 1]];
        tell(Kind::Short, {name_of(c.strand)}, where, c.s1 - c.s0, true,
             "a loose piece of '" + name_of(c.strand) + "', " + number(c.s1 - c.s0) + " long, at " +
                 at(where) + ": left out");
      }
      result_.cuts = std::move(kept);
    }
    for (const Cut& c : result_.cuts)
      if (c.s1 - c.s0 <= tolerance_)
        tell(Kind::Short, {name_of(c.strand)}, result_.nodes[c.nodes[0]], c.s1 - c.s0, false,
             "a piece of '" + name_of(c.strand) + "' between two nodes at " +
                 at(result_.nodes[c.nodes[0]]) + " is only " + number(c.s1 - c.s0) + " long");
  }

  Vec3 point_of(const Cut& c, double fraction) const {
    const Strand& strand = strands_[c.strand];
    double s = c.s0 + fraction * (c.s1 - c.s0);
    if (s > strand.length) s -= strand.length;
    return strand.point(strand.arc->parameter(s));
  }

  // Whether all of `c` lies near `other`, both having the same nodes.
  bool runs_along(const Cut& c, const Cut& other, bool back) const {
    const Strand& strand = strands_[other.strand];
    constexpr int samples = 16;
    for (int k = 1; k < samples; ++k) {
      const double f = static_cast<double>(k) / samples;
      const Vec3 p = point_of(c, f);
      double best = (point_of(other, back ? 1 - f : f) - p).norm();
      double s = other.s0 + (back ? 1 - f : f) * (other.s1 - other.s0);
      if (s > strand.length) s -= strand.length;
      const double t = strand.foot(p, strand.arc->parameter(s), strand.t.front(), strand.t.back());
      best = std::min(best, (strand.point(t) - p).norm());
      if (best > 1.5 * tolerance_) return false;
    }
    return true;
  }

  bool doubled(const Cut& c, const Cut& kept) const {
    const double a = c.s1 - c.s0, b = kept.s1 - kept.s0;
    if (std::abs(a - b) > 0.1 * std::max(a, b) + 4 * tolerance_) return false;
    for (const bool back : {false, true}) {
      if (c.nodes[0] != kept.nodes[back] || c.nodes[1] != kept.nodes[!back]) continue;
      if (runs_along(c, kept, back) && runs_along(kept, c, back)) return true;
    }
    return false;
  }

  void leave_out_doubled() {
    std::map<std::pair<int, int>, std::vector<size_t>> between;
    std::vector<char> gone(result_.cuts.size(), 0);
    std::map<int, int> pieces, lost;                // of a line
    std::map<std::pair<int, int>, size_t> overlap;  // lines, left out and kept: first such piece
    for (const Cut& c : result_.cuts) ++pieces[strands_[c.strand].line];
    for (size_t i = 0; i < result_.cuts.size(); ++i) {
      Cut& c = result_.cuts[i];
      auto& others = between[std::minmax(c.nodes[0], c.nodes[1])];
      for (const size_t j : others)
        if (doubled(c, result_.cuts[j])) {
          gone[i] = 1;
          const int line = strands_[c.strand].line;
          ++lost[line];
          result_.cuts[j].shared.push_back(line);
          overlap.try_emplace({line, strands_[result_.cuts[j].strand].line}, i);
          break;
        }
      if (!gone[i]) others.push_back(i);
    }
    std::vector<std::pair<size_t, std::pair<int, int>>> told;  // in canonical order
    for (const auto& [which, i] : overlap) told.push_back({i, which});
    std::sort(told.begin(), told.end());
    for (const auto& [i, which] : told) {
      const auto& [out, kept] = which;
      const Vec3 where = point_of(result_.cuts[i], 0.5);
      const std::string &a = lines_[out].name, &b = lines_[kept].name;
      if (out != kept && lost[out] == pieces[out])
        tell(Kind::Duplicate, {a, b}, where, 0, true,
             "line '" + a + "' runs along line '" + b + "' from end to end: left out");
      else if (out != kept)
        tell(Kind::Overlap, {a, b}, where, 0, true,
             "lines '" + a + "' and '" + b + "' run along each other near " + at(where) +
                 ": what they share is kept once");
      else
        tell(Kind::Overlap, {a}, where, 0, true,
             "line '" + a + "' runs along itself near " + at(where) + ": kept once");
    }
    std::vector<Cut> cuts;
    for (size_t i = 0; i < gone.size(); ++i)
      if (!gone[i]) cuts.push_back(std::move(result_.cuts[i]));
    result_.cuts = std::move(cuts);
  }

  // Where what met a line was left out, the line is whole again.
  void rejoin() {
    const std::vector<int> degree = degrees();
    std::vector<Cut> cuts;
    for (Cut& c : result_.cuts) {
      if (!cuts.empty() && cuts.back().strand == c.strand && cuts.back().s1 == c.s0 &&
          degree[c.nodes[0]] == 2 && c.nodes[0] != c.nodes[1] && cuts.back().shared == c.shared) {
        cuts.back().s1 = c.s1;
        cuts.back().nodes[1] = c.nodes[1];
      } else {
        cuts.push_back(std::move(c));
      }
    }
    result_.cuts = std::move(cuts);
  }

  // --- what was found

  static std::string listed(const std::vector<std::string>& names) {
    std::string text;
    for (size_t i = 0; i < names.size(); ++i)
      text += (i == 0 ? "'" : i + 1 == names.size() ? " and '" : ", '") + names[i] + "'";
    return text;
  }

  // Names of strands without repetition, in canonical order.
  std::vector<std::string> names_of(const std::vector<int>& strands) const {
    std::vector<std::string> names;
    for (const int k : strands)
      if (std::find(names.begin(), names.end(), name_of(k)) == names.end())
        names.push_back(name_of(k));
    return names;
  }

  void tell_of_nodes() {
    const std::vector<int> left = degrees();
    for (int m = 0; m < static_cast<int>(marks_.size()); ++m) {
      if (find(m) != m || members_[m].size() < 2) continue;
      const int node = node_of_[m];
      const Vec3 p = result_.nodes[node];
      std::vector<int> ends, through;  // strands
      std::vector<int> end_marks, passes;
      for (const int k : members_[m]) {
        if (!marks_[k].own || marks_[k].end >= 0) end_marks.push_back(k);
        if (marks_[k].end >= 0 && !marks_[k].own) ends.push_back(marks_[k].strand);
        if (marks_[k].end < 0) {
          // Several marks of one pass count once.
          if (std::none_of(passes.begin(), passes.end(), [&](int o) {
                return marks_[o].strand == marks_[k].strand && same_place(o, k);
              })) {
            passes.push_back(k);
            through.push_back(marks_[k].strand);
          }
        }
      }
      double gap = 0;
      for (const int a : end_marks)
        for (const int b : end_marks)
          gap = std::max(gap, (marks_[a].point - marks_[b].point).norm());
      std::vector<int> at_end;
      for (const int k : end_marks) at_end.push_back(marks_[k].strand);
      if (at_end.size() > 1 && gap > 1e-9 * all_.size)
        tell(Kind::EndsJoined, names_of(at_end), p, gap, true,
             "ends of " + listed(names_of(at_end)) + " lay " + number(gap) + " apart at " + at(p) +
                 ": joined");
      // A strand that ends here does not pass through beside it.
      std::vector<int> passing;
      for (size_t i = 0; i < through.size(); ++i)
        if (std::none_of(end_marks.begin(), end_marks.end(), [&](int e) {
              return marks_[e].strand == through[i] && same_place(e, passes[i]);
            }))
          passing.push_back(through[i]);
      if (left[node] == 0 || passing.empty()) continue;
      const double far = radius(members_[m], p);
      if (!at_end.empty()) {
        std::vector<int> all = at_end;
        all.insert(all.end(), passing.begin(), passing.end());
        tell(Kind::EndOnLine, names_of(all), p, far, true,
             (at_end.size() > 1 ? "ends of " : "an end of ") + listed(names_of(at_end)) + " meet" +
                 (at_end.size() > 1 ? "" : "s") + " the middle of " + listed(names_of(passing)) +
                 " at " + at(p) + ": cut there");
      } else if (passing.size() > 1) {
        const auto names = names_of(passing);
        const bool self = names.size() == 1;
        tell(self ? Kind::SelfCrossing : Kind::Crossing, names, p, 2 * far, true,
             (self ? "line " + listed(names) + " crosses itself"
                   : "lines " + listed(names) + " cross") +
                 " at " + at(p) + ": cut there");
      }
    }
    for (const Cut& c : result_.cuts)
      for (int e = 0; e < 2; ++e)
        if (left[c.nodes[e]] == 1) {
          const Vec3 p = result_.nodes[c.nodes[e]];
          tell(Kind::Dangling, {name_of(c.strand)}, p, 0, false,
               "an end of '" + name_of(c.strand) + "' at " + at(p) + " meets nothing");
        }
  }

  // Whether two strands have a common node near the places of a contact.
  bool meet_nearby(const Contact& c) const {
    const double near = 10 * tolerance_;
    for (const Stop& p : stops_[c.a]) {
      if (strands_[c.a].between(std::min(p.s, strands_[c.a].length), c.sa) > near) continue;
      for (const Stop& q : stops_[c.b])
        if (q.node == p.node &&
            strands_[c.b].between(std::min(q.s, strands_[c.b].length), c.sb) <= near &&
            (c.a != c.b || strands_[c.a].between(p.s, q.s) > near))
          return true;
    }
    return false;
  }

  void tell_of_misses() {
    // A node where several ends meet misses another node once, and a line once.
    std::set<std::tuple<bool, int, int>> told;
    const auto miss = [&](const Contact& c, bool refused) {
      if (meet_nearby(c)) return;
      const int p = c.ea >= 0 ? node_of_[ends_[c.a][c.ea]] : -1,
                q = c.eb >= 0 ? node_of_[ends_[c.b][c.eb]] : -1;
      if (p >= 0 && q >= 0 && !told.insert({true, std::min(p, q), std::max(p, q)}).second) return;
      if (p >= 0 && q < 0 && !told.insert({false, p, strands_[c.b].line}).second) return;
      if (q >= 0 && p < 0 && !told.insert({false, q, strands_[c.a].line}).second) return;
      const Vec3 where = 0.5 * (strands_[c.a].point(c.ta) + strands_[c.b].point(c.tb));
      const auto names = names_of({c.a, c.b});
      const std::string what =
          names.size() == 1        ? "line " + listed(names) + " comes back to itself"
          : c.ea >= 0 && c.eb >= 0 ? "ends of " + listed(names) + " come near each other"
          : c.ea >= 0 || c.eb >= 0 ? "an end of '" + name_of(c.ea >= 0 ? c.a : c.b) +
                                         "' comes near '" + name_of(c.ea >= 0 ? c.b : c.a) + "'"
                                   : "lines " + listed(names) + " pass near each other";
      tell(Kind::NearMiss, names, where, c.distance, false,
           what + " at " + at(where) + ", " + number(c.distance) + " apart" +
               (refused ? ": what lies there does not fit into one node within the tolerance of " +
                              number(tolerance_)
                        : ": not joined, the tolerance is " + number(tolerance_)));
    };
    for (const Link& l : refused_) {
      if (node_of_[l.p] == node_of_[l.q]) continue;
      const Mark &p = marks_[l.p], &q = marks_[l.q];
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
    for (const Contact& c : contacts_.missed) miss(c, false);
  }

  const Strands& all_;
  const std::vector<Strand>& strands_;
  const Contacts& contacts_;
  const double tolerance_;
  const std::vector<CharacterLine>& lines_;
  std::vector<NetworkFinding>& findings_;

  std::vector<Mark> marks_;
  std::vector<std::array<int, 2>> ends_;  // marks of a strand's ends
  std::vector<std::vector<int>> along_;   // marks of a strand, along it
  std::vector<Link> links_, refused_;
  std::vector<int> root_, node_of_;
  std::vector<std::vector<int>> members_;
  std::vector<std::vector<Stop>> stops_;
  NodesAndCuts result_;
};

}  // namespace

NodesAndCuts make_nodes(const Strands& strands, const Contacts& contacts, double tolerance,
                        const std::vector<CharacterLine>& lines,
                        std::vector<NetworkFinding>& findings) {
  return Builder(strands, contacts, tolerance, lines, findings).run();
}

}  // namespace batten::netting
