#include "batten/skinning/network/network_nodes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "batten/core/groups.h"
#include "batten/core/index.h"
#include "batten/core/words.h"
#include "batten/skinning/network/node_findings.h"

namespace batten::netting {
namespace {

using Kind = NetworkFinding::Kind;
using Stop = NodeMarks::Stop;

class Builder {
 public:
  Builder(const Strands& all, const Contacts& contacts, double tolerance,
          const std::vector<CharacterLine>& lines, std::vector<NetworkFinding>& findings)
      : all_(all),
        strands_(all.strands),
        contacts_(contacts),
        tolerance_(tolerance),
        lines_(lines),
        findings_(all, tolerance, lines, findings) {}

  NodesAndCuts run() {
    make_marks();
    unite();
    collapse();
    cut();
    leave_out_short();
    tell_of_equals();
    leave_out_doubled();
    rejoin();
    findings_.tell_of_nodes(set_, result_);
    findings_.tell_of_misses(set_, contacts_);
    return std::move(result_);
  }

 private:
  // --- marks and links

  int interior_mark(int strand, double s) {
    set_.marks.push_back(
        {strand, s, -1, strands_[strand].point(strands_[strand].arc->parameter(s)), true});
    return count_of(set_.marks) - 1;
  }

  void link(int p, int q, double distance, bool contact) {
    // In steps, so that rounding does not decide between equal distances.
    links_.push_back({std::min(p, q), std::max(p, q),
                      std::llround(distance / tolerance_ * (1 << 20)), distance, contact});
  }

  void make_marks() {
    for (int k = 0; k < count_of(strands_); ++k) {
      set_.ends.push_back({-1, -1});
      for (int e = 0; e < 2 && !strands_[k].closed; ++e) {
        set_.ends[k][e] = count_of(set_.marks);
        set_.marks.push_back(
            {k, e ? strands_[k].length : 0, e, strands_[k].end_point(e), strands_[k].corner[e]});
      }
    }
    for (const auto& [p, q] : all_.corners)
      link(set_.ends[p.first][p.second], set_.ends[q.first][q.second], 0, false);
    for (const Contact& c : contacts_.joined) {
      const int p = c.ea >= 0 ? set_.ends[c.a][c.ea] : interior_mark(c.a, c.sa);
      const int q = c.eb >= 0 ? set_.ends[c.b][c.eb] : interior_mark(c.b, c.sb);
      if (p != q) link(p, q, c.distance, true);
    }
    // Places of one strand that lie within the tolerance along it.
    along_.resize(strands_.size());
    for (int m = 0; m < count_of(set_.marks); ++m) along_[set_.marks[m].strand].push_back(m);
    for (auto& along : along_) {
      std::sort(along.begin(), along.end(), [&](int p, int q) {
        return std::tie(set_.marks[p].s, p) < std::tie(set_.marks[q].s, q);
      });
      const size_t n = along.size();
      for (size_t i = 0; n > 1 && i < n; ++i) {
        const Strand& strand = strands_[set_.marks[along[i]].strand];
        if (i + 1 == n && !strand.closed) break;
        const int p = along[i], q = along[(i + 1) % n];
        const double gap = strand.between(set_.marks[p].s, set_.marks[q].s);
        if (gap <= tolerance_) link(p, q, gap, false);
      }
    }
    std::stable_sort(links_.begin(), links_.end(), [](const Link& p, const Link& q) {
      return std::tie(p.rank, p.p, p.q) < std::tie(q.rank, q.p, q.q);
    });
  }

  // --- nodes

  Vec3 middle_of(const std::vector<int>& marks) const {
    Vec3 own = Vec3::Zero(), any = Vec3::Zero();
    double owns = 0;
    for (const int m : marks) {
      any += set_.marks[m].point;
      if (set_.marks[m].own) own += set_.marks[m].point, owns += 1;
    }
    const Vec3 mean = owns > 0 ? Vec3(own / owns) : Vec3(any / static_cast<double>(marks.size()));
    // Places that agree keep their bits.
    const Vec3& first = set_.marks[marks[0]].point;
    return (mean - first).norm() <= 1e-14 * (all_.size + first.norm()) ? first : mean;
  }

