#include "batten/skinning/search/region_loops.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <queue>
#include <utility>

#include "batten/core/index.h"
#include "batten/core/parallel.h"
#include "batten/skinning/search/plane_loops.h"

namespace batten {
namespace {

using std::numbers::pi;
constexpr double kSide = 0.05;   // of each further arc: shorter loops come first
constexpr double kWorst = 1.25;  // ways that are worse by more are given up
constexpr int kLoops = 3, kMostArcs = 200, kMostWays = 600, kSameArc = 3;

// A set of arcs that may answer yes for one that is not in it.
class ArcFilter {
 public:
  void add(int arc) { bits_.set(place(arc)); }
  bool may_have(int arc) const { return bits_.test(place(arc)); }

 private:
  static size_t place(int arc) { return static_cast<std::uint32_t>(arc) * 2654435769u >> 24; }
  std::bitset<256> bits_;
};

// One arc of a way, linked to the one before.
struct Way {
  double cost;
  ArcUse use;
  Vec3 normal;  // at the end of the arc
  int before, length;
  ArcFilter arcs;  // of the whole way
};

// A turn from one arc into the next at a node.
struct Turn {
  ArcUse next;
  double price;
  Vec3 normal;  // at the start of the next arc
};

bool straight_on(const RegionGraph& graph, const ArcUse& in, const ArcUse& out) {
  const Vec3 a = graph.arriving(in), b = graph.leaving(out);
  return a.cross(b).norm() <= kCorner && a.dot(b) > 0;
}

// Uses of arcs that may lie on a loop without any corner. A use that nothing goes straight on from,
// or into, lies on none; that is taken away again and again. By 2 · arc + reversed. O(arcs).
std::vector<char> without_corner(const RegionGraph& graph) {
  const size_t count = 2 * graph.arcs.size();
  const auto number = [](const ArcUse& use) { return 2 * use.arc + use.reversed; };
  std::vector<std::vector<int>> after(count), before(count);
  for (const auto& ends : graph.ends)
    for (const ArcEnd& i : ends)
      for (const ArcEnd& j : ends) {
        const ArcUse in{i.arc, !i.end}, out{j.arc, j.end};
        if (i == j || !graph.core[i.arc] || !graph.core[j.arc] || !straight_on(graph, in, out))
          continue;
        after[number(in)].push_back(number(out));
        before[number(out)].push_back(number(in));
      }
  std::vector<char> left(count, 1);
  std::vector<int> ways_on(count), ways_here(count), gone;
  for (int u = 0; u < count_of(left); ++u) {
    ways_on[u] = count_of(after[u]);
    ways_here[u] = count_of(before[u]);
    if (ways_on[u] == 0 || ways_here[u] == 0) gone.push_back(u);
  }
  while (!gone.empty()) {
    const int u = gone.back();
    gone.pop_back();
    if (!std::exchange(left[u], 0)) continue;
    for (const int v : before[u])
      if (--ways_on[v] == 0) gone.push_back(v);
    for (const int v : after[u])
      if (--ways_here[v] == 0) gone.push_back(v);
  }
  return left;
}

class Tracer {
 public:
  Tracer(const RegionGraph& graph, const LoopPrices& prices, const std::vector<char>& smooth)
      : graph_(graph), prices_(prices), smooth_(smooth) {}

  // Loops around the corner from `in` to `out`, with the surface on the side of both.
  void trace(const ArcUse& in, const ArcUse& out, std::vector<ArcLoop>& loops) {
    const Vec3 a = graph_.arriving(in), b = graph_.leaving(out);
    const Vec3 axis = a.cross(b);
    if (axis.norm() > kCorner) return follow(in, out, axis.normalized(), loops);
    // A loop with a corner is found from there.
    if (a.dot(b) > 0 && !smooth_[2 * in.arc + in.reversed] && !smooth_[2 * out.arc + out.reversed])
      return;
    // Straight on: the side to which both arcs turn, and the other.
    const RegionArc &before = graph_.arcs[in.arc], &after = graph_.arcs[out.arc];
    const Vec3& node = graph_.nodes[graph_.node_before(out)];
    constexpr int middle = RegionArc::kPieces / 2;
    Vec3 turn = (before.points[middle] - node) / before.length +
                (after.points[middle] - node) / after.length;
    turn -= turn.dot(b) * b;
    if (turn.norm() < 1e-6) turn = after.across(out.reversed, 0);
    const Vec3 normal = b.cross(turn).normalized();
    follow(in, out, normal, loops);
    follow(in, out, -normal, loops);
  }

