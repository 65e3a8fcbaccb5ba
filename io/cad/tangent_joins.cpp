#include "batten/io/cad/tangent_joins.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "batten/core/index.h"

namespace batten {
namespace {

constexpr int kPieces = 256;      // of a stretch
constexpr double kNearby = 0.03;  // of a stretch, on either side: what normals are smoothed over

/// A piece of a line, and its two sides.
struct Join {
  std::array<FaceStretch*, 2> stretches;
  std::array<const TangentSide*, 2> sides;
  double same = 1;                               // -1: the normals of the sides are opposite
  std::vector<std::array<Vec3, 2>> of_surfaces;  // along the line, zero: the sides are no planes
  std::vector<Vec3> common;                      // seen from the first side

  /// Of a place along the line: its number along the stretch.
  int index(int side, int k) const {
    return stretches[static_cast<size_t>(side)]->reversed ? kPieces - k : k;
  }
  bool tangent(int k) const { return !of_surfaces[static_cast<size_t>(k)][0].isZero(); }
};

Vec3 normal_at(const FaceStretch& stretch, const TangentSide& side, int k) {
  const double share = double(k) / kPieces;
  return side.normal(k == kPieces
                         ? stretch.last()
                         : stretch.uv(stretch.curve.start() +
                                      share * (stretch.curve.end() - stretch.curve.start())));
}

void compare_sides(Join& join) {
  for (int k = 0; k <= kPieces; ++k) {
    const Vec3 one = normal_at(*join.stretches[0], *join.sides[0], join.index(0, k)),
               other = normal_at(*join.stretches[1], *join.sides[1], join.index(1, k));
    const bool tangent =
        !one.isZero() && !other.isZero() && angle_between_planes(one, other) <= kTangentDeg;
    join.of_surfaces.push_back({tangent ? one : Vec3::Zero(), tangent ? other : Vec3::Zero()});
    if (tangent) join.same = one.dot(other) < 0 ? -1 : 1;  // shells need not be orientable
  }
}

/// The common normals, without what is shorter than a face's knots can follow: parabolas through what
/// is nearby. (Surfaces that bend sharply at a corner have the tip of their bend in one element.)
void smooth(Join& join) {
  const int reach = static_cast<int>(kNearby * kPieces);
  join.common.assign(kPieces + 1, Vec3::Zero());
  for (int k = 0; k <= kPieces; ++k) {
    if (!join.tangent(k)) continue;
    Mat3 A = Mat3::Zero(), b = Mat3::Zero();
    for (int i = std::max(0, k - reach); i <= std::min(kPieces, k + reach); ++i) {
      if (!join.tangent(i)) continue;
      const double s = double(i - k) / (reach + 1), w = std::pow(1 - std::abs(s * s * s), 3);
      const Vec3 powers(1, s, s * s);
      const auto& [one, other] = join.of_surfaces[static_cast<size_t>(i)];
      A += w * powers * powers.transpose();
      b += w * powers * (one + join.same * other).transpose() / 2;
    }
    join.common[static_cast<size_t>(k)] =
        Vec3(Eigen::CompleteOrthogonalDecomposition<Mat3>(A).solve(b).row(0)).normalized();
  }
}

/// Ends of joins in one place, whose planes are one but for what smoothing did.
struct Corner {
  Vec3 sum = Vec3::Zero();
  std::vector<std::pair<Join*, int>> ends;
};
using Place = std::pair<std::string, int>;  // a cut of a line; "" and a number of the plan's

Place place_of(const StepPlan& plan, const LinePiece& piece, bool end) {
  const StepLine& line = plan.lines.at(piece.first);
  const int cut = piece.second + (end ? 1 : 0);
  if (cut == 0 || cut == count_of(line.cuts) + 1) return {"", line.places[cut > 0]};
  return {piece.first, cut};
}

/// A face has one plane at its corner: all joins there get it, fading out along them.
void agree(const Corner& corner) {
  constexpr double fade = 0.3;  // of a join
  for (const auto& [join, k] : corner.ends) {
    const Vec3 end = join->common[static_cast<size_t>(k)];
    const Vec3 turn = (end.dot(corner.sum) < 0 ? -1 : 1) * corner.sum.normalized() - end;
    for (int i = 0; i <= kPieces; ++i) {
      const double s = std::abs(i - k) / (fade * kPieces);
      if (s < 1 && join->tangent(i))
        join->common[static_cast<size_t>(i)] += (1 - s) * (1 - s) * (1 + 2 * s) * turn;
    }
  }
}

void agree_at_corners(const StepPlan& plan, std::map<LinePiece, Join>& joins) {
  constexpr double alike_deg = 5;
  std::map<Place, std::vector<Corner>> corners;
  for (auto& [piece, join] : joins)
    for (const bool end : {false, true}) {
      const int k = end ? kPieces : 0;
      if (!join.tangent(k)) continue;
      const Vec3& n = join.common[static_cast<size_t>(k)];
      auto& here = corners[place_of(plan, piece, end)];
      auto corner = std::find_if(here.begin(), here.end(), [&](const Corner& c) {
        return angle_between_planes(c.sum, n) < alike_deg;
      });
      if (corner == here.end()) corner = here.emplace(here.end());
      corner->sum += n.dot(corner->sum) < 0 ? -n : n;
      corner->ends.emplace_back(&join, k);
    }
  for (const auto& [place, here] : corners)
    for (const Corner& corner : here) agree(corner);
}

void set_turns(Join& join) {
  for (const size_t side : {0, 1}) {
    auto& turns = join.stretches[side]->turns;
    turns.assign(kPieces + 1, std::nullopt);
    for (int k = 0; k <= kPieces; ++k) {
      if (!join.tangent(k)) continue;
      const auto at = static_cast<size_t>(k);
      const Vec3 common = (side == 0 ? 1 : join.same) * join.common[at].normalized();
      turns[static_cast<size_t>(join.index(static_cast<int>(side), k))] =
          common - join.of_surfaces[at][side];
    }
  }
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
  std::map<LinePiece, std::vector<std::pair<FaceStretch*, const TangentSide*>>> beside;
  for (const TangentSide& side : sides)
    for (FaceLoop& loop : side.boundary->loops)
      for (FaceStretch& stretch : loop)
        if (stretch.shared) beside[piece_of(plan, stretch)].emplace_back(&stretch, &side);
  std::map<LinePiece, Join> joins;
  for (const auto& [piece, two] : beside) {
    if (two.size() != 2) continue;
    Join join;
    join.stretches = {two[0].first, two[1].first};
    join.sides = {two[0].second, two[1].second};
    compare_sides(join);
    int tangent = 0;
    for (int k = 0; k <= kPieces; ++k) tangent += join.tangent(k);
    if (2 * tangent < kPieces) continue;  // a crease that begins or ends as a tangent
    smooth(join);
    joins.emplace(piece, std::move(join));
  }
  agree_at_corners(plan, joins);
  for (auto& [piece, join] : joins) set_turns(join);
}

}  // namespace batten
