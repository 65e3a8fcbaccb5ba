// Outlines with corners: lines on the sides of a polygon.
#include <cmath>
#include <numbers>

#include "batten/core/plane.h"
#include "batten/core/words.h"
#include "batten/skinning/domains/loop_area.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/domains/polygon_fit.h"
#include "batten/skinning/domains/polygon_plan.h"

namespace batten {
namespace {

void require_corners(const Outline& loop, double corner_angle) {
  const size_t sides = loop.corners.size();
  if (sides < 3)
    throw InputError("the outline has " + std::to_string(sides) +
                     " corner(s) that turn by more than " + number(corner_angle) +
                     " degrees, and a polygon needs three or more");
  constexpr size_t most_corners = 100;
  if (sides > most_corners)
    throw InputError("the outline turns by more than " + number(corner_angle) + " degrees at " +
                     std::to_string(sides) + " places, and a region has at most " +
                     std::to_string(most_corners) +
                     " corners: are the points noisy? (raise corner_angle, or smooth the line)");
}

void require_room(const PolygonPlan& plan, const std::vector<double>& lengths) {
  double area = 0, around = 0;
  for (size_t i = 0, n = plan.polygon.size(); i < n; ++i) {
    area += 0.5 * cross(plan.polygon[i], plan.polygon[(i + 1) % n]);
    around += lengths[i];
  }
  constexpr double least = 1e-6, least_share = 0.25;
  const double seen = enclosed_area(plan.outline) / (plan.task.size * plan.task.size);
  if (area < least * around * around ||
      (plan.task.options.domain == SkinOptions::Domain::Auto && area < least_share * seen))
    throw NoPolygon(
        "the polygon with these sides and corners has no room inside: the outline's sides bend "
        "much more than its corners turn");
}

// u runs along the side of the first line, from the middle of the corners.
void turn_to_first_line(PolygonPlan& plan) {
  const size_t sides = plan.polygon.size();
  size_t first = 0;
  for (size_t c = 0; c < sides; ++c)
    for (const size_t p : plan.outline.side(c))
      if (p == 0) first = c;
  const Vec2 u = (plan.polygon[(first + 1) % sides] - plan.polygon[first]).normalized();
  Vec2 middle = Vec2::Zero();
  for (const Vec2& p : plan.polygon) middle += p / static_cast<double>(sides);
  for (Vec2& p : plan.polygon) {
    const Vec2 d = p - middle;
    p = Vec2(rounded(d.dot(u)), rounded(u.x() * d.y() - u.y() * d.x()));
  }
}

// From the lengths of the sides and the angles between them, unless it is given.
void choose_polygon(PolygonPlan& plan, const std::vector<Vec2>* given) {
  const Outline& loop = plan.outline;
  plan.line_angles = corner_angles(loop, plan.task.options.convex);
  // The polygon is fitted to rounded numbers of the region scaled to size 1.
  std::vector<double> lengths, angles;
  std::vector<Vec3> corners;
  const Vec3 origin = loop.pieces[loop.corners[0]].start;
  for (size_t c = 0; c < loop.corners.size(); ++c) {
    const Vec3& corner = loop.pieces[loop.corners[c]].start;
    lengths.push_back(rounded(loop.side_length(c) / plan.task.size));
    angles.push_back(rounded(plan.line_angles[c]));
    corners.push_back(rounded(Vec3((corner - origin) / plan.task.size)));
  }
  const Vec3 normal = rounded(loop_normal(loop));
  plan.polygon = given ? *given : fit_polygon(lengths, angles, corners, normal);
  require_room(plan, lengths);
  turn_to_first_line(plan);
}

std::pair<Vec2, Vec2> ends_of_side(const PolygonPlan& plan, size_t c) {
  return {plan.polygon[c], plan.polygon[(c + 1) % plan.polygon.size()]};
}

// Given curves share a side by their parameters, so that the speed along it goes on.
void place_given(PolygonPlan& plan, size_t c) {
  const std::vector<size_t> pieces = plan.outline.side(c);
  const auto [a, b] = ends_of_side(plan, c);
  double whole = 0, before = 0;
  for (const size_t p : pieces) {
    const HermiteCurve& curve = plan.outline.pieces[p].stretch.given->curve;
    whole += curve.end() - curve.start();
  }
  for (const size_t p : pieces) {
    const auto& piece = plan.outline.pieces[p];
    Strip& strip = plan.strips[p];
    strip.line = piece.stretch.line(piece.flipped);
    strip.flipped = piece.flipped;
    strip.fitted = piece.stretch.given_along(piece.flipped);
    strip.from = a + before / whole * (b - a);
    before += strip.fitted.end() - strip.fitted.start();
    strip.to = p == pieces.back() ? b : Vec2(a + before / whole * (b - a));
  }
}

HermiteCurve stretched(const HermiteCurve& curve, double factor) {
  std::vector<double> u = curve.parameters();
  for (double& x : u) x *= factor;
  return {CurveMesh(u), curve.dofs()};
}

// Fits the lines of a side, and shares it by their lengths.
void place_fitted(PolygonPlan& plan, size_t c) {
  const Outline& loop = plan.outline;
  const std::vector<size_t> pieces = loop.side(c);
  const auto [a, b] = ends_of_side(plan, c);
  const double length = loop.side_length(c);
  double before = 0, fraction = 0;
  for (const size_t p : pieces) {
    const auto& piece = loop.pieces[p];
    Strip& strip = plan.strips[p];
    strip.line.name = piece.stretch.name;
    strip.line.curve = piece.flipped ? reversed(piece.stretch.curve) : piece.stretch.curve;
    strip.flipped = piece.flipped;
    strip.fitted = fitted_strip(plan, piece.stretch, joint_at(loop, p),
                                joint_at(loop, (p + 1) % loop.pieces.size()), pieces.size() == 1);
    // The piece's share of the side is rounded, and its parameter stretched by the same hair,
    // so that speed stays continuous where pieces meet.
    before += piece.length;
    const double next = p == pieces.back() ? 1 : rounded(before / length);
    strip.fitted = stretched(strip.fitted, (next - fraction) * length / strip.fitted.end());
    strip.from = a + fraction * (b - a);
    strip.to = a + next * (b - a);
    fraction = next;
  }
}

PolygonPlan plan_of(const Outline& loop, const DomainTask& task, const std::vector<Vec2>* polygon,
                    std::vector<std::string>& warnings) {
  PolygonPlan plan;
  plan.task = task;
  plan.outline = loop;
  SkinOptions& options = plan.task.options;
  // Decided first: the fan needs lines that are cut evenly.
  if (options.mesher == SkinOptions::Mesher::Delaunay && !have_delaunay_mesher()) {
    warnings.push_back("this build has no CGAL: the fan mesher is used instead");
    options.mesher = SkinOptions::Mesher::Fan;
  }
  require_corners(loop, options.corner_angle);
  choose_polygon(plan, polygon);
  warn_of_smoothed_joints(loop, options.corner_angle, warnings);
  plan.strips.resize(loop.pieces.size());
  for (size_t c = 0; c < loop.corners.size(); ++c)
    if (plan.given())
      place_given(plan, c);
    else
      place_fitted(plan, c);
  return plan;
}

std::vector<DomainCorner> corners_of(const PolygonPlan& plan) {
  constexpr double degrees = 180 / std::numbers::pi;
  const std::vector<Vec2>& p = plan.polygon;
  std::vector<DomainCorner> corners;
  for (size_t i = 0, n = p.size(); i < n; ++i) {
    const Vec2 a = p[i] - p[(i + n - 1) % n], b = p[(i + 1) % n] - p[i];
    corners.push_back(
        {p[i], 180 - std::atan2(cross(a, b), a.dot(b)) * degrees, plan.line_angles[i] * degrees});
  }
  return corners;
}

}  // namespace

HermiteCurve fitted_strip(const PolygonPlan& plan, const Stretch& s, const Joint& start,
                          const Joint& end, bool alone) {
  const bool evenly_cut = plan.task.options.mesher == SkinOptions::Mesher::Fan;
  if (alone) {
    constexpr double shortest_edge = 0.3;  // of the target: shorter pieces would crowd the mesh
    const auto exact =
        kept_as_given(s, shortest_edge * plan.task.edge, start.position, end.position);
    if (exact && (exact->segment_count() == 1 || !evenly_cut)) return *exact;
  }
  FitOptions fit;
  fit.tolerance = plan.task.tolerance;
  fit.corner_angle = 180;
  fit.closed = false;
  fit.start = {start.position, start.outgoing};
  fit.end = {end.position, end.incoming};
  fit.even = true;
  fit.halved = evenly_cut;
  return fit_curve(s.name, s.curve, fit);
}

RegionParts polygon_parts(const Outline& loop, const std::vector<Stretch>& inner,
                          const DomainTask& task, const std::vector<Vec2>* polygon,
                          std::vector<Stretch>& others) {
  RegionParts parts;
  PolygonPlan plan = plan_of(loop, task, polygon, parts.warnings);
  using Treatment = CharacterLine::Treatment;
  for (const Stretch& s : inner) {
    std::string reason;
    if (s.treatment != Treatment::Embedded) reason = add_inner_strip(plan, s);
    if (s.treatment == Treatment::Fitted && !reason.empty())
      throw InputError("inner line '" + s.name + "' cannot be fitted: " + reason +
                       "; with treatment = \"embedded\" it may");
    if (s.treatment == Treatment::Embedded || !reason.empty()) others.push_back(s);
  }
  parts.mesh = std::make_shared<ParametricMesh>(mesh_polygon(plan));
  for (const Strip& s : plan.strips) parts.runs.push_back(run_on(*parts.mesh, s));
  parts.boundary.resize(1);
  for (size_t p = 0; p < loop.pieces.size(); ++p)
    parts.boundary[0].push_back(
        {BoundaryPiece::Kind::Run, static_cast<int>(p), plan.strips[p].flipped});
  parts.corners = corners_of(plan);
  return parts;
}

}  // namespace batten