  bool complete() const { return complete_; }

 private:
  void follow(const ArcUse& in, const ArcUse& out, const Vec3& normal,
              std::vector<ArcLoop>& loops) {
    if (ArcLoop plane = loop_in_plane(graph_, in, out, normal); !plane.empty())
      loops.push_back(std::move(plane));
    ways_.clear();
    taken_.clear();
    using Next = std::pair<double, int>;
    std::priority_queue<Next, std::vector<Next>, std::greater<>> open;
    const auto add = [&](double cost, const ArcUse& use, const Vec3& at_start, int before) {
      const Vec3 at_end = graph_.arcs[use.arc].carried(use.reversed, at_start);
      const int length = before < 0 ? 1 : ways_[before].length + 1;
      ArcFilter arcs = before < 0 ? ArcFilter() : ways_[before].arcs;
      arcs.add(use.arc);
      ways_.push_back({cost, use, at_end, before, length, arcs});
      open.push({cost, count_of(ways_) - 1});
    };
    add(0, out, normal, -1);
    int found = 0;
    while (!open.empty()) {
      const int w = open.top().second;
      open.pop();
      const Way way = ways_[w];
      // The first loop may have any number of sides.
      if (way.cost > (found ? kWorst : kWorst + kSide * way.length)) break;
      if (count_of(ways_) > (found ? kMostWays : 5 * kMostWays)) {
        complete_ = complete_ && found > 0;
        break;
      }
      if (way.use == in) {
        loops.push_back(chain(w));
        if (++found == kLoops) break;
        continue;
      }
      if (way.length >= kMostArcs) continue;
      if (++taken_[2 * way.use.arc + way.use.reversed] > kSameArc) continue;
      list_turns(way);
      for (const Turn& turn : turns_) {
        if (passed(w, turn.next)) continue;
        double cost = way.cost + turn.price - turns_.front().price + kSide;
        if (turn.next == in) {
          // Home: what is missing between the normal that comes along and that of the start.
          const Vec3 end = graph_.arcs[in.arc].carried(in.reversed, turn.normal);
          const double twist = std::atan2(end.cross(normal).norm(), end.dot(normal));
          cost += prices_.twist * twist * twist / (pi * pi / 4);
        }
        if (cost <= kWorst + kSide * way.length) add(cost, turn.next, turn.normal, w);
      }
    }
  }

  // All ways on from the end of one, cheapest first.
  void list_turns(const Way& way) {
    const Vec3 in = graph_.arriving(way.use), back = -in;
    const Vec3 inwards = way.normal.cross(in);
    turns_.clear();
    angles_.clear();
    const int node = graph_.node_after(way.use);
    for (const ArcEnd& e : graph_.ends[node]) {
      if (!graph_.core[e.arc] || (e == ArcEnd{way.use.arc, !way.use.reversed})) continue;
      const Vec3 out = graph_.arcs[e.arc].out(e.end);
      const Vec3 axis = in.cross(out);
      const double sine = axis.norm();
      double angle = std::atan2(sine, back.dot(out)), twist = 0;
      Vec3 normal = way.normal;
      if (sine > kCorner) {
        normal = axis / sine;
        // Nearly upright to the surface so far: a corner turns inwards rather than outwards.
        if (normal.dot(way.normal) < -0.15) {
          normal = -normal;
          angle = 2 * pi - angle;
        }
        twist = std::acos(std::clamp(normal.dot(way.normal), -1.0, 1.0));
      } else if (in.dot(out) > 0) {
        normal = Eigen::Quaterniond::FromTwoVectors(in, out) * way.normal;
        const double along = std::atan2(out.dot(inwards), out.dot(back));
        angle = along < 0 ? along + 2 * pi : along;
      } else {
        normal = -way.normal;  // around a cusp
      }
      normal = (normal - normal.dot(out) * out).normalized();
      turns_.push_back(
          {{e.arc, e.end}, angle / pi + prices_.twist * twist * twist / (pi * pi / 4), normal});
      angles_.push_back({angle, std::abs(out.dot(way.normal))});
    }
    // Arcs that lie in the surface between.
    for (size_t i = 0; i < turns_.size(); ++i)
      for (size_t j = 0; j < turns_.size(); ++j)
        if (angles_[j].second < 0.5 && angles_[j].first > 0.15 &&
            angles_[j].first < angles_[i].first - 0.15)
          turns_[i].price += prices_.jump;
    std::stable_sort(turns_.begin(), turns_.end(),
                     [](const Turn& a, const Turn& b) { return a.price < b.price; });
  }

