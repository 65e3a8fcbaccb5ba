#include "batten/fairing/hct_tables.h"

#include <cmath>

namespace batten {
namespace {

// Points ⅔ ⅙ ⅙ of a third: from them follow all second derivatives, which are linear there.
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
  const Vec2 corner[3] = {{1, 0}, {0, 1}, {0, 0}};  // (L1, L2)
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
