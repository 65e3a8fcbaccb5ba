// SPDX-License-Identifier: MPL-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <tuple>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/skinning/facets/facets.h"
#include "batten/skinning/surfaces/surface_defects.h"

namespace batten {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
using Regions = std::vector<const SkinnedRegion*>;

std::string name_of(const Regions& regions, int r) { return "'" + regions[r]->name + "'"; }

double degrees_between_normals(const Vec3& a, const Vec3& b) {
  return kDegrees * std::atan2(a.cross(b).norm(), a.dot(b));
}

// A boundary side of a facet: from its corner `side` to the next one.
struct ShellBoundaryEdge {
  int facet, side;
  std::array<Vec3, 3> normals;  // surface normals at its start, middle and end; zero: unknown
};

// The facets of one region, in model units.
struct Shell {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> facets;
  std::vector<Vec3> normals;  // unit; zero for a facet without area
  std::vector<ShellBoundaryEdge> boundary;
  double edge = 0;  // mean edge length
};

// Surface normals along a side of a facet, if both ends can be located in the facet's element; else
// zero.
std::array<Vec3, 3> normals_along(const Surface& surface, const Tessellation& t, int facet,
                                  int side) {
  const int element = t.facet_triangle[facet];
  const auto in_element = [&](int point) -> std::optional<Vec3> {
    const Location& where = t.points[point];
    if (where.triangle == element) return where.L;
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i)
        if (where.L[k] == 1 &&
            surface.mesh().triangles()[where.triangle][k] == surface.mesh().triangles()[element][i])
          return Vec3(Vec3::Unit(i));
    return std::nullopt;
  };
  const auto a = in_element(t.facets[facet][side]), b = in_element(t.facets[facet][(side + 1) % 3]);
  std::array<Vec3, 3> normals;
  normals.fill(Vec3::Zero());
  if (!a || !b) return normals;
  for (int k = 0; k < 3; ++k) {
    const Vec3 n = surface.area_vector({element, *a + 0.5 * k * (*b - *a)});
    const double length = n.norm();
    if (length > 0 && std::isfinite(length)) normals[k] = n / length;
  }
  return normals;
}

Shell shell_of(const SkinnedRegion& region) {
  const Tessellation t = facets(region, 2).tessellation;
  Shell shell;
  for (const Location& where : t.points) shell.points.push_back(region.surface.position(where));
  shell.facets = t.facets;
  double length = 0;
  for (const auto& [a, b, c] : shell.facets) {
    const Vec3 ab = shell.points[b] - shell.points[a], ac = shell.points[c] - shell.points[a];
    const Vec3 n = ab.cross(ac);
    const double least = 1e-12 * std::max(ab.squaredNorm(), ac.squaredNorm());
    shell.normals.push_back(n.norm() > least ? Vec3(n.normalized()) : Vec3(Vec3::Zero()));
    length += ab.norm() + ac.norm() + (ac - ab).norm();
  }
  for (const auto& [f, i] : boundary_sides(shell.facets))
    shell.boundary.push_back({f, i, normals_along(region.surface, t, f, i)});
  shell.edge = length / std::max<double>(1, 3 * static_cast<double>(shell.facets.size()));
  return shell;
}

