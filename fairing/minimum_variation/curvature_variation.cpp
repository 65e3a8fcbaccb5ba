// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/minimum_variation/curvature_variation.h"

#include <Eigen/Geometry>
#include <cmath>

namespace batten {
namespace {

using Mat9 = Eigen::Matrix<double, 9, 9>;
using Weights47 = Eigen::Matrix<double, kCurvatureVariationResiduals - 1, 7>;

// Column numbers of the derivatives by their indices, each 0 or 1.
constexpr int first(int a) { return a; }
constexpr int second(int a, int b) { return 2 + a + b; }
constexpr int third(int a, int b, int c) { return 5 + a + b + c; }

// Transforms the jet to other directions: Y = X T with Y_a = Σ_i M_ai X_i, and likewise for two and
// three indices.
Mat9 contraction(const Mat2& M) {
  Mat9 T = Mat9::Zero();
  for (int a = 0; a < 2; ++a)
    for (int i = 0; i < 2; ++i) T(first(i), first(a)) = M(a, i);
  for (int a = 0; a < 2; ++a)
    for (int b = a; b < 2; ++b)
      for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 2; ++j) {
          T(second(i, j), second(a, b)) += M(a, i) * M(b, j);
          if (a == 0)
            for (int k = 0; k < 2; ++k)
              T(third(i, j, k), third(a, b, b)) += M(a, i) * M(b, j) * M(b, k);
        }
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      for (int k = 0; k < 2; ++k) {
        T(third(i, j, k), third(0, 0, 1)) += M(0, i) * M(0, j) * M(1, k);
        T(third(i, j, k), third(1, 1, 1)) += M(1, i) * M(1, j) * M(1, k);
      }
  return T;
}

Mat2 metric(const Jet3& jet) {
  const auto X = jet.leftCols<2>();
  return X.transpose() * X;
}

// Inverse of the symmetric square root of a symmetric positive definite 2×2 matrix.
Mat2 inverse_root(const Mat2& g) {
  const double root = std::sqrt(g.determinant());
  return ((g + root * Mat2::Identity()) / std::sqrt(g.trace() + 2 * root)).inverse();
}

// II, Γ and C in an orthonormal frame.
struct Local {
  Vec3 n;
  double II[2][2];
  double gamma[2][2][2];  // [l][a][b]
  double C[2][2][2];

  explicit Local(const Jet3& Y) : n(Y.col(0).cross(Y.col(1)).normalized()) {
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b < 2; ++b) {
        II[a][b] = n.dot(Y.col(second(a, b)));
        for (int l = 0; l < 2; ++l) gamma[l][a][b] = Y.col(l).dot(Y.col(second(a, b)));
      }
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b < 2; ++b)
        for (int c = 0; c < 2; ++c) {
          C[a][b][c] = n.dot(Y.col(third(a, b, c)));
          for (int l = 0; l < 2; ++l)
            C[a][b][c] -=
                gamma[l][a][b] * II[l][c] + gamma[l][a][c] * II[l][b] + gamma[l][b][c] * II[l][a];
        }
  }
};

// Matrix from the seven components [C; II] to all residuals but the last.
Weights47 residual_weights(const CurvatureVariationWeights& w) {
  const double s = w.principal, rest = std::sqrt(std::max(0.0, 1 - s * s));
  const double form = std::sqrt(w.second_form);
  Weights47 R = Weights47::Zero();
  R.row(0) << 0.75 + 0.25 * s, 0, 0.75 - 0.75 * s, 0, 0, 0, 0;
  R.row(1) << 0, 0.75 - 0.75 * s, 0, 0.75 + 0.25 * s, 0, 0, 0;
  R.row(2) << 0.25 * rest, 0, -0.75 * rest, 0, 0, 0, 0;
  R.row(3) << 0, 0.75 * rest, 0, -0.25 * rest, 0, 0, 0;
  R(4, 4) = R(6, 6) = form;
  R(5, 5) = std::sqrt(2.0) * form;
  return R;
}

using Slopes = Eigen::Matrix<double, 3, 9>;  // derivative of one number by each column of Y

// Adds factor · δg_lm = factor · (δY_l·Y_m + Y_l·δY_m).
void add_metric(const Jet3& Y, int l, int m, double factor, Slopes& to) {
  to.col(l) += factor * Y.col(m);
  to.col(m) += factor * Y.col(l);
}

Slopes second_form_slopes(const Jet3& Y, const Local& at, int a, int b) {
  Slopes to = Slopes::Zero();
  to.col(second(a, b)) += at.n;
  for (int l = 0; l < 2; ++l) {
    to.col(l) -= at.gamma[l][a][b] * at.n;
    add_metric(Y, a, l, -0.5 * at.II[l][b], to);
    add_metric(Y, b, l, -0.5 * at.II[l][a], to);
  }
  return to;
}

