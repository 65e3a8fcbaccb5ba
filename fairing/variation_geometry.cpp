#include "batten/fairing/variation_geometry.h"

#include <Eigen/Geometry>
#include <cmath>

namespace batten {
namespace {

const Vec2 kCorner[3] = {{1, 0}, {0, 1}, {0, 0}};  // V_i in (L1, L2)

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace

Mat12 reference_map(const Surface& surface, int t) {
  return C1Triangle(TriangleElement::HCT, surface.mesh().shape(t)).pull_back_matrix();
}

Vec2 edge_direction(int i) { return kCorner[(i + 2) % 3] - kCorner[(i + 1) % 3]; }
Vec2 spoke_direction(int i) { return Vec2(1.0 / 3, 1.0 / 3) - kCorner[i]; }

Vec3 mixed_derivative_weights(const Mat2& M, int a, int b) {
  return {M(a, 0) * M(b, 0), M(a, 0) * M(b, 1) + M(a, 1) * M(b, 0), M(a, 1) * M(b, 1)};
}
Vec3 second_derivative_weights(const Vec2& d) {
  return {d.x() * d.x(), 2 * d.x() * d.y(), d.y() * d.y()};
}

CurvatureJump curvature_jump(const LocalSlopes& X, const Vec3& jump, const Vec2& direction,
                             const Vec2& across, double thickness, double jumps) {
  CurvatureJump j;
  const Vec3 area = X.col(0).cross(X.col(1));
  const double J = area.norm(), length = (X * direction).norm();
  const double width = J * std::abs(cross(direction, across)) / length;  // of one unit of `across`
  const double altitude = J * thickness / length;
  j.n = area / J;
  j.weight = std::sqrt(0.5 * jumps * length / altitude) / (width * width);
  j.value = j.weight * j.n.dot(jump);
  const Mat2 g = X.transpose() * X;
  j.slopes = -(g.inverse() * (X.transpose() * jump));
  return j;
}

EdgeSecondForm edge_second_form(const LocalJet& jet, const Vec2& direction) {
  EdgeSecondForm f;
  const LocalSlopes X = jet.leftCols<2>();
  const Vec2 beside(-direction.y(), direction.x());
  const Vec3 along = X * direction, other = X * beside;
  f.Y1 = along.normalized();
  const double b = other.dot(f.Y1);
  const Vec3 rest = other - b * f.Y1;
  f.Y2 = rest.normalized();
  f.M.row(0) = direction.transpose() / along.norm();
  f.M.row(1) = (beside.transpose() - b * f.M.row(0)) / rest.norm();
  f.n = f.Y1.cross(f.Y2);
  const auto second = [&](int a, int c) -> Vec3 {
    return jet.rightCols<3>() * mixed_derivative_weights(f.M, a, c);
  };
  const Vec3 Y12 = second(0, 1), Y22 = second(1, 1);
  f.along = f.n.dot(second(0, 0));
  f.twist = f.n.dot(Y12);
  f.across = f.n.dot(Y22);
  f.gamma12 = {f.Y1.dot(Y12), f.Y2.dot(Y12)};
  f.gamma22 = {f.Y1.dot(Y22), f.Y2.dot(Y22)};
  return f;
}

LocalJet local_jet(const TriangleDofs& q, const HctTables::EdgePoint& point) {
  LocalJet jet;
  jet.leftCols<2>() = q.transpose().lazyProduct(point.slopes);
  jet.rightCols<3>() = q.transpose().lazyProduct(point.second);
  return jet;
}

}  // namespace batten