void look_at_jacobian(const Regions& regions, int r, const SkinQuality& quality,
                      std::vector<SurfaceDefect>& defects) {
  if (quality.min_jacobian_ratio > 0) return;
  // Position: the smallest Jacobian, with a sign relative to the mean of its triangle.
  const Surface& surface = regions[r]->surface;
  const Trim* trim = surface.trim().get();
  double least = std::numeric_limits<double>::infinity();
  Vec3 location = Vec3::Zero();
  for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
    poll_every<2048>(t);
    if (trim && trim->side(t) == Trim::Side::Outside) continue;
    const Vec3 middle = Vec3::Constant(1.0 / 3);
    const Location where[4] = {
        {t, Vec3::UnitX()}, {t, Vec3::UnitY()}, {t, Vec3::UnitZ()}, {t, middle}};
    Vec3 areas[4], mean = Vec3::Zero();
    for (int k = 0; k < 4; ++k) mean += areas[k] = surface.jet(where[k]).area_vector();
    for (int k = 0; k < 4; ++k) {
      const double oriented = std::copysign(areas[k].norm(), areas[k].dot(mean));
      if (!(oriented < least)) continue;
      least = oriented;
      location = surface.position(where[k]);
    }
  }
  defects.push_back({SurfaceDefect::Kind::Jacobian,
                     {r},
                     location,
                     quality.min_jacobian_ratio,
                     "face " + name_of(regions, r) + " is inverted near " + format_point(location) +
                         ": its smallest Jacobian is " + format_number(quality.min_jacobian_ratio) +
                         " times the median"});
}

void look_at_area(const Regions& regions, int r, const Shell& shell, double area,
                  double expected_area, std::vector<SurfaceDefect>& defects) {
  constexpr double most = 2;
  if (!(expected_area > 0) || area <= most * expected_area) return;
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : shell.points) middle += p / static_cast<double>(shell.points.size());
  defects.push_back({SurfaceDefect::Kind::Area,
                     {r},
                     middle,
                     area / expected_area,
                     "face " + name_of(regions, r) + " bulges: it has " +
                         format_number(area / expected_area) +
                         " times the area that its boundary suggests"});
}

// A pair of point indices, numbered over all regions.
using EdgeKey = std::pair<int, int>;

void look_at_inner_folds(const Regions& regions, int r, const Shell& shell,
                         std::vector<SurfaceDefect>& defects) {
  std::map<EdgeKey, int> across;
  constexpr double most = 120;  // degrees; inner lines with corners may require a ridge of 90°
  double worst = most;
  Vec3 location = Vec3::Zero();
  for (size_t f = 0; f < shell.facets.size(); ++f) {
    poll_every<8192>(static_cast<long>(f));
    for (int i = 0; i < 3; ++i) {
      const int a = shell.facets[f][i], b = shell.facets[f][(i + 1) % 3];
      const auto [it, first] = across.try_emplace(std::minmax(a, b), static_cast<int>(f));
      if (first) continue;
      const Vec3 &m = shell.normals[it->second], &n = shell.normals[f];
      if (m.isZero() || n.isZero()) continue;
      const double angle = degrees_between_normals(m, n);
      if (angle <= worst) continue;
      worst = angle;
      location = 0.5 * (shell.points[a] + shell.points[b]);
    }
  }
  if (worst > most)
    defects.push_back({SurfaceDefect::Kind::Fold,
                       {r},
                       location,
                       worst,
                       "face " + name_of(regions, r) + " is folded by " + format_number(worst) +
                           " degrees near " + format_point(location)});
}

// Assigns a common index to points of different regions that lie within `near` of each other,
// directly or through a third point. Points of one region are merged only if they are equal up to
// rounding.
std::vector<int> welded(const std::vector<Vec3>& points, const std::vector<int>& region,
                        double near, double rounding) {
  std::map<std::array<long long, 3>, std::vector<int>> cells;
  std::vector<int> number(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    std::array<long long, 3> cell;
    for (int k = 0; k < 3; ++k) cell[k] = std::llround(points[i][k] / (2 * near));
    number[i] = static_cast<int>(i);
    bool found = false;
    for (long long x = -1; x <= 1 && !found; ++x)
      for (long long y = -1; y <= 1 && !found; ++y)
        for (long long z = -1; z <= 1 && !found; ++z) {
          const auto it = cells.find({cell[0] + x, cell[1] + y, cell[2] + z});
          if (it == cells.end()) continue;
          for (const int j : it->second)
            if ((points[j] - points[i]).norm() <= (region[j] == region[i] ? rounding : near)) {
              number[i] = j;
              found = true;
              break;
            }
        }
    if (!found) cells[cell].push_back(static_cast<int>(i));
  }
  return number;
}