// Subtracts the derivatives of Γ^l_xy II_lz, summed over l.
void subtract_product(const Jet3& Y, const Local& at, int x, int y, int z, Slopes& to) {
  for (int l = 0; l < 2; ++l) {
    const double II = at.II[l][z], gamma = at.gamma[l][x][y];
    to.col(l) -= II * Y.col(second(x, y));
    to.col(second(x, y)) -= II * Y.col(l);
    to.col(second(l, z)) -= gamma * at.n;
    for (int m = 0; m < 2; ++m) {
      add_metric(Y, l, m, II * at.gamma[m][x][y], to);
      to.col(m) += gamma * at.gamma[m][l][z] * at.n;
    }
  }
}

Slopes change_slopes(const Jet3& Y, const Local& at, int a, int b, int c) {
  Slopes to = Slopes::Zero();
  to.col(third(a, b, c)) += at.n;
  for (int l = 0; l < 2; ++l) to.col(l) -= Y.col(l).dot(Y.col(third(a, b, c))) * at.n;
  subtract_product(Y, at, a, b, c, to);
  subtract_product(Y, at, a, c, b, to);
  subtract_product(Y, at, b, c, a, to);
  for (int m = 0; m < 2; ++m) {
    add_metric(Y, a, m, -0.5 * at.C[m][b][c], to);
    add_metric(Y, b, m, -0.5 * at.C[a][m][c], to);
    add_metric(Y, c, m, -0.5 * at.C[a][b][m], to);
  }
  return to;
}

}  // namespace

Mat2 principal_frame(const Jet3& jet) {
  const Vec3 u = jet.col(0), v = jet.col(1);
  const double a = u.norm(), b = v.dot(u) / a, c = u.cross(v).norm() / a;
  Mat2 M;  // frame with Y_1 along X_u
  M << 1 / a, 0, -b / (a * c), 1 / c;
  const Local at(jet.lazyProduct(contraction(M)));
  const double angle = 0.5 * std::atan2(2 * at.II[0][1], at.II[0][0] - at.II[1][1]);
  Mat2 turn;
  turn << std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle);
  return turn * M;
}

CurvatureTensors curvature_tensors(const Jet3& jet, const Mat2& frame) {
  const Mat2 g = metric(jet);
  const Mat2 M = inverse_root(frame * g * frame.transpose()) * frame;
  const Local at(jet.lazyProduct(contraction(M)));
  CurvatureTensors forms;
  forms.II = {at.II[0][0], at.II[0][1], at.II[1][1]};
  forms.C = {at.C[0][0][0], at.C[0][0][1], at.C[0][1][1], at.C[1][1][1]};
  forms.jacobian = std::sqrt(g.determinant());
  return forms;
}

CurvatureVariationVector curvature_variation_residuals(const CurvatureTensors& forms,
                                                       const CurvatureVariationWeights& weights) {
  Eigen::Matrix<double, 7, 1> all;
  all << forms.C, forms.II;
  CurvatureVariationVector r;
  r.head<7>() = residual_weights(weights).lazyProduct(all);
  r[7] = std::sqrt(weights.gauss) * (forms.II[0] * forms.II[2] - forms.II[1] * forms.II[1]);
  return std::sqrt(forms.jacobian) * r;
}

CurvatureVariationJacobian curvature_variation_jacobian(const Jet3& jet, const Mat2& frame,
                                                        const CurvatureVariationWeights& weights,
                                                        CurvatureVariationVector& residuals) {
  const Mat9 T = contraction(frame);
  const Jet3 Y = jet.lazyProduct(T);
  const Local at(Y);
  Eigen::Matrix<double, 7, 27> slopes;
  const auto put = [&](int row, const Slopes& s) {
    const Eigen::Matrix<double, 9, 3> by_jet = T.lazyProduct(s.transpose());
    slopes.row(row) = by_jet.reshaped().transpose();
  };
  for (int k = 0; k < 4; ++k) put(k, change_slopes(Y, at, k > 2, k > 1, k > 0));
  for (int k = 0; k < 3; ++k) put(4 + k, second_form_slopes(Y, at, k > 1, k > 0));

  const CurvatureTensors forms{{at.II[0][0], at.II[0][1], at.II[1][1]},
                               {at.C[0][0][0], at.C[0][0][1], at.C[0][1][1], at.C[1][1][1]},
                               std::sqrt(metric(jet).determinant())};
  residuals = curvature_variation_residuals(forms, weights);
  const double root = std::sqrt(forms.jacobian);
  CurvatureVariationJacobian all;
  all.topRows<7>() = (root * residual_weights(weights)).lazyProduct(slopes);
  all.row(7) =
      root * std::sqrt(weights.gauss) *
      (forms.II[2] * slopes.row(4) + forms.II[0] * slopes.row(6) - 2 * forms.II[1] * slopes.row(5));
  // Derivative of √J: half of ½ tr δg.
  Slopes area = Slopes::Zero();
  for (int a = 0; a < 2; ++a) area.col(a) = 0.5 * Y.col(a);
  const Eigen::Matrix<double, 9, 3> area_by_jet = T.lazyProduct(area.transpose());
  all += residuals.lazyProduct(area_by_jet.reshaped().transpose());
  return all;
}

}  // namespace batten
