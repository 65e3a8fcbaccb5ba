#include "batten/mesh/features/border_chain.h"

#include <algorithm>

namespace batten {
namespace {

// A side of a triangle: the edge opposite to `corner`.
struct Side {
  int triangle, corner;
};

class BorderWalk {
 public:
  BorderWalk(const MeshTopology& topology, const std::vector<char>& inside)
      : topology_(topology), inside_(inside), taken_(3 * inside.size(), 0) {}

  std::vector<BorderChain> chains() {
    std::vector<Side> sides;
    for (int t = 0; t < topology_.triangle_count(); ++t)
      for (int c = 0; c < 3; ++c)
        if (on_border({t, c})) sides.push_back({t, c});
    std::vector<BorderChain> result;
    for (const Side& side : sides)  // open chains from their first side
      if (!taken(side) && previous(side).triangle < 0) result.push_back(walk(side));
    for (const Side& side : sides)
      if (!taken(side)) result.push_back(walk(side));
    for (BorderChain& chain : result)
      if (chain.closed) {
        auto& v = chain.vertices;
        std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
      }
    std::sort(result.begin(), result.end(),
              [](const BorderChain& a, const BorderChain& b) { return a.vertices < b.vertices; });
    return result;
  }

 private:
  char& taken(const Side& s) { return taken_[3 * s.triangle + s.corner]; }

  // Sides are those of triangles inside, walked as the triangles outside run.
  bool on_border(const Side& s) const {
    if (!inside_[s.triangle]) return false;
    const int other = topology_.across(s.triangle, s.corner);
    return other >= 0 && !inside_[other];
  }

  int first(const Side& s) const { return topology_.triangles()[s.triangle][(s.corner + 2) % 3]; }
  int last(const Side& s) const { return topology_.triangles()[s.triangle][(s.corner + 1) % 3]; }

  int corner_of(int triangle, int vertex) const {
    const auto& t = topology_.triangles()[triangle];
    return static_cast<int>(std::find(t.begin(), t.end(), vertex) - t.begin());
  }

  // Turns around an end of a side through triangles inside up to the next border side; triangle -1
  // where the mesh ends before. `step` is the side to leave a triangle by, seen from the vertex's
  // corner: 1 turns around the last vertex, 2 around the first.
  Side pivot(const Side& s, int vertex, int step) const {
    for (int t = s.triangle;;) {
      const Side exit{t, (corner_of(t, vertex) + step) % 3};
      const int other = topology_.across(exit.triangle, exit.corner);
      if (other < 0) return {-1, -1};
      if (!inside_[other]) return exit;
      t = other;
    }
  }
  Side next(const Side& s) const { return pivot(s, last(s), 1); }
  Side previous(const Side& s) const { return pivot(s, first(s), 2); }

  BorderChain walk(Side side) {
    BorderChain chain;
    for (;;) {
      taken(side) = 1;
      chain.vertices.push_back(first(side));
      const Side following = next(side);
      if (following.triangle < 0) {
        chain.vertices.push_back(last(side));
        chain.closed = false;
        return chain;
      }
      if (taken(following)) return chain;
      side = following;
    }
  }

  const MeshTopology& topology_;
  const std::vector<char>& inside_;
  std::vector<char> taken_;
};

}  // namespace

std::vector<BorderChain> border_chains(const MeshTopology& topology,
                                       const std::vector<char>& inside) {
  return BorderWalk(topology, inside).chains();
}

}  // namespace batten
