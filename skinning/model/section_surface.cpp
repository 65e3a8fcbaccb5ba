// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/model/section_surface.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/fem/surface.h"

namespace batten {

bool is_annulus(const RegionLayout& region) { return region.mesh()->period() > 0; }

int domain_side(const RegionLayout& region, const EdgeAlignedLine& run) {
  const auto& at = region.mesh()->vertices();
  const size_t middle = run.vertices.size() / 2;
  const Vec2 p = 0.5 * (at[run.vertices[middle - 1]] + at[run.vertices[middle]]);
  int nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 4; ++k) {
    const Vec2 from = region.corners()[k].uv, direction = region.corners()[(k + 1) % 4].uv - from;
    const double f = std::clamp(direction.dot(p - from) / direction.squaredNorm(), 0.0, 1.0);
    const double distance = (from + f * direction - p).norm();
    if (distance >= least) continue;
    least = distance;
    nearest = k;
  }
  return nearest;
}

namespace {

/// The map from (s, t) to the domain of a region; s runs along the given side.
BilinearMap map_of(const RegionLayout& region, int side) {
  const ParametricMesh& mesh = *region.mesh();
  if (is_annulus(region)) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Vec2& p : mesh.vertices()) {
      low = std::min(low, p.y());
      high = std::max(high, p.y());
    }
    const double u = mesh.vertices()[0].x(), period = mesh.period();
    return BilinearMap(
        {Vec2(u, low), Vec2(u + period, low), Vec2(u + period, high), Vec2(u, high)});
  }
  std::array<Vec2, 4> corners;
  for (size_t k = 0; k < 4; ++k) corners[k] = region.corners()[k].uv;
  if (side % 2 == 1) std::swap(corners[1], corners[3]);
  return BilinearMap(corners);
}

}  // namespace

SectionSurface::SectionSurface(const RegionLayout& region, int side)
    : region_(region), annulus_(is_annulus(region)), map_(map_of(region, side)) {
  const ParametricMesh& mesh = *region.mesh();
  for (const EdgeAlignedLine& run : region.edge_aligned()) {
    const bool outline = run.line.role == CharacterLine::Role::Outline;
    if (!outline || annulus_ || domain_side(region, run) % 2 == side % 2)
      add(run.fitted, edge_aligned_pcurve(mesh, run));
  }
  for (const EmbeddedLine& line : region.embedded())
    if (line.line.role == CharacterLine::Role::Inner) add(line.fitted, line.pcurve);
}

double SectionSurface::s_of(const Piece& piece, double parameter) const {
  return map_.inverse(drop_z(piece.pcurve.evaluate(parameter)))[0];
}

void SectionSurface::add(HermiteCurve curve, HermiteCurve pcurve) {
  Piece piece{std::move(curve), std::move(pcurve), {}, {}};
  constexpr int kSamples = 8;  // per segment
  const auto& nodes = piece.curve.parameters();
  for (size_t i = 0; i + 1 < nodes.size(); ++i)
    for (int k = 0; k < kSamples; ++k)
      piece.at.push_back(nodes[i] + (nodes[i + 1] - nodes[i]) * k / kSamples);
  piece.at.push_back(piece.curve.end());
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (double& at : piece.at) {
    // A closed pcurve ends where it begins, one period of s further.
    const bool last = &at == &piece.at.back();
    double s = s_of(piece, at);
    if (last && piece.curve.closed() && !piece.s.empty())
      s = piece.s.front() + (piece.s.back() > piece.s.front() ? 1 : -1);
    piece.s.push_back(s);
    const double t = map_.inverse(drop_z(piece.pcurve.evaluate(at)))[1];
    low = std::min(low, t);
    high = std::max(high, t);
  }
  const auto [least, most] = std::minmax_element(piece.s.begin(), piece.s.end());
  if (*most - *least > high - low) pieces_.push_back(std::move(piece));
}

