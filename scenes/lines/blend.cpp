// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/lines/blend.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fairing/curves/input_curve.h"
#include "batten/fem/curves/hermite_curve.h"
#include "batten/io/files/text.h"

namespace batten {
namespace {

constexpr double kSamePoint = 1e-6;  // of the size

// Edges that meet in common end points, in any order.
struct Chain {
  std::vector<std::string> names;
  std::vector<Vec3> ends, across;  // of its two open ends; none if it is closed
};

std::vector<Chain> chains_of(const std::vector<BlendEdge>& edges) {
  double size = 0;
  for (const BlendEdge& a : edges)
    for (const BlendEdge& b : edges) size = std::max(size, (a.ends[0] - b.ends[1]).norm());
  const auto same = [&](const Vec3& a, const Vec3& b) {
    return (a - b).norm() <= kSamePoint * size;
  };
  DisjointSets sets(isize(edges));
  for (int a = 0; a < isize(edges); ++a)
    for (int b = 0; b < a; ++b)
      for (const Vec3& x : edges[a].ends)
        for (const Vec3& y : edges[b].ends)
          if (same(x, y)) sets.unite(a, b);
  std::vector<Chain> chains;
  for (int root = 0; root < isize(edges); ++root) {
    if (sets.find(root) != root) continue;
    Chain& chain = chains.emplace_back();
    for (int e = 0; e < isize(edges); ++e) {
      if (sets.find(e) != root) continue;
      chain.names.push_back(edges[e].name);
      for (size_t end = 0; end < 2; ++end) {
        // An end that no other end of the chain meets is open.
        int meeting = 0;
        for (int other = 0; other < isize(edges); ++other)
          for (size_t k = 0; k < 2; ++k)
            meeting += (other != e || k != end) && same(edges[other].ends[k], edges[e].ends[end]);
        if (meeting > 0) continue;
        chain.ends.push_back(edges[e].ends[end]);
        chain.across.push_back(edges[e].across[end]);
      }
    }
  }
  return chains;
}

CharacterLine side(const std::string& name, const Chain& a, size_t i, const Chain& b, size_t j,
                   double tension) {
  const double length = tension * (a.ends[i] - b.ends[j]).norm();
  Points positions(2, 3), derivatives(2, 3);
  positions.row(0) = a.ends[i].transpose();
  positions.row(1) = b.ends[j].transpose();
  derivatives.row(0) = length * a.across[i].transpose();
  derivatives.row(1) = -length * b.across[j].transpose();
  return {name, curve_from_hermite(HermiteCurve({0, 1}, positions, derivatives)),
          CharacterLine::Role::Outline};
}

}  // namespace

BlendEdge blend_edge(const NeighbourFaces& faces, int index) {
  const NeighbourCurve& given = faces.neighbours[static_cast<size_t>(index)];
  const NeighbourSample &first = given.samples.front(), &last = given.samples.back();
  BlendEdge edge{faces.lines[static_cast<size_t>(index)].name,
                 {first.point, last.point},
                 {-first.into, -last.into}};
  constexpr double most_deg = 60;
  for (int other = 0; other < isize(faces.neighbours); ++other) {
    const NeighbourCurve& beside = faces.neighbours[static_cast<size_t>(other)];
    if (other == index || beside.name != given.name) continue;
    const auto& s = beside.samples;
    for (const auto& [at, next] : {std::pair{s[0], s[1]}, {s[s.size() - 1], s[s.size() - 2]}})
      for (size_t end = 0; end < 2; ++end) {
        if ((at.point - edge.ends[end]).norm() > kSamePoint * faces.size) continue;
        const Vec3 direction = (at.point - next.point).normalized();
        const Vec3 across = end == 0 ? -first.into : -last.into;
        if (degrees_between(direction, across) < most_deg) edge.across[end] = direction;
      }
  }
  return edge;
}

Blend blend_between(const std::vector<BlendEdge>& edges, double tension) {
  const std::vector<Chain> chains = chains_of(edges);
  const auto open_ends = [&](size_t k) { return chains[k].ends.size(); };
  if (chains.size() != 2)
    throw InputError("found " + format_count(isize(edges), "edge") + " in " +
                     format_count(isize(chains), "chain") +
                     ", expected two chains of edges that do not touch");
  if (open_ends(0) != open_ends(1) || open_ends(0) % 2 != 0 || open_ends(0) > 2)
    throw InputError("found chains of edges with " + std::to_string(open_ends(0)) + " and " +
                     std::to_string(open_ends(1)) +
                     " open ends, expected two open chains, or two closed ones");
  Blend blend;
  blend.region.name = "blend";
  if (open_ends(0) == 0) {
    if (tension > 0)
      throw InputError("found a tension for a blend between closed edges, expected open edges");
    blend.region.annulus = true;
    blend.region.loops = {chains[0].names, chains[1].names};
    return blend;
  }
  const Chain &a = chains[0], &b = chains[1];
  const auto apart = [&](size_t i, size_t j) { return (a.ends[i] - b.ends[j]).norm(); };
  const size_t to = apart(0, 0) + apart(1, 1) <= apart(0, 1) + apart(1, 0) ? 0 : 1;
  const double pull = tension > 0 ? tension : 1;
  blend.sides = {side("side 1", a, 0, b, to, pull), side("side 2", a, 1, b, 1 - to, pull)};
  blend.region.loops = {a.names};
  std::vector<std::string>& loop = blend.region.loops.front();
  loop.insert(loop.end(), b.names.begin(), b.names.end());
  loop.insert(loop.end(), {"side 1", "side 2"});
  return blend;
}

}  // namespace batten
