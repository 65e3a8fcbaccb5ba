// SPDX-License-Identifier: MPL-2.0
// Levenberg-Marquardt fits over the corners of a polygon.

#include "batten/skinning/region/polygon_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"

namespace batten {
namespace {

using std::numbers::pi;
constexpr double kLengthWeight = 1, kAngleWeight = 0.7, kPenaltyWeight = 0.7,
                 kDistanceWeight = 0.25;
constexpr size_t kMaxDistanceCorners = 24;  // with more corners, lengths and angles suffice

using Polygon = std::vector<Vec2>;

struct Value {
  double value, slope;
};

// Penalty on the Jacobian at a corner, sin(line angle) / sin(domain angle): the logarithm of how
// far it is below 1/2 or above 2. It is continued linearly if the corner inverts.
Value jacobian_penalty(double angle, double line_angle) {
  constexpr double least = 0.05;
  const double wanted = std::sin(line_angle), sine = std::sin(angle), cosine = std::cos(angle);
  if (std::abs(wanted) < 1e-9) return {0, 0};
  const double ratio = sine / wanted;  // below 0: inverted
  if (ratio > 2) return {std::log(ratio / 2), cosine / sine};
  if (ratio < least)
    return {std::log(0.5 / least) + (least - ratio) / least, -cosine / (wanted * least)};
  if (ratio < 0.5) return {std::log(0.5 / ratio), -cosine / sine};
  return {0, 0};
}

class PolygonFit {
 public:
  /// Without `corners` (in space) there are no penalties and no distances, and all angles have
  /// equal weight.
  PolygonFit(const std::vector<double>& lengths, const std::vector<double>& angles,
             const std::vector<Vec3>* corners)
      : penalized_(corners != nullptr),
        n_(lengths.size()),
        lengths_(lengths),
        angles_(angles),
        perimeter_(std::accumulate(lengths.begin(), lengths.end(), 0.0)) {
    // At a corner the Jacobian changes by cot φ per radian, so the angles of nearly straight and of
    // sharp corners get larger weights.
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

  /// Minimises the sum of squares, starting from a simple polygon; returns that sum.
  double minimize(Polygon& p) {
    double cost = sum(p, true);
    double damping = 1e-3;
    for (int step = 0; step < 200 && damping < 1e8; ++step) {
      MatX H = H_;
      H.diagonal().array() += damping * H_.diagonal().maxCoeff();
      const VecX move = -H.ldlt().solve(g_);
      Polygon q = p;
      for (size_t i = 0; i < n_; ++i) q[i] += move.segment<2>(2 * static_cast<long>(i));
      // A step that makes the polygon self-intersect is rejected.
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

  // Sum of squared residuals; with `derivatives` also JᵀJ and Jᵀr.
  double sum(const Polygon& p, bool derivatives) {
    double total = 0;
    if (derivatives) {
      H_.setZero(2 * static_cast<long>(n_), 2 * static_cast<long>(n_));
      g_.setZero(2 * static_cast<long>(n_));
    }
    // Adds a residual and its gradients with respect to a few corners.
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
      // The path on a surface between two corners is never shorter than the straight line: only
      // shorter distances are penalised.
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

// Corners on a circle, spaced in proportion to the side lengths.
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
      // Disjoint boxes: such sides do not meet, though they may lie on one straight line.
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
        "twisted for one polygonal domain");
  return best;
}

std::vector<Vec2> relax_polygon(const std::vector<double>& lengths,
                                const std::vector<double>& angles) {
  Polygon p = circle(lengths);
  if (!is_simple_and_ccw(p)) throw InputError("no simple polygon has sides of these lengths");
  PolygonFit(lengths, angles, nullptr).minimize(p);
  return p;
}

namespace {

// Mean value coordinates [Floater2003] of a point inside the polygon or on a side.
VecX mean_value_coordinates(const std::vector<Vec2>& polygon, const Vec2& p, double tolerance) {
  const size_t n = polygon.size();
  VecX w = VecX::Zero(static_cast<long>(n));
  std::vector<double> half(n);  // tangents of half the angles of the sides, seen from p
  double rotation_angle = 0;
  for (size_t i = 0; i < n; ++i) {
    const Vec2 a = polygon[i] - p, b = polygon[(i + 1) % n] - p, side = b - a;
    const double along = -a.dot(side) / side.squaredNorm();
    if (std::abs(cross(a, b)) <= tolerance * side.norm() && along > -1e-9 && along < 1 + 1e-9) {
      w.setZero();
      w[static_cast<long>(i)] = 1 - along;
      w[static_cast<long>((i + 1) % n)] = along;
      return w;
    }
    const double angle = std::atan2(cross(a, b), a.dot(b));
    half[i] = std::tan(0.5 * angle);
    rotation_angle += angle;
  }
  if (!(rotation_angle > 1))  // inside: 2π, outside: 0
    throw InputError("the mesh is not inside of its polygon");
  for (size_t i = 0; i < n; ++i)
    w[static_cast<long>(i)] = (half[(i + n - 1) % n] + half[i]) / (polygon[i] - p).norm();
  return w / w.sum();
}

// ½ log M of a symmetric positive definite matrix, as a vector with the same norm.
Vec3 half_log(const Mat2& M) {
  const double mean = 0.5 * M.trace(), d = 0.5 * (M(0, 0) - M(1, 1)), s = M(0, 1);
  const double r = std::hypot(d, s);
  const double high = mean + r, low = (M(0, 0) * M(1, 1) - s * s) / high;
  // log M = (sum of logs)/2 + (difference of logs)/2 · deviator / r
  const double sum = 0.25 * std::log(high * low);
  const double scale = r > 1e-12 * mean ? 0.25 * std::log(high / low) / r : 0.5 / mean;
  return std::sqrt(2.0) * Vec3(sum, scale * d, scale * s);
}

// The surface's triangles, and the deformation of their domain as a function of the corners.
class DomainMap {
 public:
  explicit DomainMap(const Surface& surface) {
    const ParametricMesh& mesh = surface.mesh();
    // Of a trimmed surface, triangles whose centroids lie outside are excluded.
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      const Vec3 centroid = Vec3::Constant(1.0 / 3);
      if (surface.trim() && surface.trim()->side(t) != Trim::Side::Inside &&
          !surface.trim()->loops().contains(mesh.shape(t).point(centroid)))
        continue;
      const SurfaceJet jet = surface.jet({t, centroid});
      Eigen::Matrix<double, 3, 2> J;
      J << jet.x_u, jet.x_v;
      metric_.push_back(J.transpose() * J);
      area_.push_back(mesh.shape(t).area);
      weight_.push_back(area_.back() * std::sqrt(metric_.back().determinant()));
    }
  }

  void set_polygon(const ParametricMesh& mesh, const std::vector<Vec2>& polygon) {
    const double tolerance = 1e-9 * bounding_box(polygon).diagonal().norm();
    std::vector<VecX> weights;
    for (const Vec2& p : mesh.vertices())
      weights.push_back(mean_value_coordinates(polygon, p, tolerance));
    weight_gradients_.assign(polygon.size(), Eigen::Matrix2Xd::Zero(2, mesh.triangle_count()));
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      const TriangleShape shape = mesh.shape(t);
      for (int i = 0; i < 3; ++i) {
        const VecX& of_vertex = weights[mesh.triangles()[t][i]];
        const Vec2 slope = Vec2(shape.b[i], shape.c[i]) / (2 * shape.area);
        for (size_t c = 0; c < weight_gradients_.size(); ++c)
          weight_gradients_[c].col(t) += of_vertex[static_cast<long>(c)] * slope;
      }
    }
  }

  // Deformation gradient of each triangle of the domain for corners q: ∂(new uv)/∂(u, v).
  std::vector<Mat2> domain_gradients(const Eigen::Matrix2Xd& q) const {
    std::vector<Mat2> D(metric_.size(), Mat2::Zero());
    for (size_t c = 0; c < weight_gradients_.size(); ++c)
      for (size_t t = 0; t < D.size(); ++t)
        D[t] += q.col(static_cast<long>(c)) *
                weight_gradients_[c].col(static_cast<long>(t)).transpose();
    return D;
  }

  // Metrics and areas over the deformed domain. Returns false if it is inverted somewhere.
  bool moved(const std::vector<Mat2>& D, std::vector<Mat2>& metric,
             std::vector<double>& area) const {
    metric.resize(metric_.size());
    area.resize(metric_.size());
    for (size_t t = 0; t < metric_.size(); ++t) {
      const double det = D[t].determinant();
      if (!(det > 0)) return false;
      const Mat2 inverse = D[t].inverse();
      metric[t] = inverse.transpose() * metric_[t] * inverse;
      area[t] = area_[t] * det;
    }
    return true;
  }

  // Strains about their mean scale, weighted by the root of the surface area. Returns false if the
  // domain is inverted somewhere.
  bool residual(const std::vector<Mat2>& D, VecX& r) const {
    std::vector<Mat2> metric;
    std::vector<double> area;
    if (!moved(D, metric, area)) return false;
    r.resize(3 * static_cast<long>(metric.size()));
    double scale = 0, total = 0;
    for (size_t t = 0; t < metric.size(); ++t) {
      const Vec3 strain = half_log(metric[t]);
      r.segment<3>(3 * static_cast<long>(t)) = strain;
      scale += weight_[t] * strain[0];
      total += weight_[t];
    }
    for (size_t t = 0; t < metric.size(); ++t) {
      auto strain = r.segment<3>(3 * static_cast<long>(t));
      strain[0] -= scale / total;
      strain *= std::sqrt(weight_[t]);
    }
    return r.allFinite();
  }

  // ∂(residual)/∂(corners), columns by corner and axis. A triangle's strain depends on the four
  // entries of its own D, which are linear in the corners.
  MatX residual_jacobian(const std::vector<Mat2>& D) const {
    const long corners = static_cast<long>(weight_gradients_.size());
    MatX J(3 * static_cast<long>(D.size()), 2 * corners);
    Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(2 * corners);
    double total = 0;
    for (size_t t = 0; t < D.size(); ++t) {
      const auto of_strain = strain_jacobian(t, D[t]);
      auto own = J.middleRows<3>(3 * static_cast<long>(t));
      for (long c = 0; c < corners; ++c)
        own.middleCols<2>(2 * c).noalias() =
            of_strain.leftCols<2>() * weight_gradients_[c](0, static_cast<long>(t)) +
            of_strain.rightCols<2>() * weight_gradients_[c](1, static_cast<long>(t));
      mean += weight_[t] * own.row(0);
      total += weight_[t];
    }
    mean /= total;
    for (size_t t = 0; t < D.size(); ++t) {
      auto own = J.middleRows<3>(3 * static_cast<long>(t));
      own.row(0) -= mean;
      own *= std::sqrt(weight_[t]);
    }
    return J;
  }

  const std::vector<Mat2>& metric() const { return metric_; }
  const std::vector<double>& area() const { return area_; }

 private:
  // ∂(strain)/∂D, columns D(0, 0), D(1, 0), D(0, 1), D(1, 1); by central differences.
  Eigen::Matrix<double, 3, 4> strain_jacobian(size_t triangle, const Mat2& D) const {
    const auto strain = [&](const Mat2& change) {
      const Mat2 inverse = change.inverse();
      return half_log(inverse.transpose() * metric_[triangle] * inverse);
    };
    const double h = 1e-7 * D.norm();
    Eigen::Matrix<double, 3, 4> slopes;
    for (int k = 0; k < 4; ++k) {
      Mat2 more = D, less = D;
      more(k % 2, k / 2) += h;
      less(k % 2, k / 2) -= h;
      slopes.col(k) = (strain(more) - strain(less)) / (2 * h);
    }
    return slopes;
  }

  std::vector<Mat2> metric_;
  std::vector<double> area_, weight_;               // in the domain; on the surface
  std::vector<Eigen::Matrix2Xd> weight_gradients_;  // gradient of each corner's weight, by triangle
};

Distortion distortion_of(const std::vector<Mat2>& metric, const std::vector<double>& area) {
  Distortion d;
  double sum = 0, domain = 0, scale = 0, least = std::numeric_limits<double>::infinity();
  std::vector<Vec3> strain(metric.size(), Vec3::Zero());
  for (size_t t = 0; t < metric.size(); ++t) {
    const double jacobian = std::sqrt(std::max(0.0, metric[t].determinant()));
    domain += area[t];
    if (!(jacobian > 0)) {  // degenerate to a line or a point on the surface: no area, no weight
      d.max_shear = std::numeric_limits<double>::infinity();
      least = 0;
      continue;
    }
    strain[t] = half_log(metric[t]);
    d.max_shear = std::max(d.max_shear, std::exp(std::sqrt(2.0) * strain[t].tail<2>().norm()));
    least = std::min(least, jacobian);
    sum += area[t] * jacobian;
    scale += area[t] * jacobian * strain[t][0];
  }
  d.min_area = least * domain / sum;
  double squares = 0;
  for (size_t t = 0; t < metric.size(); ++t) {
    strain[t][0] -= scale / sum;
    squares +=
        area[t] * std::sqrt(std::max(0.0, metric[t].determinant())) * strain[t].squaredNorm();
  }
  d.rms = std::sqrt(squares / sum);
  return d;
}

// Scales, rotates and translates polygon `q` to fit polygon `given` (Procrustes).
std::vector<Vec2> fit_similarity(const Eigen::Matrix2Xd& given, const Eigen::Matrix2Xd& q) {
  const auto around = [](const Eigen::Matrix2Xd& p) {
    double sum = 0;
    for (long i = 0; i < p.cols(); ++i) sum += (p.col((i + 1) % p.cols()) - p.col(i)).norm();
    return sum;
  };
  const Vec2 from = q.rowwise().mean(), to = given.rowwise().mean();
  const Mat2 S = (given.colwise() - to) * (q.colwise() - from).transpose();
  const double rotation_angle = std::atan2(S(1, 0) - S(0, 1), S.trace()),
               scale = around(given) / around(q);
  Mat2 R;
  R << std::cos(rotation_angle), -std::sin(rotation_angle), std::sin(rotation_angle),
      std::cos(rotation_angle);
  std::vector<Vec2> moved;
  for (long i = 0; i < q.cols(); ++i) moved.push_back(scale * (R * (q.col(i) - from)) + to);
  return moved;
}

}  // namespace

Distortion distortion(const Surface& surface) {
  const DomainMap domain_map(surface);
  return distortion_of(domain_map.metric(), domain_map.area());
}

LeastDistortedPolygon find_least_distorted_polygon(const Surface& surface,
                                                   const std::vector<Vec2>& polygon) {
  if (polygon.size() < 3)
    throw InputError("found a polygon with " + std::to_string(polygon.size()) +
                     " corners, expected three or more");
  const long n = static_cast<long>(polygon.size());
  DomainMap domain_map(surface);
  domain_map.set_polygon(surface.mesh(), polygon);
  Eigen::Matrix2Xd q(2, n);
  for (long i = 0; i < n; ++i) q.col(i) = polygon[i];
  const Eigen::Matrix2Xd given = q;

  // Levenberg-Marquardt. Rotation, translation and scale of the domain are free: damping controls
  // them.
  std::vector<Mat2> D = domain_map.domain_gradients(q);
  VecX r;
  if (!domain_map.residual(D, r)) return {polygon, distortion(surface), distortion(surface)};
  const double small = 1e-7 * (q.rowwise().maxCoeff() - q.rowwise().minCoeff()).norm();
  double damping = 1e-3;
  for (int step = 0; step < 60 && damping < 1e8; ++step) {
    const MatX J = domain_map.residual_jacobian(D);
    MatX H = J.transpose() * J;
    H.diagonal().array() += damping * H.diagonal().maxCoeff();
    const VecX move = -H.ldlt().solve(J.transpose() * r);
    const Eigen::Matrix2Xd next = q + Eigen::Map<const Eigen::Matrix2Xd>(move.data(), 2, n);
    std::vector<Mat2> changed = domain_map.domain_gradients(next);
    VecX there;
    if (domain_map.residual(changed, there) && there.squaredNorm() < r.squaredNorm()) {
      constexpr double little = 1e-6;  // of the sum of squared strains
      const bool converged =
          move.norm() < small || r.squaredNorm() - there.squaredNorm() < little * r.squaredNorm();
      q = next;
      D = std::move(changed);
      r = there;
      damping = std::max(1e-9, damping / 5);
      if (converged) break;
    } else {
      damping *= 5;
    }
  }

  LeastDistortedPolygon result;
  result.before = distortion_of(domain_map.metric(), domain_map.area());
  std::vector<Mat2> metric;
  std::vector<double> area;
  domain_map.moved(D, metric, area);
  result.expected = distortion_of(metric, area);
  result.polygon = fit_similarity(given, q);
  return result;
}

}  // namespace batten
