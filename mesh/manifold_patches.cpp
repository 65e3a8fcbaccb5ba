#include "batten/mesh/manifold_patches.h"

#include <algorithm>

#include "batten/core/disjoint_sets.h"
#include "batten/core/isize.h"

namespace batten {
namespace {

/// One side of a triangle.
struct Side {
  std::array<int, 2> edge;  ///< low, high
  int triangle;
  bool forward;  ///< the triangle runs low → high
};

/// Whether two triangles that share an edge share one that ends at v.
bool share_edge_at(int v, const std::array<int, 3>& x, const std::array<int, 3>& y) {
  const auto in_y = [&](int w) { return std::find(y.begin(), y.end(), w) != y.end(); };
  return in_y(v) && std::any_of(x.begin(), x.end(), [&](int w) { return w != v && in_y(w); });
}

class ManifoldPatchFinder {
 public:
  ManifoldPatchFinder(const Points& points, ManifoldPatches& manifold_patches)
      : points_(points),
        manifold_patches_(manifold_patches),
        nodes_(manifold_patches.triangles),
        links_(nodes_.size()),
        on_non_manifold_edge_(static_cast<size_t>(points.rows()), 0) {}

  void find() {
    link_all();
    orient();
    split_fans();
    count_components();
  }

 private:
  /// The triangle across an edge, in the same sheet.
  struct Link {
    int other;
    bool flipped;  ///< it runs through the edge in the same direction
  };

  void link_all() {
    std::vector<Side> sides;
    for (int t = 0; t < isize(nodes_); ++t)
      for (int c = 0; c < 3; ++c) {
        const int a = nodes_[t][c], b = nodes_[t][(c + 1) % 3];
        sides.push_back({{std::min(a, b), std::max(a, b)}, t, a < b});
      }
    std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
      return std::pair(x.edge, x.triangle) < std::pair(y.edge, y.triangle);
    });
    for (auto first = sides.begin(); first != sides.end();) {
      auto last = first + 1;
      while (last != sides.end() && last->edge == first->edge) ++last;
      if (last - first == 2) link(*first, *(first + 1));
      if (last - first > 2) link_non_manifold_edge({first, last});
      first = last;
    }
  }

  void link(const Side& x, const Side& y) {
    const bool flipped = x.forward == y.forward;
    links_[x.triangle].push_back({y.triangle, flipped});
    links_[y.triangle].push_back({x.triangle, flipped});
  }

  void link_non_manifold_edge(std::vector<Side> sides) {
    manifold_patches_.non_manifold_edges.push_back(sides[0].edge);
    for (const int v : sides[0].edge) on_non_manifold_edge_[v] = 1;
    while (sides.size() >= 2) {
      const auto [i, j] = continuing_pair(sides);
      if (i < 0) return;
      link(sides[i], sides[j]);
      sides.erase(sides.begin() + j);
      sides.erase(sides.begin() + i);
    }
  }

  /// Which two of the triangles at a joint are one sheet that goes on; -1 for none, or where it is
  /// not clear.
  std::array<int, 2> continuing_pair(const std::vector<Side>& sides) const {
    const Vec3 from = points_.row(sides[0].edge[0]), to = points_.row(sides[0].edge[1]);
    const Vec3 along = (to - from).normalized();
    std::vector<Vec3> away;
    for (const Side& side : sides)
      for (const int v : nodes_[side.triangle])
        if (v != side.edge[0] && v != side.edge[1]) {
          const Vec3 d = points_.row(v).transpose() - from;
          away.push_back((d - along.dot(d) * along).normalized());
        }
    constexpr double bends_by_45_degrees = -0.70710678, clear = 0.05;
    std::array<int, 2> best{-1, -1};
    double straightest = bends_by_45_degrees;
    for (int j = 0; j < isize(sides); ++j)
      for (int i = 0; i < j; ++i)
        if (const double cosine = away[i].dot(away[j]); cosine < straightest) {
          straightest = cosine;
          best = {i, j};
        }
    for (const int kept : best)
      for (int other = 0; kept >= 0 && other < isize(sides); ++other)
        if (other != best[0] && other != best[1] &&
            away[kept].dot(away[other]) < straightest + clear)
          return {-1, -1};
    return best;
  }