  // Whether a way has gone that arc in that direction, or back along one that is no bridge.
  bool passed(int w, const ArcUse& use) const {
    if (!ways_[w].arcs.may_have(use.arc)) return false;
    for (; w >= 0; w = ways_[w].before) {
      const ArcUse& other = ways_[w].use;
      if (other.arc == use.arc && (other.reversed == use.reversed || !graph_.bridge[use.arc]))
        return true;
    }
    return false;
  }

  ArcLoop chain(int w) const {
    ArcLoop loop;
    for (; w >= 0; w = ways_[w].before) loop.push_back(ways_[w].use);
    std::reverse(loop.begin(), loop.end());
    return loop;
  }

  const RegionGraph& graph_;
  const LoopPrices& prices_;
  const std::vector<char>& smooth_;  // without_corner()
  std::vector<Way> ways_;
  std::vector<Turn> turns_;
  std::vector<std::pair<double, double>> angles_;  // in the surface, out of it (sine)
  std::map<int, int> taken_;
  bool complete_ = true;
};

bool before(const ArcLoop& a, const ArcLoop& b) {
  const std::vector<int> x = arcs_of(a), y = arcs_of(b);
  return x != y ? x < y
                : std::lexicographical_compare(
                      a.begin(), a.end(), b.begin(), b.end(), [](const ArcUse& p, const ArcUse& q) {
                        return p.arc != q.arc ? p.arc < q.arc : p.reversed < q.reversed;
                      });
}

}  // namespace

TracedLoops traced_loops(const RegionGraph& graph, const LoopPrices& prices,
                         const Progress& progress) {
  constexpr int kNodes = 16;  // at a time
  const int count = count_of(graph.nodes), parts = (count + kNodes - 1) / kNodes;
  std::vector<std::vector<ArcLoop>> found(parts);
  std::vector<char> complete(parts, 1);
  progress.at("regions: loops", 0);
  const std::vector<char> smooth = without_corner(graph);
  parallel_parts(parts, [&](int part) {
    Tracer tracer(graph, prices, smooth);
    for (int n = part * kNodes; n < std::min((part + 1) * kNodes, count); ++n) {
      const auto& ends = graph.ends[n];
      for (size_t i = 0; i < ends.size(); ++i)
        for (size_t j = i + 1; j < ends.size(); ++j)
          if (graph.core[ends[i].arc] && graph.core[ends[j].arc])
            tracer.trace({ends[i].arc, !ends[i].end}, {ends[j].arc, ends[j].end}, found[part]);
    }
    for (ArcLoop& loop : found[part]) loop = canonical(loop);
    complete[part] = tracer.complete();
  });
  progress.at("regions: loops", 0.5);

  std::vector<ArcLoop> loops;
  for (auto& some : found) loops.insert(loops.end(), some.begin(), some.end());
  std::sort(loops.begin(), loops.end(), before);
  loops.erase(std::unique(loops.begin(), loops.end()), loops.end());

  TracedLoops traced;
  traced.complete = std::find(complete.begin(), complete.end(), 0) == complete.end();
  traced.loops.resize(loops.size());
  constexpr int kAtATime = 64;
  const int total = count_of(loops);
  parallel_parts((total + kAtATime - 1) / kAtATime, [&](int part) {
    for (int i = part * kAtATime; i < std::min((part + 1) * kAtATime, total); ++i)
      traced.loops[i] = measured(graph, loops[i], prices);
  });
  // The same arcs in another order are the same lines: the cheaper one stays.
  std::vector<LoopCandidate> once;
  for (LoopCandidate& c : traced.loops) {
    if (!once.empty() && arcs_of(once.back().loop) == arcs_of(c.loop)) {
      if (c.cost < once.back().cost - 1e-9) once.back() = std::move(c);
    } else {
      once.push_back(std::move(c));
    }
  }
  traced.loops = std::move(once);
  progress.at("regions: loops", 1);
  return traced;
}

}  // namespace batten
