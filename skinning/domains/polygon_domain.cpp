// Outlines with corners: lines on the sides of a polygon.
#include <cmath>
#include <numbers>

#include "batten/core/format.h"
#include "batten/core/planar_geometry.h"
#include "batten/skinning/domains/loop_area.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/domains/polygon_domain.h"
#include "batten/skinning/domains/polygon_fit.h"

namespace batten {
namespace {

void require_corners(const Outline& loop, double corner_angle) {
  const size_t sides = loop.corners.size();
  if (sides < 3)
    throw InputError("the outline has " + std::to_string(sides) +
                     " corner(s) that turn by more than " + format_number(corner_angle) +
                     " degrees, and a polygon needs three or more");
  constexpr size_t max_corners = 100;
  if (sides > max_corners)
    throw InputError("the outline turns by more than " + format_number(corner_angle) +
                     " degrees at " + std::to_string(sides) + " places, and a region has at most " +
                     std::to_string(max_corners) +
                     " corners: are the points noisy? (raise corner_angle, or smooth the line)");
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
        "the polygon with these sides and corners has no room inside: the outline's sides bend "
        "much more than its corners turn");
}

// u runs along the side of the first line, from the middle of the corners.
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

// From the lengths of the sides and the angles between them, unless it is given.
void choose_polygon(PolygonDomain& domain, const std::vector<Vec2>* prescribed) {
  const Outline& loop = domain.outline;
  domain.line_angles = corner_angles(loop, domain.task.options.convex);
  // The polygon is fitted to rounded numbers of the region scaled to size 1.
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

// Given curves share a side by their parameters, so that the speed along it goes on.
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

// Fits the lines of a side, and shares it by their lengths.
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
    // The piece's share of the side is rounded, and its parameter stretched by the same hair,
    // so that speed stays continuous where pieces meet.
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
  // Decided first: the fan needs lines that are cut evenly.
  if (options.mesher == SkinOptions::Mesher::Delaunay && !have_delaunay_mesher()) {
    warnings.push_back("this build has no CGAL: the fan mesher is used instead");
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
    constexpr double shortest_edge = 0.3;  // of the target: shorter pieces would crowd the mesh
    const auto exact =
        reuse_cubic_input(s, shortest_edge * domain.task.edge_length, start.position, end.position);
    if (exact && (exact->segment_count() == 1 || !evenly_cut)) return *exact;
  }
  FitOptions fit;
  fit.tolerance = domain.task.tolerance;
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
      throw InputError("inner line '" + s.name + "' cannot be fitted: " + reason +
                       "; with treatment = \"embedded\" it may");
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

}  // namespace batten