std::optional<double> SectionSurface::parameter_at(const Piece& piece, double s) const {
  for (size_t i = 0; i + 1 < piece.s.size(); ++i) {
    const double a = piece.s[i], b = piece.s[i + 1];
    for (int around = annulus_ ? -2 : 0; around <= (annulus_ ? 2 : 0); ++around) {
      const double wanted = s + around;
      constexpr double kNear = 1e-9;
      if (a == b || wanted < std::min(a, b) - kNear || wanted > std::max(a, b) + kNear) continue;
      // In between, pcurves are straight or nearly so.
      double f = std::clamp((wanted - a) / (b - a), 0.0, 1.0);
      const double step = piece.at[i + 1] - piece.at[i];
      for (int round = 0; round < 4 && f > 0 && f < 1; ++round) {
        const double miss = wanted - s_of(piece, piece.at[i] + f * step);
        f = std::clamp(f + (miss - std::round(annulus_ ? miss : 0)) / (b - a), 0.0, 1.0);
      }
      return piece.at[i] + f * step;
    }
  }
  return std::nullopt;
}

Vec2 SectionSurface::inside(Vec2 st) const {
  for (int i = annulus_; i < 2; ++i) st[i] = std::clamp(st[i], 0.0, 1.0);
  return st;
}

Vec3 SectionSurface::evaluate_at(const Vec2& st_point, Vec3* by_t) const {
  std::vector<std::pair<double, Vec3>> points;
  for (const Piece& piece : pieces_)
    if (const auto p = parameter_at(piece, st_point[0]))
      points.emplace_back(map_.inverse(drop_z(piece.pcurve.evaluate(*p)))[1],
                          piece.curve.evaluate(*p));
  std::sort(points.begin(), points.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  constexpr double kSameTolerance = 1e-6;
  points.erase(
      std::unique(points.begin(), points.end(),
                  [&](const auto& a, const auto& b) { return b.first - a.first < kSameTolerance; }),
      points.end());
  const int count = isize(points);
  if (count < 2) {  // the sections do not extend to this s
    if (by_t) by_t->setZero();
    return points.empty() ? Vec3(Vec3::Zero()) : points[0].second;
  }
  std::vector<double> t, chord{0};
  Points x(count, 3), run = Points::Zero(count, 3);
  for (int i = 0; i < count; ++i) {
    t.push_back(points[i].first);
    x.row(i) = points[i].second;
    if (i > 0) chord.push_back(chord.back() + (x.row(i) - x.row(i - 1)).norm());
    run(i, 0) = chord.back();
  }
  if (!(chord.back() > 0)) {
    if (by_t) by_t->setZero();
    return points[0].second;
  }
  // The spline's own parameter is the chord length, a smooth and monotonic function of t.
  Points speed = not_a_knot_slopes(t, run);
  for (int i = 0; i < count; ++i) {
    double most = std::numeric_limits<double>::infinity();
    for (const int k : {i - 1, i})
      if (k >= 0 && k + 1 < count)
        most = std::min(most, 3 * (chord[k + 1] - chord[k]) / (t[k + 1] - t[k]));
    speed(i, 0) = std::clamp(speed(i, 0), 0.1 * most, most);
  }
  const HermiteCurve along(t, run, speed);
  const double u = along.evaluate(st_point[1])[0];
  const HermiteCurve spline(chord, x, not_a_knot_slopes(chord, x));
  if (by_t) *by_t = spline.evaluate(u, 1) * along.evaluate(st_point[1], 1)[0];
  return spline.evaluate(u);
}

SectionSurface::Slopes SectionSurface::slopes(const Vec2& st_point) const {
  Slopes slopes;
  slopes.x = evaluate_at(st_point, &slopes.by_t);
  constexpr double h = 1e-5;
  const auto beside = [&](double step) {
    return evaluate_at({st_point[0] + step, st_point[1]}, nullptr);
  };
  if (annulus_ || (st_point[0] > h && st_point[0] < 1 - h)) {
    slopes.by_s = (beside(h) - beside(-h)) / (2 * h);
  } else {
    const double in = st_point[0] > 0.5 ? -h : h;
    slopes.by_s = (4 * beside(in) - 3 * slopes.x - beside(2 * in)) / (2 * in);
  }
  return slopes;
}

Points SectionSurface::dofs() const {
  return interpolate_surface(*region_.mesh(), [this](const Vec2& uv) {
    const Vec2 st_point = inside(map_.inverse(uv));
    const Slopes s = slopes(st_point);
    Eigen::Matrix<double, 3, 2> by_st;
    by_st << s.by_s, s.by_t;
    return FirstOrderJet{s.x, by_st * map_.jacobian(st_point).inverse()};
  });
}

}  // namespace batten
