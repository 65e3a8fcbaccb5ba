// SPDX-License-Identifier: MPL-2.0
// Polygonal domains: outlines with corners, whose lines lie on the sides of a polygon.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/skinning/domains/domain_input.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/domains/outline.h"
#include "batten/skinning/region/polygon_fit.h"

namespace batten {

// Straight segments of the domain, on which lines are edge-aligned, before and after meshing.

/// A smooth segment and its straight pcurve in the domain, between the points `from` and `to`.
/// Fractions run from 0 to 1 with the parameter of the fitted curve.
struct AlignedSegment {
  CharacterLine line;
  bool flipped = false;
  HermiteCurve fitted;
  Vec2 from, to;
  std::vector<double> nodes;  ///< fractions that must be mesh vertices, with 0 and 1
  std::vector<int> points;    ///< of a prescribed curve: its mesh vertices, parallel to `nodes`
  bool prescribed() const { return line.prescribed != nullptr; }
  double fraction(double u) const { return (u - fitted.start()) / (fitted.end() - fitted.start()); }
  Vec2 at(double fraction) const { return from + fraction * (to - from); }
};

/// The polygon and the aligned segments on it, scaled to a region of size 1.
struct PolygonDomain {
  DomainInput task;  ///< the mesher in its options is available in this build
  Outline outline;
  std::vector<double> line_angles;  ///< at the corners, in space, radians
  std::vector<Vec2> polygon;
  std::vector<AlignedSegment>
      aligned_segments;  ///< segments of the outline in loop order, then inner lines
  std::vector<SmoothSegment> aligned_inner;  ///< inner lines that are aligned segments
  /// True if the outline lines have prescribed curves (all or none have).
  bool prescribed() const { return outline.segments[0].segment.prescribed != nullptr; }
};

/// Fits the C1 cubic curve of a segment between two loop vertices. `alone`: the segment is a whole
/// side, so that piecewise cubic input may be used unchanged (reuse_cubic_input()).
HermiteCurve fit_aligned_segment(const PolygonDomain& domain, const SmoothSegment& s,
                                 const LoopVertex& start, const LoopVertex& end, bool alone);

/// Adds an inner line as a straight chain of edges across the polygon. Returns "" on success, or
/// the reason why it is impossible.
std::string add_inner_segment(PolygonDomain& domain, const SmoothSegment& s);

/// Builds the mesh, with all aligned segments on element edges. Throws InputError for too many
/// triangles, and as the mesher does.
ParametricMesh mesh_polygon(PolygonDomain& domain);

/// Finds the edges and vertices of that mesh on an aligned segment.
EdgeAlignedLine edge_aligned_line_on(const ParametricMesh& mesh,
                                     const AlignedSegment& aligned_segment);

namespace {

void require_corners(const Outline& loop, double corner_angle) {
  const size_t sides = loop.corners.size();
  if (sides < 3)
    throw InputError("the outline has " + std::to_string(sides) +
                     (sides == 1 ? " corner" : " corners") +
                     " above corner_angle = " + format_number(corner_angle) +
                     " degrees, expected three or more for domain = \"polygon\"");
  if (sides > kMaxPolygonCorners)
    throw InputError("the outline has " + std::to_string(sides) +
                     " corners above corner_angle = " + format_number(corner_angle) +
                     " degrees, expected at most " + std::to_string(kMaxPolygonCorners) +
                     "; increase corner_angle, or fair the curve if its points are noisy");
}

void require_enclosed_area(const PolygonDomain& domain, const std::vector<double>& lengths) {
  double area = 0, around = 0;
  for (size_t i = 0, n = domain.polygon.size(); i < n; ++i) {
    area += 0.5 * cross(domain.polygon[i], domain.polygon[(i + 1) % n]);
    around += lengths[i];
  }
  constexpr double least = 1e-6, min_fraction = 0.25;
  const double seen = enclosed_area(domain.outline) / (domain.task.size * domain.task.size);
  if (area < least * around * around ||
      (domain.task.options.domain == SkinOptions::Domain::Auto && area < min_fraction * seen))
    throw NoPolygonError(
        "the polygon with these side lengths and angles encloses too little area: the sides of "
        "the outline bend much more than its corners");
}

// Rotates u to the side of the first line; the mean of the corners becomes the origin.
void align_u_with_first_line(PolygonDomain& domain) {
  const size_t sides = domain.polygon.size();
  size_t first = 0;
  for (size_t c = 0; c < sides; ++c)
    for (const size_t p : domain.outline.side(c))
      if (p == 0) first = c;
  const Vec2 u = (domain.polygon[(first + 1) % sides] - domain.polygon[first]).normalized();
  Vec2 middle = Vec2::Zero();
  for (const Vec2& p : domain.polygon) middle += p / static_cast<double>(sides);
  for (Vec2& p : domain.polygon) {
    const Vec2 d = p - middle;
    p = Vec2(round_to_grid(d.dot(u)), round_to_grid(u.x() * d.y() - u.y() * d.x()));
  }
}

// Computes the polygon from the lengths of the sides and the angles between them, unless it is
// prescribed.
void choose_polygon(PolygonDomain& domain, const std::vector<Vec2>* prescribed) {
  const Outline& loop = domain.outline;
  domain.line_angles = corner_angles(loop, domain.task.options.convex);
  // Rounded numbers of the region scaled to size 1, so that the unit of the input does not matter.
  std::vector<double> lengths, angles;
  std::vector<Vec3> corners;
  const Vec3 origin = loop.segments[loop.corners[0]].start;
  for (size_t c = 0; c < loop.corners.size(); ++c) {
    const Vec3& corner = loop.segments[loop.corners[c]].start;
    lengths.push_back(round_to_grid(loop.side_length(c) / domain.task.size));
    angles.push_back(round_to_grid(domain.line_angles[c]));
    corners.push_back(round_to_grid(Vec3((corner - origin) / domain.task.size)));
  }
  const Vec3 normal = round_to_grid(loop_normal(loop));
  domain.polygon = prescribed ? *prescribed : fit_polygon(lengths, angles, corners, normal);
  require_enclosed_area(domain, lengths);
  align_u_with_first_line(domain);
}

std::pair<Vec2, Vec2> ends_of_side(const PolygonDomain& domain, size_t c) {
  return {domain.polygon[c], domain.polygon[(c + 1) % domain.polygon.size()]};
}

// Prescribed curves divide a side in proportion to their parameter intervals, so that the
// parametric speed is continuous along the side.
void place_prescribed(PolygonDomain& domain, size_t c) {
  const std::vector<size_t> segments = domain.outline.side(c);
  const auto [a, b] = ends_of_side(domain, c);
  double whole = 0, before = 0;
  for (const size_t p : segments) {
    const HermiteCurve& curve = domain.outline.segments[p].segment.prescribed->curve;
    whole += curve.end() - curve.start();
  }
  for (const size_t p : segments) {
    const auto& piece = domain.outline.segments[p];
    AlignedSegment& aligned_segment = domain.aligned_segments[p];
    aligned_segment.line = piece.segment.line(piece.flipped);
    aligned_segment.flipped = piece.flipped;
    aligned_segment.fitted = piece.segment.prescribed_along(piece.flipped);
    aligned_segment.from = a + before / whole * (b - a);
    before += aligned_segment.fitted.end() - aligned_segment.fitted.start();
    aligned_segment.to = p == segments.back() ? b : Vec2(a + before / whole * (b - a));
  }
}

HermiteCurve with_scaled_parameter(const HermiteCurve& curve, double factor) {
  std::vector<double> u = curve.parameters();
  for (double& x : u) x *= factor;
  return {CurveMesh(u), curve.dofs()};
}

// Fits the lines of a side, which divide it in proportion to their lengths.
void place_fitted(PolygonDomain& domain, size_t c) {
  const Outline& loop = domain.outline;
  const std::vector<size_t> segments = loop.side(c);
  const auto [a, b] = ends_of_side(domain, c);
  const double length = loop.side_length(c);
  double before = 0, fraction = 0;
  for (const size_t p : segments) {
    const auto& piece = loop.segments[p];
    AlignedSegment& aligned_segment = domain.aligned_segments[p];
    aligned_segment.line.name = piece.segment.name;
    aligned_segment.line.curve =
        piece.flipped ? reversed(piece.segment.curve) : piece.segment.curve;
    aligned_segment.flipped = piece.flipped;
    aligned_segment.fitted = fit_aligned_segment(
        domain, piece.segment, loop_vertex_at(loop, p),
        loop_vertex_at(loop, (p + 1) % loop.segments.size()), segments.size() == 1);
    // The segment's fraction of the side is rounded. Its parameter is scaled by the same factor, so
    // that the speed stays continuous where segments meet.
    before += piece.length;
    const double next = p == segments.back() ? 1 : round_to_grid(before / length);
    aligned_segment.fitted = with_scaled_parameter(
        aligned_segment.fitted, (next - fraction) * length / aligned_segment.fitted.end());
    aligned_segment.from = a + fraction * (b - a);
    aligned_segment.to = a + next * (b - a);
    fraction = next;
  }
}

PolygonDomain make_polygon_domain(const Outline& loop, const DomainInput& task,
                                  const std::vector<Vec2>* polygon,
                                  std::vector<std::string>& warnings) {
  PolygonDomain domain;
  domain.task = task;
  domain.outline = loop;
  SkinOptions& options = domain.task.options;
  // Chosen before curves are fitted: the fan needs lines that are split by bisection only.
  if (options.mesher == SkinOptions::Mesher::Delaunay && !have_delaunay_mesher()) {
    warnings.push_back("Batten was built without CGAL: the fan mesher is used");
    options.mesher = SkinOptions::Mesher::Fan;
  }
  require_corners(loop, options.corner_angle);
  choose_polygon(domain, polygon);
  warn_about_rounded_kinks(loop, options.corner_angle, warnings);
  domain.aligned_segments.resize(loop.segments.size());
  for (size_t c = 0; c < loop.corners.size(); ++c)
    if (domain.prescribed())
      place_prescribed(domain, c);
    else
      place_fitted(domain, c);
  return domain;
}

std::vector<DomainCorner> corners_of(const PolygonDomain& domain) {
  constexpr double degrees = 180 / std::numbers::pi;
  const std::vector<Vec2>& p = domain.polygon;
  std::vector<DomainCorner> corners;
  for (size_t i = 0, n = p.size(); i < n; ++i) {
    const Vec2 a = p[i] - p[(i + n - 1) % n], b = p[(i + 1) % n] - p[i];
    corners.push_back(
        {p[i], 180 - std::atan2(cross(a, b), a.dot(b)) * degrees, domain.line_angles[i] * degrees});
  }
  return corners;
}

}  // namespace

HermiteCurve fit_aligned_segment(const PolygonDomain& domain, const SmoothSegment& s,
                                 const LoopVertex& start, const LoopVertex& end, bool alone) {
  const bool evenly_cut = domain.task.options.mesher == SkinOptions::Mesher::Fan;
  if (alone) {
    // Fraction of the target: shorter segments would crowd the mesh.
    constexpr double shortest_edge = 0.3;
    const auto exact = reuse_cubic_input(s, shortest_edge * domain.task.options.edge_length,
                                         start.position, end.position);
    if (exact && (exact->segment_count() == 1 || !evenly_cut)) return *exact;
  }
  FitOptions fit;
  fit.tolerance = domain.task.options.tolerance;
  fit.corner_angle = 180;
  fit.closed = false;
  fit.start = {start.position, start.outgoing};
  fit.end = {end.position, end.incoming};
  fit.fixed_parameters = true;
  fit.bisection_only = evenly_cut;
  return fit_curve(s.name, s.curve, fit);
}

RegionGeometry make_polygon_geometry(const Outline& loop, const std::vector<SmoothSegment>& inner,
                                     const DomainInput& task, const std::vector<Vec2>* polygon,
                                     std::vector<SmoothSegment>& others) {
  RegionGeometry geometry;
  PolygonDomain domain = make_polygon_domain(loop, task, polygon, geometry.warnings);
  using MeshAlignment = CharacterLine::MeshAlignment;
  for (const SmoothSegment& s : inner) {
    std::string reason;
    if (s.mesh_alignment != MeshAlignment::Embedded) reason = add_inner_segment(domain, s);
    if (s.mesh_alignment == MeshAlignment::EdgeAligned && !reason.empty())
      throw InputError("inner curve '" + s.name + "' cannot be mesh-aligned: " + reason +
                       "; use alignment = \"embedded\"");
    if (s.mesh_alignment == MeshAlignment::Embedded || !reason.empty()) others.push_back(s);
  }
  geometry.mesh = std::make_shared<ParametricMesh>(mesh_polygon(domain));
  for (const AlignedSegment& s : domain.aligned_segments)
    geometry.edge_aligned.push_back(edge_aligned_line_on(*geometry.mesh, s));
  geometry.boundary.resize(1);
  for (size_t p = 0; p < loop.segments.size(); ++p)
    geometry.boundary[0].push_back({BoundarySegment::Kind::EdgeAligned, static_cast<int>(p),
                                    domain.aligned_segments[p].flipped});
  geometry.corners = corners_of(domain);
  return geometry;
}

// Inner lines as straight chains of edges across a polygon.

namespace {

bool segments_cross(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  constexpr double margin = 1e-9;
  const double det = cross(b - a, d - c);
  if (std::abs(det) < 1e-14) return false;
  const double s = cross(c - a, d - c) / det, t = cross(c - a, b - a) / det;
  return s > margin && s < 1 - margin && t > margin && t < 1 - margin;
}

// The point where an inner line ends on the outline. It becomes a node of that segment; an existing
// node is reused if one is near.
struct Junction {
  size_t aligned_segment;
  double fraction;
  Vec2 uv;
  Vec3 position;
};

std::optional<Junction> on_vertex(const PolygonDomain& domain, size_t piece, double fraction,
                                  const Vec3& p, std::string& reason) {
  const AlignedSegment& aligned_segment = domain.aligned_segments[piece];
  const HermiteCurve& curve = aligned_segment.line.prescribed->curve;
  for (const double u : aligned_segment.line.prescribed->vertices) {
    const double along = (u - curve.start()) / (curve.end() - curve.start());
    const double there = aligned_segment.flipped ? 1 - along : along;
    const Vec3 position = curve.evaluate(u);
    if ((position - p).norm() <= domain.task.gap_tolerance)
      return Junction{piece, there, aligned_segment.at(there), position};
  }
  reason = "it ends between two vertices of curve '" + aligned_segment.line.name + "', at " +
           format_number(fraction) + " of its length";
  return std::nullopt;
}

std::optional<Junction> junction(const PolygonDomain& domain, int end, const Vec3& p,
                                 std::string& reason) {
  double nearest = std::numeric_limits<double>::infinity(), fraction = 0;
  size_t found = 0;
  for (size_t i = 0; i < domain.outline.segments.size(); ++i) {
    const auto closest = domain.aligned_segments[i].fitted.closest_point(p);
    if (closest.distance < nearest) {
      nearest = closest.distance;
      found = i;
      fraction = domain.aligned_segments[i].fraction(closest.u);
    }
  }
  const AlignedSegment& aligned_segment = domain.aligned_segments[found];
  if (nearest > domain.task.gap_tolerance) {
    reason = std::string("its ") + (end ? "end " : "start ") + format_point(p) + " is " +
             format_number(nearest) + " away from curve '" + aligned_segment.line.name +
             "', expected at most " + format_number(domain.task.gap_tolerance);
    return std::nullopt;
  }
  if (aligned_segment.prescribed()) return on_vertex(domain, found, fraction, p, reason);
  const double snap = std::min(domain.task.gap_tolerance, 0.05 * domain.task.options.edge_length) /
                      aligned_segment.fitted.end();
  fraction = round_to_grid(fraction);
  for (const double u : aligned_segment.fitted.parameters())
    if (std::abs(u / aligned_segment.fitted.end() - fraction) < snap)
      fraction = u / aligned_segment.fitted.end();
  // The same rounded number as for the outline's own node.
  return Junction{
      found, fraction, aligned_segment.at(round_to_grid(fraction)),
      aligned_segment.fitted.evaluate(round_to_grid(fraction) * aligned_segment.fitted.end())};
}

std::string rejection_reason(const PolygonDomain& domain, const SmoothSegment& s,
                             const AlignedSegment& aligned_segment) {
  const InputCurve& curve = *s.curve;
  const std::vector<Vec3> ends = {curve.evaluate(curve.start()), curve.evaluate(curve.end())};
  const BoxedCurve boxed(curve);
  if (boxed.self_crossing(1e-7 * domain.task.size).found) return "it intersects itself";
  for (const SmoothSegment& other : domain.aligned_inner)
    if (const auto c = boxed.crossing(BoxedCurve(*other.curve), 1e-7 * domain.task.size, ends,
                                      0.02 * domain.task.size);
        c.found)
      return "it intersects curve '" + other.name + "' near " + format_point(c.where);
  for (const AlignedSegment& other : domain.aligned_segments)
    if (segments_cross(aligned_segment.from, aligned_segment.to, other.from, other.to))
      return "it would intersect curve '" + other.line.name + "' in the parameter domain";
  const Vec2 middle = 0.5 * (aligned_segment.from + aligned_segment.to);
  bool inside = false;
  for (size_t i = 0, n = domain.polygon.size(); i < n; ++i) {
    const Vec2 &a = domain.polygon[i], &b = domain.polygon[(i + 1) % n];
    if ((a.y() > middle.y()) != (b.y() > middle.y()) &&
        middle.x() < a.x() + (middle.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
      inside = !inside;
  }
  if (!inside) return "it would run along or outside of the outline of the parameter domain";
  return "";
}

}  // namespace

std::string add_inner_segment(PolygonDomain& domain, const SmoothSegment& s) {
  const InputCurve& curve = *s.curve;
  const Vec3 ends[2] = {curve.evaluate(curve.start()), curve.evaluate(curve.end())};
  if ((ends[0] - ends[1]).norm() <= domain.task.gap_tolerance) return "it is closed";
  AlignedSegment aligned_segment;
  aligned_segment.line = s.line(false);
  Vec3 on_outline[2];
  std::array<std::optional<Junction>, 2> junctions;
  for (int e = 0; e < 2; ++e) {
    std::string reason;
    junctions[e] = junction(domain, e, ends[e], reason);
    if (!junctions[e]) return reason;
    const Junction& j = *junctions[e];
    const size_t n = domain.outline.segments.size();
    if ((j.fraction <= 0 && domain.outline.is_corner(j.aligned_segment)) ||
        (j.fraction >= 1 && domain.outline.is_corner((j.aligned_segment + 1) % n)))
      return "it ends at a corner, where the two sides already fix the tangent plane";
    (e ? aligned_segment.to : aligned_segment.from) = junctions[e]->uv;
    on_outline[e] = junctions[e]->position;
  }
  if (const std::string reason = rejection_reason(domain, s, aligned_segment); !reason.empty())
    return reason;
  const Vec3 t0 = curve.evaluate(curve.start(), 1).normalized(),
             t1 = curve.evaluate(curve.end(), 1).normalized();
  aligned_segment.fitted = s.prescribed ? s.prescribed->curve
                                        : fit_aligned_segment(domain, s, {on_outline[0], t0, t0},
                                                              {on_outline[1], t1, t1}, true);
  for (const auto& j : junctions)
    domain.aligned_segments[j->aligned_segment].nodes.push_back(j->fraction);
  domain.aligned_inner.push_back(s);
  domain.aligned_segments.push_back(std::move(aligned_segment));
  return "";
}

// The mesh of a polygon, and the chains of element edges on its aligned segments.

namespace {

// Sets the nodes to exactly the prescribed vertices, in the direction of the aligned segment.
void fix_nodes(AlignedSegment& aligned_segment) {
  const HermiteCurve& curve = aligned_segment.line.prescribed->curve;
  const double span = curve.end() - curve.start();
  aligned_segment.nodes.clear();
  for (const double u : aligned_segment.line.prescribed->vertices) {
    const double fraction = (u - curve.start()) / span;
    aligned_segment.nodes.push_back(aligned_segment.flipped ? 1 - fraction : fraction);
  }
  if (aligned_segment.flipped)
    std::reverse(aligned_segment.nodes.begin(), aligned_segment.nodes.end());
}

ParametricMesh delaunay(PolygonDomain& domain) {
  PlanarMeshInput task;
  task.edge_length = round_to_grid(domain.task.options.edge_length / domain.task.size);
  task.keep_segments = domain.prescribed();
  task.size_field = domain.task.options.size_field;
  // Points that aligned segments share (corners, loop vertices, junctions) are merged.
  std::map<std::pair<long long, long long>, int> known;
  const auto add = [&](const Vec2& p) {
    constexpr double cell = 1e11;
    const std::pair key(std::llround(p.x() * cell), std::llround(p.y() * cell));
    for (long long dx = -1; dx <= 1; ++dx)
      for (long long dy = -1; dy <= 1; ++dy)
        if (const auto it = known.find({key.first + dx, key.second + dy}); it != known.end())
          return it->second;
    task.points.push_back(p);
    return known[key] = isize(task.points) - 1;
  };
  for (const Vec2& corner : domain.polygon) add(corner);
  for (size_t i = 0; i < domain.aligned_segments.size(); ++i) {
    AlignedSegment& s = domain.aligned_segments[i];
    auto& segments = i < domain.outline.segments.size() ? task.outline : task.inner;
    int last = add(s.from);
    if (s.prescribed()) {
      s.points = {last};
      for (size_t k = 1; k < s.nodes.size(); ++k) {
        const int next = add(k + 1 == s.nodes.size() ? s.to : s.at(s.nodes[k]));
        if (next == last || (k > 1 && next == s.points.front()))
          throw InputError("prescribed curve '" + s.line.name + "' has coincident vertices near " +
                           format_point(s.fitted.evaluate(s.fitted.start())));
        segments.push_back({last, next});
        s.points.push_back(last = next);
      }
      continue;
    }
    for (size_t k = 0; k + 1 < s.nodes.size(); ++k) {
      const double a = s.nodes[k], b = s.nodes[k + 1];
      const int cuts = std::max(
          1,
          static_cast<int>(std::ceil((b - a) * (s.to - s.from).norm() / task.edge_length - 0.2)));
      for (int c = 1; c <= cuts; ++c) {
        const double fraction = a + (b - a) * c / cuts;
        const int next = fraction >= 1 ? add(s.to) : add(s.at(round_to_grid(fraction)));
        if (next == last) continue;
        segments.push_back({last, next});
        last = next;
      }
    }
  }
  return delaunay_mesh(task);
}

bool cut_evenly(const AlignedSegment& s, int refinements) {
  return std::all_of(s.nodes.begin(), s.nodes.end(), [&](double fraction) {
    const double place = std::ldexp(fraction, refinements);
    return std::abs(place - std::round(place)) < 1e-6;
  });
}

ParametricMesh fan(const PolygonDomain& domain) {
  if (domain.prescribed())
    throw InputError(
        "the fan mesher does not support prescribed curves; use mesher = \"delaunay\"");
  PlanarMeshInput task;
  task.points = domain.polygon;
  const int n = isize(domain.polygon);
  double longest = 0;
  for (int i = 0; i < n; ++i) {
    task.outline.push_back({i, (i + 1) % n});
    longest = std::max(longest, (domain.polygon[(i + 1) % n] - domain.polygon[i]).norm());
  }
  if (!domain.aligned_inner.empty())
    throw InputError("the fan mesher does not support inner curves; use mesher = \"delaunay\"");
  if (domain.outline.segments.size() != domain.polygon.size())
    throw InputError("the fan mesher needs one curve for each side between corners, found " +
                     std::to_string(domain.outline.segments.size()) + " curves for " +
                     std::to_string(n) + " sides; use mesher = \"delaunay\"");
  int refinements = domain.task.options.fan_refinements;
  if (refinements < 0) {
    refinements = 0;
    while (longest > 1.3 * round_to_grid(domain.task.options.edge_length / domain.task.size) *
                         std::pow(2.0, refinements) &&
           refinements < 9)
      ++refinements;
    for (const AlignedSegment& s : domain.aligned_segments)
      while (!cut_evenly(s, refinements) && refinements < 9) ++refinements;
  }
  for (const AlignedSegment& s : domain.aligned_segments)
    if (!cut_evenly(s, refinements))
      throw InputError("the fan mesher has no nodes for curve '" + s.line.name +
                       "' with refine = " + std::to_string(refinements) +
                       "; increase refine or fit_tolerance, or use mesher = \"delaunay\"");
  return fan_mesh(task, refinements);
}

void find_edges(const ParametricMesh& mesh, EdgeAlignedLine& aligned_line) {
  for (size_t i = 0; i + 1 < aligned_line.vertices.size(); ++i) {
    const int e = mesh.edge_between(aligned_line.vertices[i], aligned_line.vertices[i + 1]);
    if (e < 0)
      throw NoSolutionError("the mesher created no edge along curve '" + aligned_line.line.name +
                            "' at (" +
                            format_number(mesh.vertices()[aligned_line.vertices[i]].x()) + ", " +
                            format_number(mesh.vertices()[aligned_line.vertices[i]].y()) + ")");
    aligned_line.edges.push_back(e);
  }
}

}  // namespace

ParametricMesh mesh_polygon(PolygonDomain& domain) {
  double area = 0;
  for (size_t i = 0, n = domain.polygon.size(); i < n; ++i)
    area += 0.5 * cross(domain.polygon[i], domain.polygon[(i + 1) % n]);
  // Expected number of triangles: equilateral ones with the target edge length, or those of the
  // fan.
  const bool counted = domain.task.options.mesher == SkinOptions::Mesher::Fan &&
                       domain.task.options.fan_refinements >= 0;
  const double expected = counted ? static_cast<double>(domain.polygon.size()) *
                                        std::pow(4.0, domain.task.options.fan_refinements)
                                  : area * domain.task.size * domain.task.size /
                                        (std::sqrt(3.0) / 4 * domain.task.options.edge_length *
                                         domain.task.options.edge_length);
  if (counted && expected > kMaxTriangles)
    throw InputError("refine = " + std::to_string(domain.task.options.fan_refinements) +
                     " creates " + format_number(expected) + " triangles, expected at most " +
                     format_number(kMaxTriangles));
  require_mesh_size(expected, domain.task.options.edge_length, domain.task.size, "a face");
  for (AlignedSegment& s : domain.aligned_segments) {
    if (s.prescribed()) {
      fix_nodes(s);
      continue;
    }
    for (const double u : s.fitted.parameters()) s.nodes.push_back(u / s.fitted.end());
    std::sort(s.nodes.begin(), s.nodes.end());
  }
  return domain.task.options.mesher == SkinOptions::Mesher::Fan ? fan(domain) : delaunay(domain);
}

EdgeAlignedLine edge_aligned_line_on(const ParametricMesh& mesh,
                                     const AlignedSegment& aligned_segment) {
  if (aligned_segment.prescribed()) {
    EdgeAlignedLine aligned_line{aligned_segment.line,
                                 aligned_segment.line.prescribed->curve,
                                 aligned_segment.points,
                                 aligned_segment.line.prescribed->vertices,
                                 {}};
    if (aligned_segment.flipped)
      std::reverse(aligned_line.vertices.begin(), aligned_line.vertices.end());
    find_edges(mesh, aligned_line);
    return aligned_line;
  }
  // Mesh vertices on the aligned segment, sorted by their fraction along it.
  const Vec2 d = aligned_segment.to - aligned_segment.from;
  const double length = d.norm();
  std::vector<std::pair<double, int>> on_segment;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const Vec2 p = mesh.vertices()[v] - aligned_segment.from;
    const double fraction = p.dot(d) / (length * length);
    constexpr double near = 1e-11;
    if (std::abs(cross(p, d)) / length < near && fraction > -near && fraction < 1 + near)
      on_segment.emplace_back(std::clamp(fraction, 0.0, 1.0), v);
  }
  std::sort(on_segment.begin(), on_segment.end());
  EdgeAlignedLine aligned_line;
  aligned_line.line = aligned_segment.line;
  aligned_line.fitted =
      aligned_segment.flipped ? aligned_segment.fitted.backwards() : aligned_segment.fitted;
  if (aligned_segment.flipped) {
    std::reverse(on_segment.begin(), on_segment.end());
    for (auto& [fraction, v] : on_segment) fraction = 1 - fraction;
  }
  for (const auto& [fraction, v] : on_segment) {
    aligned_line.vertices.push_back(v);
    aligned_line.parameters.push_back(fraction * aligned_segment.fitted.end());
  }
  find_edges(mesh, aligned_line);
  return aligned_line;
}

}  // namespace batten