// All facets, with points on shared lines merged.
struct FacetSoup {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> facets;  // merged point indices
  std::vector<std::array<int, 3>> own;     // original point indices
  std::vector<int> region, facet;          // for each facet: region, and facet index in it
  struct BoundaryEdge {
    EdgeKey by;  // point indices
    size_t facet;
    std::array<Vec3, 3> normals;  // at the first point, the middle, the second point; or zero
    bool operator<(const BoundaryEdge& o) const {
      return std::tie(by, facet) < std::tie(o.by, o.facet);
    }
  };
  std::vector<BoundaryEdge> boundary;  // boundary sides within their region
  double near = 0;
};

FacetSoup soup_of(const Regions& regions, const std::vector<SkinQuality>& qualities,
                  const std::vector<Shell>& shells) {
  FacetSoup soup;
  std::vector<Vec3> boundary;    // points on boundary sides
  std::vector<int> at_boundary;  // their indices
  std::vector<int> of_boundary;  // their regions
  double size = 0, gap = 0, edge = std::numeric_limits<double>::infinity();
  for (size_t r = 0; r < shells.size(); ++r) {
    if (!regions[r]) continue;
    const int base = isize(soup.points);
    std::vector<char> on_boundary(shells[r].points.size(), 0);
    for (const auto& [f, i, normals] : shells[r].boundary) {
      for (const int v : {shells[r].facets[f][i], shells[r].facets[f][(i + 1) % 3]})
        on_boundary[v] = 1;
      soup.boundary.push_back({{i, 0}, soup.facets.size() + static_cast<size_t>(f), normals});
    }
    for (size_t f = 0; f < shells[r].facets.size(); ++f) {
      poll_every<65536>(static_cast<long>(f));
      auto facet = shells[r].facets[f];
      for (int& v : facet) v += base;
      soup.facets.push_back(facet);
      soup.region.push_back(static_cast<int>(r));
      soup.facet.push_back(static_cast<int>(f));
    }
    for (size_t i = 0; i < on_boundary.size(); ++i) {
      if (!on_boundary[i]) continue;
      boundary.push_back(shells[r].points[i]);
      at_boundary.push_back(base + static_cast<int>(i));
      of_boundary.push_back(static_cast<int>(r));
    }
    soup.points.insert(soup.points.end(), shells[r].points.begin(), shells[r].points.end());
    size = std::max(size, regions[r]->size);
    gap = std::max(gap, qualities[r].max_line_gap);
    edge = std::min(edge, shells[r].edge);
  }
  soup.near = std::max(1e-9 * size, std::min(4 * gap, 0.1 * edge));
  const std::vector<int> first = welded(boundary, of_boundary, soup.near, 1e-9 * size);
  std::vector<int> number(soup.points.size());
  for (size_t i = 0; i < number.size(); ++i) number[i] = static_cast<int>(i);
  for (size_t i = 0; i < boundary.size(); ++i) number[at_boundary[i]] = at_boundary[first[i]];
  soup.own = soup.facets;
  for (auto& facet : soup.facets)
    for (int& v : facet) v = number[v];
  for (auto& [by, f, normals] : soup.boundary) {
    const int i = by.first, a = soup.facets[f][i], b = soup.facets[f][(i + 1) % 3];
    by = std::minmax(a, b);
    if (a > b) std::swap(normals[0], normals[2]);
  }
  std::sort(soup.boundary.begin(), soup.boundary.end());
  return soup;
}

constexpr double kSharp = 30;  // degrees; sharper wedges must be required by the curves

// A mesh edge along which two regions meet; a and b are points of the soup.
struct MetEdge {
  int a, b;
  std::array<int, 2> region;
  // Unit vectors into each region, perpendicular to the edge: at a, in the middle, at b.
  std::array<std::array<Vec3, 3>, 2> into;
  double length;