  /// Turns triangles so that neighbours run through their common edge in opposite directions. Where
  /// that cannot be, the sheet is cut open.
  void orient() {
    std::vector<int> flip(nodes_.size(), -1), stack;
    for (size_t seed = 0; seed < flip.size(); ++seed) {
      if (flip[seed] >= 0) continue;
      ++manifold_patches_.count;
      flip[seed] = 0;
      stack.push_back(static_cast<int>(seed));
      while (!stack.empty()) {
        const int t = stack.back();
        stack.pop_back();
        for (const Link& link : links_[t]) {
          if (flip[link.other] >= 0) continue;
          flip[link.other] = flip[t] ^ static_cast<int>(link.flipped);
          stack.push_back(link.other);
        }
      }
    }
    for (int t = 0; t < isize(flip); ++t) cut_inconsistent_edges(t, flip);
    manifold_patches_.flipped.assign(flip.begin(), flip.end());
    for (size_t t = 0; t < flip.size(); ++t)
      if (flip[t] == 1) {
        std::swap(nodes_[t][1], nodes_[t][2]);
        std::swap(manifold_patches_.triangles[t][1], manifold_patches_.triangles[t][2]);
      }
  }

  void cut_inconsistent_edges(int t, const std::vector<int>& flip) {
    std::erase_if(links_[t], [&](const Link& link) {
      if (flip[link.other] == (flip[t] ^ static_cast<int>(link.flipped))) return false;
      manifold_patches_.cut_edges += t < link.other;
      for (const int v : nodes_[t])
        if (std::find(nodes_[link.other].begin(), nodes_[link.other].end(), v) !=
            nodes_[link.other].end())
          on_non_manifold_edge_[v] = 1;
      return true;
    });
  }

  /// Fans are triangles around a node that are linked by edges at it. The first keeps the node as
  /// its vertex, all others get one of their own.
  void split_fans() {
    const auto node_count = static_cast<int>(points_.rows());
    std::vector<std::vector<int>> around(node_count);
    for (int t = 0; t < isize(nodes_); ++t)
      for (const int v : nodes_[t]) around[v].push_back(t);
    std::vector<int> fan;
    std::vector<char> seen(nodes_.size(), 0);
    for (int v = 0; v < node_count; ++v) {
      int fans = 0;
      for (const int seed : around[v]) {
        if (seen[seed]) continue;
        const int own =
            ++fans == 1 ? v : node_count + isize(manifold_patches_.duplicate_vertex_nodes);
        if (own != v) manifold_patches_.duplicate_vertex_nodes.push_back(v);
        seen[seed] = 1;
        fan = {seed};
        for (size_t i = 0; i < fan.size(); ++i) {
          const int t = fan[i];
          for (int c = 0; c < 3; ++c)
            if (nodes_[t][c] == v) manifold_patches_.triangles[t][c] = own;
          for (const Link& link : links_[t]) {
            if (seen[link.other] || !share_edge_at(v, nodes_[t], nodes_[link.other])) continue;
            seen[link.other] = 1;
            fan.push_back(link.other);
          }
        }
      }
      if (fans > 1 && !on_non_manifold_edge_[v]) manifold_patches_.non_manifold_nodes.push_back(v);
      for (const int t : around[v]) seen[t] = 0;
    }
  }

  void count_components() {
    DisjointSets groups(on_non_manifold_edge_.size());
    for (const auto& t : nodes_)
      for (const int v : t) groups.unite(t[0], v);
    std::vector<int> roots;
    for (const auto& t : nodes_) roots.push_back(groups.find(t[0]));
    std::sort(roots.begin(), roots.end());
    manifold_patches_.component_count =
        static_cast<int>(std::unique(roots.begin(), roots.end()) - roots.begin());
  }

  const Points& points_;
  ManifoldPatches& manifold_patches_;
  std::vector<std::array<int, 3>> nodes_;   // of the triangles
  std::vector<std::vector<Link>> links_;    // of the triangles
  std::vector<char> on_non_manifold_edge_;  // nodes of edges where a sheet ends
};

}  // namespace

std::array<int, 3> ManifoldPatches::nodes_of(std::array<int, 3> triangle) const {
  const int node_count = vertex_count - isize(duplicate_vertex_nodes);
  for (int& v : triangle)
    if (v >= node_count) v = duplicate_vertex_nodes[v - node_count];
  return triangle;
}

ManifoldPatches find_manifold_patches(const Points& points,
                                      std::vector<std::array<int, 3>> triangles) {
  ManifoldPatches manifold_patches;
  manifold_patches.triangles = std::move(triangles);
  ManifoldPatchFinder(points, manifold_patches).find();
  manifold_patches.vertex_count =
      static_cast<int>(points.rows()) + isize(manifold_patches.duplicate_vertex_nodes);
  return manifold_patches;
}

}  // namespace batten
