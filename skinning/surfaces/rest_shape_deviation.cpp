#include "batten/skinning/surfaces/rest_shape_deviation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/skinning/model/rest_shape.h"

namespace batten {
namespace {

constexpr int kSamples = 24;  // of a boundary curve

std::vector<Vec3> samples(const HermiteCurve& curve) {
  std::vector<Vec3> points;
  for (int i = 0; i <= kSamples; ++i)
    points.push_back(curve.evaluate(curve.start() + (curve.end() - curve.start()) * i / kSamples));
  return points;
}

// Largest distance from the chord; of a closed curve the least from its centre.
double depth_of(const HermiteCurve& curve) {
  const std::vector<Vec3> points = samples(curve);
  if (curve.closed()) {
    Vec3 centre = Vec3::Zero();
    for (int i = 0; i < kSamples; ++i) centre += points[i] / kSamples;
    double least = std::numeric_limits<double>::infinity();
    for (const Vec3& p : points) least = std::min(least, (p - centre).norm());
    return least;
  }
  const Vec3 chord = points.back() - points.front();
  const Vec3 way = chord.norm() > 0 ? Vec3(chord.normalized()) : Vec3::Zero();
  double most = 0;
  for (const Vec3& p : points) {
    const Vec3 d = p - points.front();
    most = std::max(most, (d - way.dot(d) * way).norm());
  }
  return most;
}

double length_of(const HermiteCurve& curve) {
  const std::vector<Vec3> points = samples(curve);
  double length = 0;
  for (size_t i = 0; i + 1 < points.size(); ++i) length += (points[i + 1] - points[i]).norm();
  return length;
}

}  // namespace

std::optional<RestShapeDeviation> rest_shape_deviation(const RegionLayout& layout,
                                                       const SkinnedRegion& made) {
  const Points rest = rest_dofs(layout);
  if (rest.rows() == 0 || rest.rows() != made.surface.dofs().rows()) return std::nullopt;
  RestShapeDeviation found;
  const DofMap map(*layout.mesh());
  for (int v = 0; v < layout.mesh()->vertex_count(); ++v) {
    const Vec3 x = made.surface.dofs().row(map.vertex(v)), x_rest = rest.row(map.vertex(v));
    if (!((x - x_rest).norm() > found.distance)) continue;
    found.distance = (x - x_rest).norm();
    found.at = x;
  }
  double around = 0, depth = std::numeric_limits<double>::infinity();
  for (const auto& loop : layout.boundary())
    for (const BoundarySegment& piece : loop) {
      const auto i = static_cast<size_t>(piece.index);
      const HermiteCurve& curve = piece.kind == BoundarySegment::Kind::EdgeAligned
                                      ? layout.edge_aligned()[i].fitted
                                      : layout.embedded()[i].fitted;
      around += length_of(curve);
      const double of_curve = depth_of(curve);
      if (of_curve > 1e-2 * layout.size()) depth = std::min(depth, of_curve);
    }
  if (std::isfinite(depth)) found.depth = depth;
  const Surface surface(layout.mesh(), layout.element(), rest, layout.trim());
  double area = 0;
  for (int t = 0; t < layout.mesh()->triangle_count(); ++t)
    area += surface.area_vector({t, Vec3::Constant(1.0 / 3)}).norm() * layout.mesh()->shape(t).area;
  const double quarter = around / 4;
  found.across = quarter - std::sqrt(std::max(0.0, quarter * quarter - area));
  return found;
}

}  // namespace batten
