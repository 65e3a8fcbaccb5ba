// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/surfaces/section_region.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fairing/curves/curve_through_points.h"

namespace batten {
namespace {

// Of the larger radius and of the distance along the normal; beyond both, sections lie side by side.
constexpr double kMaxLateralOffset = 1, kMaxLateralSlope = 2;
constexpr double kNearlyClosed = 0.25;  // gap between the ends of an open section, of its radius

// Data by which sections are compared.
struct Section {
  Vec3 middle = Vec3::Zero();  // mean of its points
  Vec3 direction;              // from start to end (open sections)
  std::vector<Vec3> points;
};

// The only network edge of each curve; empty if a curve is split or meets another one.
std::vector<int> isolated_edges(const CurveNetwork& network) {
  std::vector<int> edge_of(network.lines().size(), -1), ends(network.nodes().size(), 0);
  for (int a = 0; a < isize(network.edges()); ++a) {
    const NetworkEdge& edge = network.edges()[a];
    if (edge_of[edge.line] >= 0) return {};
    edge_of[edge.line] = a;
    for (const int node : edge.nodes) ++ends[node];
  }
  for (const int a : edge_of)
    if (a < 0) return {};
  for (const int a : edge_of) {
    const NetworkEdge& edge = network.edges()[a];
    const int alone = edge.nodes[0] == edge.nodes[1] ? 2 : 1;
    if (ends[edge.nodes[0]] != alone || ends[edge.nodes[1]] != alone) return {};
  }
  return edge_of;
}

std::vector<Vec3> section_samples(const NetworkEdge& edge, bool closed) {
  constexpr int kSamples = 64;
  std::vector<Vec3> points;
  for (int k = 0; k < kSamples; ++k)
    points.push_back(
        edge.curve.evaluate(edge.curve.end() * k / (closed ? kSamples : kSamples - 1)));
  return points;
}

Section section_of(const std::vector<Vec3>& points) {
  Section section;
  section.points = points;
  for (const Vec3& p : points) section.middle += p / static_cast<double>(points.size());
  section.direction = points.back() - points.front();
  return section;
}

// Orders the sections: starts with the two closest ones and appends the nearest section at either
// end.
std::vector<int> chain(const std::vector<Section>& sections) {
  const int n = isize(sections);
  const auto distance = [&](int a, int b) {
    return (sections[a].middle - sections[b].middle).norm();
  };
  int first = 0, second = 1;
  for (int a = 0; a < n; ++a)
    for (int b = a + 1; b < n; ++b)
      if (distance(a, b) < distance(first, second)) first = a, second = b;
  std::deque<int> row{first, second};
  while (isize(row) < n) {
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
  // Start at the end whose curve comes first in the input.
  if (row.front() > row.back()) std::reverse(row.begin(), row.end());
  return {row.begin(), row.end()};
}

// Plane normal of a closed section, and the mean distance of its points from their mean.
std::pair<Vec3, double> plane_of(const Section& section) {
  Vec3 normal = Vec3::Zero();
  double radius = 0;
  for (size_t i = 0; i < section.points.size(); ++i) {
    const Vec3 p = section.points[i] - section.middle;
    normal += p.cross(section.points[(i + 1) % section.points.size()] - section.middle);
    radius += p.norm() / static_cast<double>(section.points.size());
  }
  return {normal.normalized(), radius};
}

bool closed_face(const Section& one, const Section& two) {
  constexpr double kMinSpacing = 0.05;  // of the smaller radius; closer planes count as one
  constexpr double kMaxAngleDeg = 60;   // degrees between the planes
  const auto [normal, radius] = plane_of(one);
  auto [other, other_radius] = plane_of(two);
  if (normal.dot(other) < 0) other = -other;
  if (degrees_between(normal, other) > kMaxAngleDeg) return false;
  const Vec3 along = (normal + other).normalized(), apart = two.middle - one.middle;
  const double aside = (apart - apart.dot(along) * along).norm();
  const double spacing = std::abs(apart.dot(along));
  return aside < std::max(std::max(radius, other_radius) * kMaxLateralOffset,
                          spacing * kMaxLateralSlope) &&
         spacing > kMinSpacing * std::min(radius, other_radius);
}

bool is_nearly_closed(const Section& section) {
  return section.direction.norm() < kNearlyClosed * plane_of(section).second;
}

bool open_face(const Section& one, const Section& two) {
  constexpr double kMaxAngleDeg = 45;                     // degrees
  constexpr double kMaxShift = 0.5, kMaxLengthRatio = 5;  // relative to the lengths
  if (is_nearly_closed(one) && is_nearly_closed(two)) return closed_face(one, two);
  const double a = one.direction.norm(), b = two.direction.norm();
  if (!(a > 0 && b > 0) || std::max(a, b) > kMaxLengthRatio * std::min(a, b)) return false;
  const double angle_deg = degrees_between(one.direction, two.direction);
  if (std::min(angle_deg, 180 - angle_deg) > kMaxAngleDeg) return false;
  const Vec3 apart = two.middle - one.middle;
  return std::abs(apart.dot(one.direction)) / a < kMaxShift * std::max(a, b);
}

}  // namespace

std::vector<int> loft_order(const std::vector<std::vector<Vec3>>& points, bool closed) {
  std::vector<Section> sections;
  for (const auto& of_section : points) sections.push_back(section_of(of_section));
  std::vector<int> order = chain(sections);
  for (size_t k = 0; k + 1 < order.size(); ++k) {
    const Section &one = sections[order[k]], &two = sections[order[k + 1]];
    if (closed ? !closed_face(one, two) : !open_face(one, two)) return {};
  }
  return order;
}

std::vector<CharacterLine> ordered_sections(const CurveNetwork& network) {
  const std::vector<int> edges = isolated_edges(network);
  if (edges.size() < 2) return {};
  const auto closed = [&](int a) {
    return network.edges()[a].nodes[0] == network.edges()[a].nodes[1];
  };
  const auto count = std::count_if(edges.begin(), edges.end(), closed);
  if (count != 0 && (count != static_cast<long>(edges.size()) || count == 2)) return {};
  std::vector<std::vector<Vec3>> points;
  for (const int a : edges) {
    if (network.lines()[network.edges()[a].line].role != CharacterLine::Role::Outline) return {};
    points.push_back(section_samples(network.edges()[a], count > 0));
  }
  std::vector<CharacterLine> row;
  for (const int k : loft_order(points, count > 0)) row.push_back(network.lines()[k]);
  return row;
}

namespace {

constexpr const char* kRails[] = {"rail 1", "rail 2"};

struct Ends {
  Vec3 start, end;
};

Ends ends_of(const CharacterLine& line) {
  return {line.curve->evaluate(line.curve->start()), line.curve->evaluate(line.curve->end())};
}

bool is_closed(const CharacterLine& line) {
  const auto [start, end] = ends_of(line);
  const double middle = 0.5 * (line.curve->start() + line.curve->end());
  constexpr double same = 1e-9;
  return (start - end).norm() <= same * (line.curve->evaluate(middle) - start).norm();
}

}  // namespace

CharacterLine rail_through(const std::string& name, const std::vector<Vec3>& points) {
  std::vector<double> u{0};
  Points x(static_cast<long>(points.size()), 3);
  for (size_t i = 0; i < points.size(); ++i) {
    x.row(static_cast<long>(i)) = points[i];
    if (i > 0) u.push_back(u.back() + (points[i] - points[i - 1]).norm());
  }
  CharacterLine line;
  line.name = name;
  line.curve = curve_from_hermite(HermiteCurve(u, x, not_a_knot_slopes(u, x)));
  return line;
}

std::vector<CharacterLine> section_lines(std::vector<CharacterLine> sections) {
  if (sections.size() < 2)
    throw InputError("found " + std::to_string(sections.size()) + " section, expected two or more");
  const bool closed = is_closed(sections.front());
  std::vector<Vec3> starts, ends;
  for (CharacterLine& section : sections) {
    const bool outer = &section == &sections.front() || &section == &sections.back();
    section.role = outer ? CharacterLine::Role::Outline : CharacterLine::Role::Inner;
    if (is_closed(section) != closed)
      throw InputError("section '" + section.name + "' is " + (closed ? "open" : "closed") +
                       " and section '" + sections.front().name + "' is " +
                       (closed ? "closed" : "open") + ", expected all open or all closed");
    auto [start, end] = ends_of(section);
    if (!starts.empty() && (start - starts.back()).norm() + (end - ends.back()).norm() >
                               (end - starts.back()).norm() + (start - ends.back()).norm())
      std::swap(start, end);
    if (!closed && !starts.empty() && (start == starts.back() || end == ends.back()))
      throw InputError("section '" + section.name + "' shares an end with the section before it, " +
                       "expected distinct ends, so that rails can connect them");
    starts.push_back(start);
    ends.push_back(end);
  }
  if (closed) return sections;
  sections.push_back(rail_through(kRails[0], starts));
  sections.push_back(rail_through(kRails[1], ends));
  return sections;
}

bool is_rail(const std::string& curve) {
  return std::any_of(std::begin(kRails), std::end(kRails), [&](const std::string& rail) {
    return curve == rail || curve.starts_with(rail + ".");
  });
}

RegionLayout section_region(const std::string& name, std::vector<CharacterLine> sections,
                            SkinOptions options, const Progress& progress) {
  const std::vector<CharacterLine> lines = section_lines(std::move(sections));
  options.sections = true;
  if (!is_closed(lines.back())) {
    options.corner_angle = std::min(options.corner_angle, 2.0);
    if (options.domain == SkinOptions::Domain::Auto) options.domain = SkinOptions::Domain::Polygon;
  }
  if (options.edge_length == 0) {
    Vec3 low = lines[0].curve->evaluate(lines[0].curve->start()), high = low;
    constexpr int samples = 64;
    for (const CharacterLine& line : lines)
      for (int i = 0; i <= samples; ++i) {
        const double f = static_cast<double>(i) / samples;
        const Vec3 p = line.curve->evaluate((1 - f) * line.curve->start() + f * line.curve->end());
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
    options.edge_length = (high - low).norm() / 33;
  }
  return RegionLayout(name, lines, options, progress);
}

}  // namespace batten
