#include "batten/skinning/search/section_row.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include "batten/core/index.h"
#include "batten/core/words.h"
#include "batten/skinning/search/region_surfaces.h"

namespace batten {
namespace {

// What is compared of two sections.
struct Section {
  Vec3 middle = Vec3::Zero();  // mean of its points
  Vec3 direction;              // of an open one: from its start to its end
  std::vector<Vec3> points;
};

// The single arc of each line; empty where a line is cut or meets another one.
std::vector<int> lone_arcs(const CharacterLineNetwork& network) {
  std::vector<int> arc_of(network.lines().size(), -1), ends(network.nodes().size(), 0);
  for (int a = 0; a < count_of(network.arcs()); ++a) {
    const NetworkArc& arc = network.arcs()[a];
    if (arc_of[arc.line] >= 0) return {};
    arc_of[arc.line] = a;
    for (const int node : arc.nodes) ++ends[node];
  }
  for (const int a : arc_of)
    if (a < 0) return {};
  for (const int a : arc_of) {
    const NetworkArc& arc = network.arcs()[a];
    const int alone = arc.nodes[0] == arc.nodes[1] ? 2 : 1;
    if (ends[arc.nodes[0]] != alone || ends[arc.nodes[1]] != alone) return {};
  }
  return arc_of;
}

Section section_of(const NetworkArc& arc) {
  constexpr int samples = 64;
  Section section;
  for (int k = 0; k < samples; ++k)
    section.points.push_back(arc.curve.evaluate(arc.curve.end() * (k + 0.5) / samples));
  for (const Vec3& p : section.points) section.middle += p / samples;
  section.direction = arc.curve.evaluate(arc.curve.end()) - arc.curve.evaluate(0);
  return section;
}

// From the two nearest sections on, each time the nearest one to either end.
std::vector<int> chain(const std::vector<Section>& sections) {
  const int n = count_of(sections);
  const auto distance = [&](int a, int b) {
    return (sections[a].middle - sections[b].middle).norm();
  };
  int first = 0, second = 1;
  for (int a = 0; a < n; ++a)
    for (int b = a + 1; b < n; ++b)
      if (distance(a, b) < distance(first, second)) first = a, second = b;
  std::deque<int> row{first, second};
  while (count_of(row) < n) {
    int best = -1;
    bool front = false;
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < n; ++k) {
      if (std::find(row.begin(), row.end(), k) != row.end()) continue;
      for (const bool at_front : {true, false})
        if (const double d = distance(k, at_front ? row.front() : row.back()); d < least)
          least = d, best = k, front = at_front;
    }
    if (front)
      row.push_front(best);
    else
      row.push_back(best);
  }
  // From the line that was given first on, of the two at the ends.
  if (row.front() > row.back()) std::reverse(row.begin(), row.end());
  return {row.begin(), row.end()};
}

bool closed_face(const RegionGraph& graph, int a, int b, const Section& one, const Section& two) {
  constexpr double kApart = 0.05;  // of the radius: nearer planes are one
  if (!like_rims(graph, {{a, false}}, {{b, false}})) return false;
  Vec3 axis = Vec3::Zero();
  double radius = 0;
  for (size_t i = 0; i < one.points.size(); ++i) {
    const Vec3 p = one.points[i] - one.middle;
    axis += p.cross(one.points[(i + 1) % one.points.size()] - one.middle);
    radius += p.norm() / static_cast<double>(one.points.size());
  }
  return std::abs((two.middle - one.middle).dot(axis.normalized())) > kApart * radius;
}

bool open_face(const Section& one, const Section& two) {
  constexpr double kMostTurn = 45;                // degrees
  constexpr double kMostShift = 0.5, kMostRatio = 5;  // of lengths
  const double a = one.direction.norm(), b = two.direction.norm();
  if (!(a > 0 && b > 0) || std::max(a, b) > kMostRatio * std::min(a, b)) return false;
  const double turn = degrees_between(one.direction, two.direction);
  if (std::min(turn, 180 - turn) > kMostTurn) return false;
  const Vec3 apart = two.middle - one.middle;
  return std::abs(apart.dot(one.direction)) / a < kMostShift * std::max(a, b);
}

}  // namespace

std::vector<CharacterLine> section_row(const CharacterLineNetwork& network) {
  const std::vector<int> arcs = lone_arcs(network);
  if (arcs.size() < 2) return {};
  const auto closed = [&](int a) {
    return network.arcs()[a].nodes[0] == network.arcs()[a].nodes[1];
  };
  const auto count = std::count_if(arcs.begin(), arcs.end(), closed);
  if (count != 0 && (count != static_cast<long>(arcs.size()) || count < 3)) return {};
  for (const CharacterLine& line : network.lines())
    if (line.role != CharacterLine::Role::Outline) return {};
  std::vector<Section> sections;
  for (const int a : arcs) sections.push_back(section_of(network.arcs()[a]));
  const std::vector<int> order = chain(sections);
  const RegionGraph graph(network, RegionGraph::EndTangents::OfCurve);
  for (size_t k = 0; k + 1 < order.size(); ++k) {
    const int a = order[k], b = order[k + 1];
    if (count > 0 ? !closed_face(graph, arcs[a], arcs[b], sections[a], sections[b])
                  : !open_face(sections[a], sections[b]))
      return {};
  }
  std::vector<CharacterLine> row;
  for (const int k : order) row.push_back(network.lines()[k]);
  return row;
}

}  // namespace batten
