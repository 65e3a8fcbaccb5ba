// Levenberg-Marquardt over the corners of a polygon.
#include "batten/skinning/domains/polygon_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "batten/core/planar_geometry.h"

namespace batten {
namespace {

using std::numbers::pi;
constexpr double kLengthWeight = 1, kAngleWeight = 0.7, kPenaltyWeight = 0.7,
                 kDistanceWeight = 0.25;
constexpr size_t kMaxDistanceCorners = 24;  // with more corners, lengths and angles say enough

using Polygon = std::vector<Vec2>;

struct Value {
  double value, slope;
};

// By how much the Jacobian at a corner, sin(line angle) / sin(domain angle), is below 1/2 or above
// 2, in logarithms; it goes on in a straight line where the corner turns the other way.
Value jacobian_penalty(double angle, double line_angle) {
  constexpr double least = 0.05;
  const double wanted = std::sin(line_angle), sine = std::sin(angle), cosine = std::cos(angle);
  if (std::abs(wanted) < 1e-9) return {0, 0};
  const double ratio = sine / wanted;  // below 0: the other way
  if (ratio > 2) return {std::log(ratio / 2), cosine / sine};
  if (ratio < least)
    return {std::log(0.5 / least) + (least - ratio) / least, -cosine / (wanted * least)};
  if (ratio < 0.5) return {std::log(0.5 / ratio), -cosine / sine};
  return {0, 0};
}

class PolygonFit {
 public:
  /// Without corners in space there are no penalties and no distances, and all angles have one
  /// weight.
  PolygonFit(const std::vector<double>& lengths, const std::vector<double>& angles,
             const std::vector<Vec3>* corners)
      : penalized_(corners != nullptr),
        n_(lengths.size()),
        lengths_(lengths),
        angles_(angles),
        perimeter_(std::accumulate(lengths.begin(), lengths.end(), 0.0)) {
    // At a corner the Jacobian changes by cot φ per radian: where a corner is nearly straight, or
    // sharp, its angle must be kept the better.
    for (const double angle : angles) {
      constexpr double min_sine = 1e-3;
      const double cotangent = std::cos(angle) / std::max(std::abs(std::sin(angle)), min_sine);
      weights_.push_back(kAngleWeight * (penalized_ ? std::max(1.0, std::abs(cotangent)) : 1));
    }
    for (size_t i = 0; i < n_ && n_ <= kMaxDistanceCorners && corners; ++i)
      for (size_t j = i + 2; j < n_; ++j) {
        if (i == 0 && j + 1 == n_) continue;
        const double in_space = std::max(((*corners)[i] - (*corners)[j]).norm(), 1e-3 * perimeter_);
        pairs_.push_back({i, j, in_space});
      }
  }

  /// Moves a simple polygon to a minimum of the sum of squares, which is returned.
  double minimize(Polygon& p) {
    double cost = sum(p, true);
    double damping = 1e-3;
    for (int step = 0; step < 200 && damping < 1e8; ++step) {
      MatX H = H_;
      H.diagonal().array() += damping * H_.diagonal().maxCoeff();
      const VecX move = -H.ldlt().solve(g_);
      Polygon q = p;
      for (size_t i = 0; i < n_; ++i) q[i] += move.segment<2>(2 * static_cast<long>(i));
      // A step that folds the polygon is refused.
      const double next = is_simple_and_ccw(q) ? sum(q, false) : cost;
      if (next < cost) {
        const bool converged = move.norm() < 1e-10 * perimeter_;
        p = q;
        cost = sum(p, true);
        damping = std::max(1e-9, damping / 5);
        if (converged) break;
      } else {
        damping *= 5;
      }
    }
    return cost;
  }

 private:
  struct Pair {
    size_t i, j;
    double in_space;
  };

