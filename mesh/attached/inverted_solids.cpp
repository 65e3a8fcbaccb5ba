#include "batten/mesh/attached/inverted_solids.h"

#include <algorithm>
#include <array>

#include "batten/core/isize.h"

namespace batten {
namespace {

/// The three neighbours of each corner, right-handed in a sound element.
using Corner = std::array<int, 4>;
constexpr std::array<Corner, 4> kTetrahedron{
    {{0, 1, 2, 3}, {1, 2, 0, 3}, {2, 0, 1, 3}, {3, 1, 0, 2}}};
constexpr std::array<Corner, 4> kPyramid{{{0, 1, 3, 4}, {1, 2, 0, 4}, {2, 3, 1, 4}, {3, 0, 2, 4}}};
constexpr std::array<Corner, 6> kWedge{
    {{0, 1, 2, 3}, {1, 2, 0, 4}, {2, 0, 1, 5}, {3, 5, 4, 0}, {4, 3, 5, 1}, {5, 4, 3, 2}}};
constexpr std::array<Corner, 8> kHexahedron{{{0, 1, 3, 4},
                                             {1, 2, 0, 5},
                                             {2, 3, 1, 6},
                                             {3, 0, 2, 7},
                                             {4, 7, 5, 0},
                                             {5, 4, 6, 1},
                                             {6, 5, 7, 2},
                                             {7, 6, 4, 3}}};

std::span<const Corner> corners_of(int count) {
  switch (count) {
    case 4:
      return kTetrahedron;
    case 5:
      return kPyramid;
    case 6:
      return kWedge;
    case 8:
      return kHexahedron;
    default:
      return {};
  }
}

double volume(const Points& p, const std::vector<int>& nodes, const Corner& c) {
  const auto edge = [&](int k) -> Vec3 {
    return (p.row(nodes[c[k]]) - p.row(nodes[c[0]])).transpose();
  };
  return edge(1).cross(edge(2)).dot(edge(3));
}

}  // namespace

int corner_count(const NonShellElement& solid) {
  if (solid.kind != NonShellElement::Kind::Solid) return 0;
  switch (solid.nodes.size()) {
    case 4:
    case 10:
      return 4;
    case 5:
    case 13:
      return 5;
    case 6:
    case 15:
      return 6;
    case 8:
    case 20:
    case 27:
      return 8;
    default:
      return 0;
  }
}

std::vector<int> inverted_solids(std::span<const NonShellElement> elements, const Points& before,
                                 const Points& after) {
  std::vector<int> result;
  for (int e = 0; e < isize(elements); ++e) {
    const auto corners = corners_of(corner_count(elements[e]));
    double largest = 0;
    for (const Corner& c : corners)
      largest = std::max(largest, std::abs(volume(before, elements[e].nodes, c)));
    if (std::any_of(corners.begin(), corners.end(), [&](const Corner& c) {
          const double v0 = volume(before, elements[e].nodes, c);
          return std::abs(v0) > 1e-9 * largest && !(volume(after, elements[e].nodes, c) * v0 > 0);
        }))
      result.push_back(e);
  }
  return result;
}

}  // namespace batten