  double wedge(int at = 1) const {
    return degrees_between_normals(into[0][at], into[1][at]);  // degrees
  }
};
using Meetings = std::map<EdgeKey, std::vector<MetEdge>>;  // by pair of regions

// Directions into the surface of a facet, perpendicular to its edge: in the tangent plane, or in
// the facet if the tangent plane is unknown.
std::array<Vec3, 3> into_surface(const FacetSoup& soup, const FacetSoup::BoundaryEdge& boundary) {
  const auto [a, b] = boundary.by;
  const Vec3 along = (soup.points[b] - soup.points[a]).normalized();
  Vec3 chord = Vec3::Zero();
  for (const int v : soup.facets[boundary.facet])
    if (v != a && v != b) chord = soup.points[v] - soup.points[a];
  chord = (chord - chord.dot(along) * along).normalized();
  std::array<Vec3, 3> into;
  for (int k = 0; k < 3; ++k) {
    const Vec3 in_plane = boundary.normals[k].cross(along);
    const double cosine = in_plane.dot(chord);
    into[k] = cosine == 0 ? chord : Vec3(in_plane.normalized() * (cosine < 0 ? -1 : 1));
  }
  return into;
}

Meetings meetings_of(const std::vector<Shell>& shells, const FacetSoup& soup) {
  Meetings meetings;
  const auto no_area = [&](size_t f) {
    return shells[soup.region[f]].normals[soup.facet[f]].isZero();
  };
  for (size_t i = 0; i < soup.boundary.size(); ++i)
    for (size_t j = i + 1; j < soup.boundary.size() && soup.boundary[j].by == soup.boundary[i].by;
         ++j) {
      const auto [a, b] = soup.boundary[i].by;
      const FacetSoup::BoundaryEdge *first = &soup.boundary[i], *second = &soup.boundary[j];
      if (soup.region[first->facet] > soup.region[second->facet]) std::swap(first, second);
      const int r = soup.region[first->facet], s = soup.region[second->facet];
      if (r == s || a == b || no_area(first->facet) || no_area(second->facet)) continue;
      meetings[{r, s}].push_back({a,
                                  b,
                                  {r, s},
                                  {into_surface(soup, *first), into_surface(soup, *second)},
                                  (soup.points[b] - soup.points[a]).norm()});
    }
  return meetings;
}

// Wedge angles that the curves require along common lines of two regions. At an end of such a line
// each region has another curve, and the two curves span its tangent plane.
class ExpectedWedges {
 public:
  explicit ExpectedWedges(const FacetSoup& soup) : soup_(soup) {
    for (const FacetSoup::BoundaryEdge& boundary : soup.boundary) {
      boundary_[{soup.region[boundary.facet], boundary.by.first}].push_back(boundary.by.second);
      boundary_[{soup.region[boundary.facet], boundary.by.second}].push_back(boundary.by.first);
    }
  }

  static constexpr double kUnknown = -1;