  // The sum of squared residuals; `derivatives`: JᵀJ and Jᵀr too.
  double sum(const Polygon& p, bool derivatives) {
    double total = 0;
    if (derivatives) {
      H_.setZero(2 * static_cast<long>(n_), 2 * static_cast<long>(n_));
      g_.setZero(2 * static_cast<long>(n_));
    }
    // A residual and its gradients with respect to a few corners.
    const auto add = [&](double r, const auto& corners, const auto& gradients) {
      total += r * r;
      if (!derivatives) return;
      for (size_t a = 0; a < corners.size(); ++a) {
        const long row = 2 * static_cast<long>(corners[a]);
        g_.segment<2>(row) += r * gradients[a];
        for (size_t b = 0; b < corners.size(); ++b)
          H_.block<2, 2>(row, 2 * static_cast<long>(corners[b])) +=
              gradients[a] * gradients[b].transpose();
      }
    };
    const auto perpendicular = [](const Vec2& d) {
      return Vec2(Vec2(-d.y(), d.x()) / d.squaredNorm());
    };
    using Two = std::array<Vec2, 2>;
    using Three = std::array<Vec2, 3>;
    for (size_t i = 0; i < n_; ++i) {
      const size_t before = (i + n_ - 1) % n_, after = (i + 1) % n_;
      const Vec2 a = p[i] - p[before], b = p[after] - p[i];
      const Vec2 length_gradient = kLengthWeight * b / b.squaredNorm();
      add(kLengthWeight * std::log(std::max(b.norm(), 1e-12 * perimeter_) / lengths_[i]),
          std::array{i, after}, Two{-length_gradient, length_gradient});

      const double angle = pi - std::atan2(cross(a, b), a.dot(b));
      const Three angle_gradient{-perpendicular(a), perpendicular(a) + perpendicular(b),
                                 -perpendicular(b)};
      const auto by_angle = [&](double r, double slope) {
        add(r, std::array{before, i, after},
            Three{slope * angle_gradient[0], slope * angle_gradient[1], slope * angle_gradient[2]});
      };
      by_angle(weights_[i] * (angle - angles_[i]), weights_[i]);
      const Value wall = jacobian_penalty(angle, angles_[i]);
      if (penalized_ && wall.value > 0)
        by_angle(kPenaltyWeight * wall.value, kPenaltyWeight * wall.slope);
    }
    for (const Pair& pair : pairs_) {
      // A surface between two corners is longer than the straight line, never shorter.
      const Vec2 d = p[pair.j] - p[pair.i];
      const double length = std::max(d.norm(), 1e-6 * perimeter_);
      if (length >= pair.in_space) continue;
      const Vec2 length_gradient = kDistanceWeight * d / (length * length);
      add(kDistanceWeight * std::log(length / pair.in_space), std::array{pair.i, pair.j},
          Two{-length_gradient, length_gradient});
    }
    return total;
  }

  bool penalized_;
  size_t n_;
  std::vector<double> lengths_, angles_, weights_;
  std::vector<Pair> pairs_;
  double perimeter_;
  MatX H_;
  VecX g_;
};

// Corners on a circle, as far apart along it as the sides are long.
Polygon circle(const std::vector<double>& lengths) {
  Polygon p;
  const double around = std::accumulate(lengths.begin(), lengths.end(), 0.0);
  double along = 0;
  for (const double l : lengths) {
    const double t = 2 * pi * along / around;
    p.push_back(around / (2 * pi) * Vec2(std::cos(t), std::sin(t)));
    along += l;
  }
  return p;
}

}  // namespace

bool is_simple_and_ccw(const std::vector<Vec2>& p) {
  const size_t n = p.size();
  double area = 0;
  for (size_t i = 0; i < n; ++i) area += 0.5 * cross(p[i], p[(i + 1) % n]);
  if (!(area > 0)) return false;
  for (size_t i = 0; i < n; ++i)
    for (size_t j = i + 1; j < n; ++j) {
      if (j == i + 1 || (i == 0 && j + 1 == n)) continue;
      const Vec2 &a = p[i], &b = p[(i + 1) % n], &c = p[j], &d = p[(j + 1) % n];
      // Apart, though they may lie on one line.
      if ((a.cwiseMax(b).array() < c.cwiseMin(d).array()).any() ||
          (c.cwiseMax(d).array() < a.cwiseMin(b).array()).any())
        continue;
      if (cross(b - a, c - a) * cross(b - a, d - a) <= 0 &&
          cross(d - c, a - c) * cross(d - c, b - c) <= 0)
        return false;
    }
  return true;
}

std::vector<Vec2> fit_polygon(const std::vector<double>& lengths, const std::vector<double>& angles,
                              const std::vector<Vec3>& corners, const Vec3& normal) {
  std::array<Polygon, 2> starts{Polygon(), circle(lengths)};
  const Vec3 e1 = normal.unitOrthogonal(), e2 = normal.cross(e1);
  for (const Vec3& c : corners) starts[0].emplace_back(c.dot(e1), c.dot(e2));
  PolygonFit fit(lengths, angles, &corners);
  Polygon best;
  double least = std::numeric_limits<double>::infinity();
  for (Polygon& p : starts) {
    if (!is_simple_and_ccw(p)) continue;
    const double cost = fit.minimize(p);
    if (cost < least) {
      least = cost;
      best = p;
    }
  }
  if (best.empty())
    throw NoPolygonError(
        "no simple polygon has these side lengths and angles: the outline is too "
        "twisted for one flat domain");
  return best;
}

std::vector<Vec2> relax_polygon(const std::vector<double>& lengths,
                                const std::vector<double>& angles) {
  Polygon p = circle(lengths);
  if (!is_simple_and_ccw(p)) throw InputError("no simple polygon has sides of these lengths");
  PolygonFit(lengths, angles, nullptr).minimize(p);
  return p;
}

}  // namespace batten