  void unite() {
    const int n = count_of(set_.marks);
    Groups groups(n);
    set_.members.resize(n);
    for (int m = 0; m < n; ++m) set_.members[m] = {m};
    for (const Link& l : links_) {
      const int p = groups.of(l.p), q = groups.of(l.q);
      if (p == q) continue;
      std::vector<int> both;
      std::merge(set_.members[p].begin(), set_.members[p].end(), set_.members[q].begin(),
                 set_.members[q].end(), std::back_inserter(both));
      const double far = set_.radius(both, middle_of(both));
      if (far > (1 + 1e-9) * tolerance_) {
        if (l.contact) set_.refused.push_back(l);
        continue;
      }
      const int keep = std::min(p, q), gone = std::max(p, q);
      groups.join(p, q);
      set_.members[keep] = std::move(both);
      set_.members[gone].clear();
    }
    set_.node_of.assign(n, -1);
    std::vector<std::vector<int>> members;  // of each node
    for (int m = 0; m < n; ++m)
      if (!set_.members[m].empty()) {
        set_.node_of[m] = count_of(members);
        result_.nodes.push_back(middle_of(set_.members[m]));
        members.push_back(std::move(set_.members[m]));
      }
    for (int m = 0; m < n; ++m) set_.node_of[m] = set_.node_of[groups.of(m)];
    set_.members = std::move(members);
  }

  // --- pieces

  // Marks of a strand that follow each other and are of one node become one place.
  void collapse() {
    set_.stops.resize(strands_.size());
    for (int k = 0; k < count_of(strands_); ++k) {
      const Strand& strand = strands_[k];
      std::vector<std::vector<int>> groups;
      for (const int m : along_[k]) {
        if (!groups.empty() && set_.same_place(all_, groups.back().back(), m, tolerance_))
          groups.back().push_back(m);
        else
          groups.push_back({m});
      }
      if (strand.closed && groups.size() > 1 &&
          set_.same_place(all_, groups.back().back(), groups.front().front(), tolerance_)) {
        groups.front().insert(groups.front().begin(), groups.back().begin(), groups.back().end());
        groups.pop_back();
      }
      for (const auto& group : groups)
        if (!alone(group)) set_.stops[k].push_back(stop_of(strand, group));
      std::sort(set_.stops[k].begin(), set_.stops[k].end(),
                [](const Stop& p, const Stop& q) { return p.s < q.s; });
    }
  }

  // A place inside of a line at which nothing else came to be joined.
  bool alone(const std::vector<int>& group) {
    return std::none_of(group.begin(), group.end(),
                        [&](int m) { return set_.marks[m].end >= 0; }) &&
           set_.members[set_.node_of[group[0]]].size() == group.size();
  }

  Stop stop_of(const Strand& strand, const std::vector<int>& group) const {
    const int node = set_.node_of[group[0]];
    for (const int m : group)
      if (set_.marks[m].end >= 0) return {set_.marks[m].s, node};
    double s = set_.marks[group[group.size() / 2]].s;
    const Vec3 p = result_.nodes[node];
    if ((set_.marks[group[group.size() / 2]].point - p).norm() > 1e-13 * all_.size) {
      const double reach = 2 * tolerance_;
      const double low = strand.arc->parameter(std::max(0.0, s - reach)),
                   high = strand.arc->parameter(std::min(strand.length, s + reach));
      s = strand.arc->length_at(strand.foot(p, strand.arc->parameter(s), low, high));
    }
    return {s, node};
  }

  void cut() {
    for (int k = 0; k < count_of(strands_); ++k) {
      const Strand& strand = strands_[k];
      auto& stops = set_.stops[k];
      if (strand.closed) {
        if (stops.empty()) {
          stops.push_back({0, count_of(result_.nodes)});
          result_.nodes.push_back(strand.x.front());
        }
        stops.push_back({stops.front().s + strand.length, stops.front().node});
      }
      for (size_t i = 0; i + 1 < stops.size(); ++i)
        result_.cuts.push_back({k,
                                stops[i].s,
                                stops[i + 1].s,
                                {stops[i].node, stops[i + 1].node},
                                all_.equals[strand.line]});
      if (stops.size() < 2)
        findings_.tell(Kind::Short, {findings_.name_of(k)}, strand.x.front(), strand.length, true,
                       "line '" + findings_.name_of(k) + "' is " + number(strand.length) +
                           " long, less than the tolerance: left out");
    }
  }