  // Required wedge in degrees at each edge at which two regions meet, linear between the ends of
  // the line. If the curves fix no planes at an end (a line may also end because points of the two
  // regions differ), the nearest end at which they do is used. kUnknown if there is none.
  std::vector<double> of(const std::vector<MetEdge>& edges) const {
    std::map<int, std::vector<size_t>> at;  // edges at each point
    for (size_t i = 0; i < edges.size(); ++i)
      for (const int v : {edges[i].a, edges[i].b}) at[v].push_back(i);
    const auto is_end = [&](int v) {
      const std::vector<size_t>& here = at[v];
      return here.size() != 2 ||
             degrees_between_normals(along(edges[here[0]], v), -along(edges[here[1]], v)) > kCorner;
    };
    std::vector<std::pair<Vec3, double>> known;  // ends with a known wedge
    for (const auto& [v, around] : at)
      if (is_end(v))
        for (const size_t e : around)
          if (const double wedge = wedge_at(edges[e], v); wedge != kUnknown)
            known.emplace_back(soup_.points[v], wedge);
    std::vector<double> expected(edges.size(), kUnknown);
    if (known.empty()) return expected;
    const auto expected_at = [&](size_t e, int v) {
      if (const double wedge = wedge_at(edges[e], v); wedge != kUnknown) return wedge;
      const auto distance = [&](const auto& end) { return (end.first - soup_.points[v]).norm(); };
      return std::min_element(
                 known.begin(), known.end(),
                 [&](const auto& a, const auto& b) { return distance(a) < distance(b); })
          ->second;
    };
    std::vector<char> seen(edges.size(), 0);
    for (const auto& [start, around] : at) {
      if (!is_end(start)) continue;
      for (const size_t first : around) {
        if (seen[first]) continue;
        std::vector<size_t> line;
        int v = start;
        for (size_t edge = first; !seen[edge];) {
          line.push_back(edge);
          seen[edge] = 1;
          v = edges[edge].a == v ? edges[edge].b : edges[edge].a;
          if (is_end(v)) break;
          edge = at[v][0] == edge ? at[v][1] : at[v][0];
        }
        spread(edges, line, expected_at(line.front(), start), expected_at(line.back(), v),
               expected);
      }
    }
    return expected;  // closed lines without a corner stay unknown
  }

 private:
  static constexpr double kCorner = 30;  // degrees between chords of a line

  Vec3 along(const MetEdge& edge, int from) const {
    const int to = edge.a == from ? edge.b : edge.a;
    return (soup_.points[to] - soup_.points[from]).normalized();
  }

  static void spread(const std::vector<MetEdge>& edges, const std::vector<size_t>& line,
                     double first, double last, std::vector<double>& expected) {
    double length = 0, before = 0;
    for (const size_t e : line) length += edges[e].length;
    for (const size_t e : line) {
      expected[e] = first + (last - first) * (before + 0.5 * edges[e].length) / length;
      before += edges[e].length;
    }
  }

  // Wedge between the tangent planes of both regions at the end `v` of a line, if both are fixed by
  // curves; otherwise kUnknown.
  double wedge_at(const MetEdge& edge, int v) const {
    return fixes_plane(edge, 0, v) && fixes_plane(edge, 1, v) ? edge.wedge(v == edge.a ? 0 : 2)
                                                              : kUnknown;
  }

  // True if a region has another curve at the end of a line that does not continue the line.
  bool fixes_plane(const MetEdge& edge, int side, int v) const {
    constexpr double corner = 15;  // degrees
    const auto found = boundary_.find({edge.region[side], v});
    if (found == boundary_.end()) return false;
    const Vec3 line = along(edge, v);
    return std::any_of(found->second.begin(), found->second.end(), [&](int w) {
      const double angle_deg = degrees_between_normals(soup_.points[w] - soup_.points[v], line);
      return w != edge.a && w != edge.b && angle_deg > corner && angle_deg < 180 - corner;
    });
  }

  const FacetSoup& soup_;
  // By region and point: adjacent points on the boundary.
  std::map<std::pair<int, int>, std::vector<int>> boundary_;
};

