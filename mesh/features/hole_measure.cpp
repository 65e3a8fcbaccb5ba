#include "batten/mesh/features/hole_measure.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "batten/core/dense.h"
#include "batten/core/errors.h"
#include "batten/core/isize.h"

namespace batten {
namespace {

struct Circle {
  Vec2 centre = Vec2::Zero();
  double radius = 0;
};

using PlanePoints = Eigen::Matrix<double, Eigen::Dynamic, 2>;

// |x|² = 2 m·x + c with R² = c + |m|².
Circle algebraic_circle(const PlanePoints& x) {
  MatX A(x.rows(), 3);
  A << 2 * x, VecX::Ones(x.rows());
  const VecX squares = x.rowwise().squaredNorm();
  const Vec3 s = least_squares(A, squares);
  return {s.head<2>(), std::sqrt(std::max(0.0, s[2] + s.head<2>().squaredNorm()))};
}

VecX radii(const PlanePoints& x, const Vec2& centre) {
  return (x.rowwise() - centre.transpose()).rowwise().norm();
}

// Least squares in the distances, by Gauss-Newton; steps that do not help are halved.
Circle geometric_circle(const PlanePoints& x, Circle circle) {
  const auto cost = [&](const Circle& c) {
    return (radii(x, c.centre).array() - c.radius).square().sum();
  };
  double best = cost(circle);
  for (int iteration = 0; iteration < 50; ++iteration) {
    const VecX r = radii(x, circle.centre);
    if (!(r.minCoeff() > 0)) break;
    MatX A(x.rows(), 3);
    A.leftCols<2>() = (x.rowwise() - circle.centre.transpose()).array().colwise() / r.array();
    A.col(2).setOnes();
    const Vec3 step = least_squares(A, (r.array() - circle.radius).matrix());
    double length = 1;
    Circle next;
    double next_cost;
    do {
      next = {circle.centre + length * step.head<2>(), circle.radius + length * step[2]};
      next_cost = cost(next);
      length /= 2;
    } while (!(next_cost <= best) && length > 1e-3);
    if (!(next_cost < best)) break;
    circle = next;
    best = next_cost;
  }
  return circle;
}

}  // namespace

HoleMeasure measure_hole(const Points& points, const std::vector<int>& loop,
                         double circular_tolerance) {
  const int n = isize(loop);
  if (n < 3)
    throw InputError("a hole has " + std::to_string(n) + " vertices, expected three or more");
  Points p(n, 3);
  for (int i = 0; i < n; ++i) {
    if (loop[i] < 0 || loop[i] >= points.rows())
      throw InputError("vertex " + std::to_string(loop[i]) +
                       " of a hole does not exist: there are " + std::to_string(points.rows()));
    p.row(i) = points.row(loop[i]);
  }
  if (!p.allFinite()) throw InputError("a hole has a coordinate that is not finite");

  const Eigen::RowVector3d centroid = p.colwise().mean();
  p.rowwise() -= centroid;
  HoleMeasure hole;
  hole.perimeter = 0;
  Vec3 twice_area_vector = Vec3::Zero();
  for (int i = 0; i < n; ++i) {
    const Vec3 a = p.row(i), b = p.row((i + 1) % n);
    hole.perimeter += (b - a).norm();
    twice_area_vector += a.cross(b);
  }
  const double scale = p.cwiseAbs().maxCoeff();
  const Mat3 frame = thin_svd(p / (scale > 0 ? scale : 1)).V;
  hole.axis = frame.col(2).dot(twice_area_vector) > 0 ? Vec3(-frame.col(2)) : Vec3(frame.col(2));
  hole.flatness = (p * hole.axis).cwiseAbs().maxCoeff();

  const PlanePoints x = p * frame.leftCols<2>() / (scale > 0 ? scale : 1);
  const Circle circle = geometric_circle(x, algebraic_circle(x));
  hole.centre = centroid.transpose() + frame.leftCols<2>() * (scale * circle.centre);
  hole.radius = scale * circle.radius;
  hole.roundness = scale * (radii(x, circle.centre).array() - circle.radius).abs().maxCoeff();
  const double enclosed = 0.5 * std::abs(hole.axis.dot(twice_area_vector));
  hole.equivalent_radius = std::sqrt(enclosed / std::numbers::pi);
  hole.circular = n >= 5 && enclosed >= 0.5 * std::numbers::pi * hole.radius * hole.radius &&
                  hole.radius > 0 && hole.roundness <= circular_tolerance * hole.radius;
  return hole;
}

}  // namespace batten
