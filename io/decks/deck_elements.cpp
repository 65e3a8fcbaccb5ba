// SPDX-License-Identifier: MPL-2.0
#include "batten/io/decks/deck_elements.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "batten/fem/triangle_locator.h"

namespace batten {
namespace {

// Splits each triangle into three quads between its corners, edge midpoints and centre.
class TriangleToQuads {
 public:
  explicit TriangleToQuads(DeckDiscretization& elements) : elements_(elements) {}

  void add_region(const SkinnedRegion& region, const QuadraticElements& facets,
                  const std::vector<int>& node) {
    surface_ = &region.surface;
    const TriangleLocator locator(surface_->mesh());
    locator_ = &locator;
    std::vector<std::vector<int>> quads;
    for (const auto& t : facets.triangles) {
      std::array<Vec2, 6> uv;
      for (int i = 0; i < 6; ++i)
        uv[i] = surface_->mesh().image_near(facets.uv[t[i]], facets.uv[t[0]]);
      // The map to (u, v) is quadratic, like the edges on curves.
      const auto at = [&](const Vec3& L) -> Vec2 {
        Vec2 p = Vec2::Zero();
        for (int i = 0; i < 3; ++i)
          p += L[i] * (2 * L[i] - 1) * uv[i] + 4 * L[i] * L[(i + 1) % 3] * uv[3 + i];
        return p;
      };
      const auto middle = [&](int i) -> Vec3 {  // midpoint of the edge that starts at corner i
        return 0.5 * (Vec3::Unit(i) + Vec3::Unit((i + 1) % 3));
      };
      const Vec3 centre = Vec3::Constant(1.0 / 3);
      const int at_centre = added(at(centre));
      std::array<int, 3> spoke;  // halfway between the centre and an edge midpoint
      for (int i = 0; i < 3; ++i) spoke[i] = added(at(0.5 * (centre + middle(i))));
      for (int i = 0; i < 3; ++i) {
        const int before = (i + 2) % 3;  // the edge that ends at corner i
        const int corner = node[t[i]], next = node[t[3 + i]], last = node[t[3 + before]];
        quads.push_back({corner, next, at_centre, last,
                         quarter(corner, next, at(0.5 * (Vec3::Unit(i) + middle(i)))), spoke[i],
                         spoke[before],
                         quarter(corner, last, at(0.5 * (Vec3::Unit(i) + middle(before))))});
      }
    }
    elements_.by_region.push_back(std::move(quads));
  }

 private:
  int added(const Vec2& uv) {
    elements_.positions.push_back(
        surface_->position(locator_->locate(surface_->mesh().wrapped(uv))));
    return static_cast<int>(elements_.positions.size()) - 1;
  }
  // Shared by both triangles, and both faces, of an edge.
  int quarter(int corner, int middle, const Vec2& uv) {
    const auto known = elements_.quarters.find({corner, middle});
    if (known != elements_.quarters.end()) return known->second;
    return elements_.quarters[{corner, middle}] = added(uv);
  }

  DeckDiscretization& elements_;
  const Surface* surface_ = nullptr;
  const TriangleLocator* locator_ = nullptr;
};

}  // namespace

std::vector<int> DeckDiscretization::nodes_on(const std::vector<std::array<int, 3>>& edges) const {
  std::vector<int> nodes;
  const auto add = [&](int node) {
    if (std::find(nodes.begin(), nodes.end(), node) == nodes.end()) nodes.push_back(node);
  };
  for (const auto& edge : edges) {
    add(edge[0]);
    add(edge[1]);
  }
  for (const auto& edge : edges) {
    add(edge[2]);
    for (const int end : {edge[0], edge[1]}) {
      const auto between = quarters.find({end, edge[2]});
      if (between != quarters.end()) add(between->second);
    }
  }
  return nodes;
}

std::map<int, Vec3> DeckDiscretization::tangents(const ModelElements& model,
                                                 const std::string& line) const {
  std::map<int, Vec3> tangents;
  for (const auto& of : model.lines) {
    if (of.name != line) continue;
    for (const auto& [a, b, m] : of.edges) {
      const Vec3 xa = positions[a], xb = positions[b], xm = positions[m];
      // Derivative of the parabola through the nodes at a fraction s.
      const auto at = [&](double s) -> Vec3 {
        return ((4 * s - 3) * xa + (4 * s - 1) * xb + (4 - 8 * s) * xm).normalized();
      };
      tangents.try_emplace(a, at(0));
      tangents.try_emplace(b, at(1));
      tangents.try_emplace(m, at(0.5));
      for (const auto& [end, s] : {std::pair{a, 0.25}, std::pair{b, 0.75}})
        if (const auto between = quarters.find({end, m}); between != quarters.end())
          tangents.try_emplace(between->second, at(s));
    }
  }
  return tangents;
}

int nearest_node(const std::vector<Vec3>& positions, const Vec3& p) {
  const auto nearest = std::min_element(
      positions.begin(), positions.end(),
      [&](const Vec3& a, const Vec3& b) { return (a - p).squaredNorm() < (b - p).squaredNorm(); });
  return static_cast<int>(nearest - positions.begin());
}

DeckDiscretization deck_elements(const std::vector<const SkinnedRegion*>& regions,
                                 const ModelElements& model, ShellDeck::Element element) {
  DeckDiscretization elements;
  elements.positions = model.positions;
  TriangleToQuads quads(elements);
  for (size_t r = 0; r < regions.size(); ++r) {
    if (element == ShellDeck::Element::S8R) {
      quads.add_region(*regions[r], model.regions[r], model.node[r]);
      continue;
    }
    std::vector<std::vector<int>> all;
    for (const auto& t : model.regions[r].triangles) {
      std::vector<int> n;
      for (const int i : t) n.push_back(model.node[r][i]);
      if (element == ShellDeck::Element::S6) {
        all.push_back(n);
      } else {
        for (int i = 0; i < 3; ++i) all.push_back({n[i], n[3 + i], n[3 + (i + 2) % 3]});
        all.push_back({n[3], n[4], n[5]});
      }
    }
    elements.by_region.push_back(std::move(all));
  }
  return elements;
}

}  // namespace batten