// Compares the wedges between regions that meet along a line with those that the curves require.
void look_at_joins(const Regions& regions, const FacetSoup& soup, const Meetings& meetings,
                   std::vector<SurfaceDefect>& defects) {
  constexpr double fraction = 0.5;            // of the required wedge
  constexpr double kLiesOn = 0.05;            // degrees; below, the regions lie on each other
  constexpr double kMinLengthFraction = 0.1;  // of the common length
  const ExpectedWedges wedges(soup);
  for (const auto& [pair, edges] : meetings) {
    if (std::none_of(edges.begin(), edges.end(),
                     [](const MetEdge& e) { return e.wedge() < kSharp; }))
      continue;
    const std::vector<double> expected = wedges.of(edges);
    double length = 0, sharp = 0, least = 180, wanted = 0;
    Vec3 where = Vec3::Zero();
    for (size_t i = 0; i < edges.size(); ++i) {
      const MetEdge& e = edges[i];
      length += e.length;
      const double limit = expected[i] == ExpectedWedges::kUnknown
                               ? kSharp
                               : std::max(kLiesOn, std::min(kSharp, fraction * expected[i]));
      const double wedge = e.wedge();
      if (wedge >= limit) continue;
      sharp += e.length;
      if (wedge >= least) continue;
      least = wedge;
      wanted = expected[i];
      where = 0.5 * (soup.points[e.a] + soup.points[e.b]);
    }
    if (sharp <= kMinLengthFraction * length) continue;
    std::string text = "face " + name_of(regions, pair.second) + " is folded onto face " +
                       name_of(regions, pair.first) + ": they meet at " + format_number(least) +
                       " degrees near " + format_point(where);
    if (wanted > kLiesOn)
      text += ", expected " + format_number(std::round(wanted)) +
              " from the curves at the ends of their edge";
    defects.push_back({SurfaceDefect::Kind::Fold,
                       {pair.first, pair.second},
                       where,
                       180 - least,
                       std::move(text)});
  }
}

// Facets deviate from the surfaces that they approximate, so facets of two regions at a sharp edge
// may intersect although the surfaces do not.
class SharpEdgeFilter {
 public:
  SharpEdgeFilter(const std::vector<Shell>& shells, const FacetSoup& soup, const Meetings& meetings)
      : soup_(soup), sag_(soup.facets.size(), 0) {
    for (const auto& [pair, edges] : meetings)
      for (const MetEdge& e : edges)
        if (e.wedge() < kSharp) lines_[pair].push_back(&e);
    if (!lines_.empty()) measure_sag(shells);
  }

  // True if an intersection near a sharp edge is no deeper than the deviation of the two facets.
  bool explains(const FacetIntersection& c) const {
    const auto found = lines_.find(std::minmax(soup_.region[c.a], soup_.region[c.b]));
    if (found == lines_.end()) return false;
    constexpr double near = 2;  // times the facet size
    const double reach = near * std::max(size_of(c.a), size_of(c.b));
    return std::any_of(found->second.begin(), found->second.end(),
                       [&](const MetEdge* e) {
                         const Vec3 middle = 0.5 * (soup_.points[e->a] + soup_.points[e->b]);
                         return (middle - c.where).norm() <= reach;
                       }) &&
           std::min(depth(c.a, c.b), depth(c.b, c.a)) <= sag_[c.a] + sag_[c.b];
  }

 private:
  const Vec3& corner(int f, int k) const { return soup_.points[soup_.own[f][k]]; }
  double size_of(int f) const {
    return std::max({(corner(f, 0) - corner(f, 1)).norm(), (corner(f, 1) - corner(f, 2)).norm(),
                     (corner(f, 2) - corner(f, 0)).norm()});
  }

  // Depth by which facet a penetrates the plane of b.
  double depth(int a, int b) const {
    const Vec3 n = (corner(b, 1) - corner(b, 0)).cross(corner(b, 2) - corner(b, 0)).normalized();
    double above = 0, below = 0;
    for (int k = 0; k < 3; ++k) {
      const double d = n.dot(corner(a, k) - corner(b, 0));
      above = std::max(above, d);
      below = std::max(below, -d);
    }
    return std::min(above, below);
  }