  void leave_out_short() {
    for (bool again = true; again;) {
      again = false;
      const std::vector<int> degree = result_.degrees();
      std::vector<Cut> kept;
      for (const Cut& c : result_.cuts) {
        const bool loose = degree[c.nodes[0]] == 1 || degree[c.nodes[1]] == 1;
        if (c.s1 - c.s0 > tolerance_ || !loose) {
          kept.push_back(c);
          continue;
        }
        again = true;
        const Vec3 where = result_.nodes[c.nodes[degree[c.nodes[0]] == 1 ? 0 : 1]];
        findings_.tell(Kind::Short, {findings_.name_of(c.strand)}, where, c.s1 - c.s0, true,
                       "a loose piece of '" + findings_.name_of(c.strand) + "', " +
                           number(c.s1 - c.s0) + " long, at " + at(where) + ": left out");
      }
      result_.cuts = std::move(kept);
    }
    for (const Cut& c : result_.cuts)
      if (c.s1 - c.s0 <= tolerance_)
        findings_.tell(Kind::Short, {findings_.name_of(c.strand)}, result_.nodes[c.nodes[0]],
                       c.s1 - c.s0, false,
                       "a piece of '" + findings_.name_of(c.strand) + "' between two nodes at " +
                           at(result_.nodes[c.nodes[0]]) + " is only " + number(c.s1 - c.s0) +
                           " long");
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

  void tell_of_equals() {
    std::vector<char> told(lines_.size(), 0);
    for (const Strand& strand : strands_) {
      if (std::exchange(told[strand.line], 1)) continue;
      for (const int equal : all_.equals[strand.line]) {
        const std::string &a = lines_[equal].name, &b = lines_[strand.line].name;
        findings_.tell(Kind::Duplicate, {a, b}, strand.x[strand.x.size() / 2], 0, true,
                       "line '" + a + "' is equal to line '" + b + "': left out");
      }
    }
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
          auto& shared = result_.cuts[j].shared;
          shared.push_back(line);
          shared.insert(shared.end(), c.shared.begin(), c.shared.end());
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
        findings_.tell(Kind::Duplicate, {a, b}, where, 0, true,
                       "line '" + a + "' runs along line '" + b + "' from end to end: left out");
      else if (out != kept)
        findings_.tell(Kind::Overlap, {a, b}, where, 0, true,
                       "lines '" + a + "' and '" + b + "' run along each other near " + at(where) +
                           ": what they share is kept once");
      else
        findings_.tell(Kind::Overlap, {a}, where, 0, true,
                       "line '" + a + "' runs along itself near " + at(where) + ": kept once");
    }
    std::vector<Cut> cuts;
    for (size_t i = 0; i < gone.size(); ++i)
      if (!gone[i]) cuts.push_back(std::move(result_.cuts[i]));
    result_.cuts = std::move(cuts);
  }

  // Where what met a line was left out, the line is whole again.
  void rejoin() {
    const std::vector<int> degree = result_.degrees();
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

  const Strands& all_;
  const std::vector<Strand>& strands_;
  const Contacts& contacts_;
  const double tolerance_;
  const std::vector<CharacterLine>& lines_;
  NodeFindings findings_;

  NodeMarks set_;
  std::vector<std::vector<int>> along_;  // marks of a strand, along it
  std::vector<Link> links_;
  NodesAndCuts result_;
};

}  // namespace

std::vector<int> NodesAndCuts::degrees() const {
  std::vector<int> degree(nodes.size(), 0);
  for (const Cut& c : cuts)
    for (const int n : c.nodes) ++degree[n];
  return degree;
}

NodesAndCuts make_nodes(const Strands& strands, const Contacts& contacts, double tolerance,
                        const std::vector<CharacterLine>& lines,
                        std::vector<NetworkFinding>& findings) {
  return Builder(strands, contacts, tolerance, lines, findings).run();
}

}  // namespace batten::netting
