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
  std::vector<BlendEdge> edges;
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
      chain.edges.push_back(edges[e]);
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

// A point at which a curve between the chains ends, with the direction in which it leaves the face.
struct BlendPoint {
  Vec3 point, across;
};

CharacterLine between(const std::string& name, const BlendPoint& a, const BlendPoint& b,
                      double tension, CharacterLine::Role role) {
  const double length = tension * (a.point - b.point).norm();
  Points positions(2, 3), derivatives(2, 3);
  positions.row(0) = a.point.transpose();
  positions.row(1) = b.point.transpose();
  derivatives.row(0) = length * a.across.transpose();
  derivatives.row(1) = -length * b.across.transpose();
  return {name, curve_from_hermite(HermiteCurve({0, 1}, positions, derivatives)), role};
}

// An open chain as a polyline of the given face's samples, from its open end number `first`.
class ChainPath {
 public:
  ChainPath(const Chain& chain, size_t first) : chain_(chain), first_(first) {
    std::vector<BlendEdge> rest = chain.edges;
    Vec3 end = chain.ends[first];
    while (!rest.empty()) {
      const auto distance = [&](const BlendEdge& edge) {
        return std::min((edge.ends[0] - end).norm(), (edge.ends[1] - end).norm());
      };
      const auto next = std::min_element(
          rest.begin(), rest.end(),
          [&](const BlendEdge& a, const BlendEdge& b) { return distance(a) < distance(b); });
      std::vector<NeighbourSample> samples = next->samples;
      if ((next->ends[1] - end).norm() < (next->ends[0] - end).norm())
        std::reverse(samples.begin(), samples.end());
      end = samples.back().point;
      samples_.insert(samples_.end(), samples.begin(), samples.end());
      rest.erase(next);
    }
    length_.push_back(0);
    for (size_t i = 1; i < samples_.size(); ++i)
      length_.push_back(length_.back() + (samples_[i].point - samples_[i - 1].point).norm());
  }

  double length() const { return length_.back(); }

  // The point at a fraction of the length. The slope of its direction along the chain is interpolated
  // between those at the ends.
  BlendPoint at(double fraction) const {
    const double s = fraction * length();
    const auto above = std::upper_bound(length_.begin() + 1, length_.end() - 1, s);
    const auto i = static_cast<size_t>(above - length_.begin());
    const NeighbourSample &a = samples_[i - 1], &b = samples_[i];
    const double step = length_[i] - length_[i - 1], t = step > 0 ? (s - length_[i - 1]) / step : 0;
    const Vec3 along = (b.point - a.point).normalized();
    Vec3 out = -((1 - t) * a.into + t * b.into);
    out = (out - out.dot(along) * along).normalized();
    const double slope = (1 - fraction) * end_slope(0) + fraction * end_slope(1);
    return {(1 - t) * a.point + t * b.point, (out + slope * along).normalized()};
  }

 private:
  double end_slope(size_t end) const {
    const size_t last = samples_.size() - 1;
    const NeighbourSample& sample = samples_[end == 0 ? 0 : last];
    const Vec3 along = (end == 0 ? samples_[1].point - samples_[0].point
                                 : samples_[last].point - samples_[last - 1].point)
                           .normalized();
    const Vec3& across = chain_.across[end == 0 ? first_ : 1 - first_];
    return across.dot(along) / std::max(-across.dot(sample.into), 0.1);
  }

  const Chain& chain_;
  size_t first_;
  std::vector<NeighbourSample> samples_;
  std::vector<double> length_;
};

}  // namespace

BlendEdge blend_edge(const NeighbourFaces& faces, int index) {
  const NeighbourCurve& given = faces.neighbours[static_cast<size_t>(index)];
  const NeighbourSample &first = given.samples.front(), &last = given.samples.back();
  BlendEdge edge{faces.lines[static_cast<size_t>(index)].name,
                 {first.point, last.point},
                 {-first.into, -last.into},
                 given.samples};
  constexpr double most_deg = 60;
  for (int other = 0; other < isize(faces.neighbours); ++other) {
    const NeighbourCurve& beside = faces.neighbours[static_cast<size_t>(other)];
    if (other == index || beside.name != given.name) continue;
    const InputCurve& curve = *faces.lines[static_cast<size_t>(other)].curve;
    for (const bool at_end : {false, true})
      for (size_t end = 0; end < 2; ++end) {
        const double t = at_end ? curve.end() : curve.start();
        if ((curve.evaluate(t) - edge.ends[end]).norm() > kSamePoint * faces.size) continue;
        const Vec3 direction = (at_end ? 1 : -1) * curve.evaluate(t, 1).normalized();
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
  using Role = CharacterLine::Role;
  for (const size_t end : {0, 1}) {
    const size_t other = end == 0 ? to : 1 - to;
    blend.curves.push_back(between("side " + std::to_string(end + 1), {a.ends[end], a.across[end]},
                                   {b.ends[other], b.across[other]}, pull, Role::Outline));
  }
  blend.region.loops = {a.names};
  std::vector<std::string>& loop = blend.region.loops.front();
  loop.insert(loop.end(), b.names.begin(), b.names.end());
  loop.insert(loop.end(), {"side 1", "side 2"});
  const ChainPath one(a, 0), two(b, to);
  const double ratio = 2 * (one.length() + two.length()) / (apart(0, to) + apart(1, 1 - to));
  const int count = std::clamp(static_cast<int>(std::ceil(ratio)), 2, 16) - 1;
  for (int k = 1; k <= count; ++k) {
    const double fraction = k / (count + 1.0);
    blend.curves.push_back(between("inner " + std::to_string(k), one.at(fraction), two.at(fraction),
                                   pull, Role::Inner));
    blend.region.inner.push_back(blend.curves.back().name);
  }
  return blend;
}

}  // namespace batten
