#include "batten/skinning/domains/loop_area.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "batten/core/errors.h"
#include "batten/skinning/domains/curve_crossing.h"
#include "batten/skinning/domains/hole_triangulation.h"

namespace batten {
namespace {

Vec3 area_vector(const Outline& outline) {
  Vec3 area = Vec3::Zero();
  const Vec3 origin = outline.segments[0].start;
  for (const auto& piece : outline.segments) {
    const auto p = polyline(*piece.segment.curve);
    for (size_t i = 0; i + 1 < p.size(); ++i)
      area += 0.5 * (p[i] - origin).cross(p[i + 1] - origin);
  }
  return area;
}

// Points of the loop, as many of each piece.
struct LoopPoints {
  std::vector<Vec3> x;  // over the size
  int each;             // of a piece
  double height;        // of all points above the loop's plane
};

LoopPoints sample_loop(const Outline& outline, const Vec3& normal) {
  LoopPoints points;
  points.each = static_cast<int>(std::clamp<size_t>(64 / outline.segments.size(), 2, 24));
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto& piece : outline.segments) {
    const InputCurve& c = *piece.segment.curve;
    for (int k = 0; k < points.each; ++k) {
      const Vec3 x = c.evaluate(c.start() + (c.end() - c.start()) * k / points.each) -
                     outline.segments[0].start;
      points.x.push_back(x / outline.size);
      low = std::min(low, points.x.back().dot(normal));
      high = std::max(high, points.x.back().dot(normal));
    }
  }
  points.height = high - low;
  return points;
}

// Whether the loop turns to the left at its corners: seen from its side where it is nearly plane and
// the corner not upright on that plane, as where a wing's edge meets the nose of a section; else as a
// filling has it (a strip around a cylinder faces all ways).
std::vector<char> left_at_corners(const Outline& outline) {
  const Vec3 normal = loop_normal(outline);
  const LoopPoints points = sample_loop(outline, normal);
  constexpr double nearly_plane = 0.2;  // of the size
  constexpr double upright = 0.5;       // cosine of 60 degrees
  constexpr size_t max_points = 400;
  std::vector<double> facing;  // cosine of the angle between a corner's axis and the normal
  for (const int c : outline.corners) {
    const LoopVertex vertex = loop_vertex_at(outline, static_cast<size_t>(c));
    facing.push_back(vertex.incoming.cross(vertex.outgoing).stableNormalized().dot(normal));
  }
  const auto needs_triangulation = [&](double cosine) {
    return points.height >= nearly_plane || std::abs(cosine) < upright;
  };
  std::optional<HoleTriangulation> triangulation;
  if (points.x.size() <= max_points &&
      std::any_of(facing.begin(), facing.end(), needs_triangulation))
    triangulation = developable_triangulation(points.x);
  std::vector<TriangulationCorner> corner_data;
  if (triangulation) corner_data = triangulation_corners(points.x, *triangulation);
  std::vector<char> left;
  for (size_t i = 0; i < facing.size(); ++i) {
    const auto piece = static_cast<size_t>(outline.corners[i]);
    const LoopVertex vertex = loop_vertex_at(outline, piece);
    left.push_back(triangulation && needs_triangulation(facing[i])
                       ? turns_left(vertex.incoming, vertex.outgoing,
                                    corner_data[piece * static_cast<size_t>(points.each)])
                       : facing[i] >= 0);
  }
  return left;
}

}  // namespace

Vec3 loop_normal(const Outline& outline) {
  const Vec3 area = area_vector(outline);
  const double length = area.norm();
  if (!encloses_area(outline))
    throw InputError("the outline encloses no area seen from any side: it folds back on itself");
  return area / length;
}

bool encloses_area(const Outline& outline) {
  return enclosed_area(outline) >= 1e-6 * outline.size * outline.size;
}

double enclosed_area(const Outline& outline) { return area_vector(outline).norm(); }

std::vector<double> corner_angles(const Outline& outline, bool convex) {
  constexpr double pi = std::numbers::pi;
  const std::vector<char> left =
      convex ? std::vector<char>(outline.corners.size(), 1) : left_at_corners(outline);
  std::vector<double> angles;
  for (size_t i = 0; i < left.size(); ++i) {
    const LoopVertex vertex = loop_vertex_at(outline, static_cast<size_t>(outline.corners[i]));
    const double turning_angle = std::atan2(vertex.incoming.cross(vertex.outgoing).norm(),
                                            vertex.incoming.dot(vertex.outgoing));
    angles.push_back(left[i] ? pi - turning_angle : pi + turning_angle);
  }
  return angles;
}

}  // namespace batten
