// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/minimum_variation/variation_geometry.h"

#include <Eigen/Geometry>
#include <cmath>

namespace batten {
namespace {

const Vec2 kCorner[3] = {{1, 0}, {0, 1}, {0, 0}};  // vertices V_i in (L1, L2)

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
  // Width in space of one unit of `across`.
  const double width = J * std::abs(cross(direction, across)) / length;
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

namespace {

// Barycentric coordinates of a point in a third. At points (⅔, ⅙, ⅙), values determine all second
// derivatives, which are linear there.
Vec3 in_triangle(int third, const Vec3& mu) {
  Vec3 L = Vec3::Constant(mu[2] / 3);
  L[(third + 1) % 3] += mu[0];
  L[(third + 2) % 3] += mu[1];
  return L;
}
Vec3 in_third(int third, const Vec3& L) {
  const double centre = 3 * L[third];
  return {L[(third + 1) % 3] - L[third], L[(third + 2) % 3] - L[third], centre};
}
Vec3 point(int m) {
  Vec3 mu = Vec3::Constant(1.0 / 6);
  mu[m] = 2.0 / 3;
  return mu;
}

HctTables::Slopes slopes_at(const Vec3& L) {
  return reference_functions(TriangleElement::HCT, L).middleCols<2>(1);
}

HctTables::Second second_at(const std::array<Table3, 9>& inside, int third, const Vec3& L) {
  const Vec3 mu = in_third(third, L);
  HctTables::Second sum = HctTables::Second::Zero();
  for (int m = 0; m < 3; ++m) sum += (2 * mu[m] - 1.0 / 3) * inside[3 * third + m].middleCols<3>(2);
  return sum;
}

Vec3 on_edge(int i, double s) {
  Vec3 L = Vec3::Zero();
  L[(i + 1) % 3] = 1 - s;
  L[(i + 2) % 3] = s;
  return L;
}

}  // namespace

const std::array<double, 2> HctTables::gauss = {0.5 - 0.5 / std::sqrt(3.0),
                                                0.5 + 0.5 / std::sqrt(3.0)};
const std::array<double, 3> HctTables::gauss3 = {0.5 - 0.5 * std::sqrt(0.6), 0.5,
                                                 0.5 + 0.5 * std::sqrt(0.6)};
const std::array<double, 3> HctTables::weight3 = {5.0 / 18, 8.0 / 18, 5.0 / 18};

HctTables::HctTables() {
  const Vec2 corner[3] = {{1, 0}, {0, 1}, {0, 0}};  // vertices in (L1, L2)
  const Vec2 centre(1.0 / 3, 1.0 / 3);
  for (int s = 0; s < 3; ++s) {
    const TriangleShape third(corner[(s + 1) % 3], corner[(s + 2) % 3], centre);
    Eigen::Matrix<double, 12, 4> cubic = Eigen::Matrix<double, 12, 4>::Zero();
    for (int m = 0; m < 3; ++m) {
      Table3& table = inside[3 * s + m];
      table.leftCols<5>() =
          reference_functions(TriangleElement::HCT, in_triangle(s, point(m))).rightCols<5>();
      const double by_1 = third.b[m] / third.area, by_2 = third.c[m] / third.area;
      cubic.col(0) += by_1 * table.col(2);
      cubic.col(1) += by_2 * table.col(2);
      cubic.col(2) += by_1 * table.col(4);
      cubic.col(3) += by_2 * table.col(4);
    }
    for (int m = 0; m < 3; ++m) inside[3 * s + m].rightCols<4>() = cubic;
  }
  for (int i = 0; i < 3; ++i) {
    for (size_t k = 0; k < 2; ++k) {
      Vec3 L = Vec3::Constant(gauss[k] / 3);
      L[i] += 1 - gauss[k];
      spokes[i][k] = {slopes_at(L),
                      second_at(inside, (i + 1) % 3, L) - second_at(inside, (i + 2) % 3, L)};
      const Vec3 at = on_edge(i, gauss[k]);
      edges[i][k] = {slopes_at(at), second_at(inside, i, at)};
    }
    for (size_t k = 0; k < 3; ++k) {
      const Vec3 at = on_edge(i, gauss3[k]);
      edges3[i][k] = {slopes_at(at), second_at(inside, i, at)};
    }
  }
}

const HctTables& HctTables::get() {
  static const HctTables tables;
  return tables;
}

}  // namespace batten
