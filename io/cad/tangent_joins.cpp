#include "batten/io/cad/tangent_joins.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace batten {
namespace {

constexpr int kPieces = 128;  // of a stretch

struct Place {
  FaceStretch* stretch;
  const TangentSide* side;
};

/// Compares two sides of one piece at a share of it along the line.
void compare(const Place& a, const Place& b, int k) {
  const auto index = [&](const Place& place) { return place.stretch->reversed ? kPieces - k : k; };
  const auto normal = [&](const Place& place) -> Vec3 {
    const HermiteCurve& curve = place.stretch->curve;
    const double share = double(index(place)) / kPieces;
    return place.side->normal(
        index(place) == kPieces
            ? place.stretch->last()
            : place.stretch->uv(curve.start() + share * (curve.end() - curve.start())));
  };
  const Vec3 one = normal(a), other = normal(b);
  if (one.isZero() || other.isZero()) return;
  if (angle_between_planes(one, other) > kTangentDeg) return;
  const double same = one.dot(other) < 0 ? -1 : 1;  // shells need not be orientable
  const Vec3 half = (same * other - one) / 2;
  a.stretch->turns[index(a)] = half;
  b.stretch->turns[index(b)] = -same * half;
}

}  // namespace

LinePiece piece_of(const StepPlan& plan, const FaceStretch& stretch) {
  const double middle = stretch.line_parameter((stretch.curve.start() + stretch.curve.end()) / 2);
  const std::vector<double>& cuts = plan.lines.at(stretch.line).cuts;
  return {stretch.line,
          static_cast<int>(std::lower_bound(cuts.begin(), cuts.end(), middle) - cuts.begin())};
}

double angle_between_planes(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b))) * 180 / std::numbers::pi;
}

void find_tangent_joins(const StepPlan& plan, const std::vector<TangentSide>& sides) {
  std::map<LinePiece, std::vector<Place>> places;
  for (const TangentSide& side : sides)
    for (FaceLoop& loop : side.boundary->loops)
      for (FaceStretch& stretch : loop)
        if (stretch.shared) places[piece_of(plan, stretch)].push_back({&stretch, &side});
  for (const auto& [piece, beside] : places) {
    if (beside.size() != 2) continue;
    for (const Place& place : beside) place.stretch->turns.assign(kPieces + 1, std::nullopt);
    for (int k = 0; k <= kPieces; ++k) compare(beside[0], beside[1], k);
  }
}

}  // namespace batten