  // A facet of size h whose normal differs by θ from that of its neighbours deviates by h θ / 8.
  void measure_sag(const std::vector<Shell>& shells) {
    std::map<std::pair<EdgeKey, int>, size_t> across;  // by point indices and region
    for (size_t f = 0; f < soup_.own.size(); ++f)
      for (int k = 0; k < 3; ++k) {
        const EdgeKey e = std::minmax(soup_.own[f][k], soup_.own[f][(k + 1) % 3]);
        const auto [it, first] = across.try_emplace({e, soup_.region[f]}, f);
        if (first) continue;
        const size_t g = it->second;
        const Vec3 &m = shells[soup_.region[f]].normals[soup_.facet[f]],
                   &n = shells[soup_.region[g]].normals[soup_.facet[g]];
        if (m.isZero() || n.isZero()) continue;
        const double angle_deg = degrees_between_normals(m, n) / kDegrees;
        for (const size_t h : {f, g})
          sag_[h] = std::max(sag_[h], size_of(static_cast<int>(h)) * angle_deg / 8);
      }
  }

  const FacetSoup& soup_;
  std::map<EdgeKey, std::vector<const MetEdge*>> lines_;  // sharp edges, by pair of regions
  std::vector<double> sag_;  // deviation of each facet from its surface
};

void look_at_crossings(const Regions& regions, const std::vector<Shell>& shells,
                       const FacetSoup& soup, const Meetings& meetings,
                       std::vector<SurfaceDefect>& defects) {
  double edge = 0;
  for (const Shell& shell : shells) edge = std::max(edge, shell.edge);
  // Near lines that both regions meet only approximately, facets may intersect.
  constexpr double fraction = 0.1;
  const auto crossings = facet_intersections(soup.points, soup.own, soup.facets, soup.region,
                                             std::max(soup.near, fraction * edge));
  if (crossings.empty()) return;
  const SharpEdgeFilter sharp(shells, soup, meetings);
  struct Crossed {
    int count = 0;
    Vec3 where = Vec3::Zero();
  };
  std::map<EdgeKey, Crossed> by_regions;
  for (const FacetIntersection& c : crossings) {
    if (sharp.explains(c)) continue;
    Crossed& crossed = by_regions[std::minmax(soup.region[c.a], soup.region[c.b])];
    if (crossed.count++ == 0) crossed.where = c.where;
  }
  for (const auto& [pair, c] : by_regions) {
    const bool itself = pair.first == pair.second;
    defects.push_back(
        {SurfaceDefect::Kind::Crossing,
         itself ? std::vector<int>{pair.first} : std::vector<int>{pair.first, pair.second}, c.where,
         static_cast<double>(c.count),
         "face " + name_of(regions, pair.first) + " intersects " +
             (itself ? std::string("itself") : "face " + name_of(regions, pair.second)) + " near " +
             format_point(c.where) + " (" + std::to_string(c.count) + " pairs of facets)"});
  }
}

}  // namespace

std::vector<SurfaceDefect> find_defects(const std::vector<const SkinnedRegion*>& regions,
                                        const std::vector<SkinQuality>& qualities,
                                        const std::vector<double>& expected_areas) {
  if (qualities.size() != regions.size() || expected_areas.size() != regions.size())
    throw InputError("found " + std::to_string(qualities.size()) + " qualities and " +
                     std::to_string(expected_areas.size()) + " areas for " +
                     std::to_string(regions.size()) + " faces, expected one of each per face");
  std::vector<Shell> shells(regions.size());
  parallel_for(isize(regions), [&](int r) {
    const auto i = static_cast<size_t>(r);
    if (regions[i]) shells[i] = shell_of(*regions[i]);
  });
  std::vector<SurfaceDefect> defects;
  for (size_t i = 0; i < regions.size(); ++i) {
    if (!regions[i]) continue;
    const int r = static_cast<int>(i);
    look_at_jacobian(regions, r, qualities[i], defects);
    look_at_inner_folds(regions, r, shells[i], defects);
    look_at_area(regions, r, shells[i], qualities[i].area, expected_areas[i], defects);
  }
  const FacetSoup soup = soup_of(regions, qualities, shells);
  const Meetings meetings = meetings_of(shells, soup);
  look_at_joins(regions, soup, meetings, defects);
  look_at_crossings(regions, shells, soup, meetings, defects);
  return defects;
}

}  // namespace batten
