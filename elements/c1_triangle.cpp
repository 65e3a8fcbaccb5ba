// SPDX-License-Identifier: MPL-2.0
#include "batten/elements/c1_triangle.h"

#include "batten/core/errors.h"
#include "batten/elements/bernstein_cubics.h"
#include "batten/elements/reference_triangle.h"

namespace batten {

Mat12 C1Triangle::pull_back_matrix() const {
  const DofTransformCoefficients numbers(shape_);
  Mat12 P = Mat12::Zero();
  for (int i = 0; i < 3; ++i) {
    const double* g = numbers.gradient[i];
    P(3 * i, 3 * i) = 1;
    P.block<2, 2>(3 * i + 1, 3 * i + 1) << g[0], g[1], g[2], g[3];
  }
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    P(9 + i, 9 + i) = numbers.altitude[i];
    P.row(9 + i) += numbers.slant[i] * (1.5 * (P.row(3 * k) - P.row(3 * j)) -
                                        0.25 * (P.row(3 * j + 1) - P.row(3 * k + 2)));
  }
  return P;
}

Tabulation C1Triangle::reference_at(const Vec3& L) const {
  const ReferenceTabulation reference = reference_functions(kind_, L);
  const DerivativeMap map(shape_);
  Tabulation local;
  local.col(kW) = reference.col(0);
  local.middleCols<2>(kU) = reference.middleCols<2>(1) * map.first.transpose();
  local.middleCols<3>(kUU) = reference.middleCols<3>(3) * map.second.transpose();
  return local;
}

// lazyProduct(): Eigen's general product packs its operands first, which takes longer than these
// small products.
Tabulation C1Triangle::evaluate(const Vec3& L) const {
  return pull_back_matrix().transpose().lazyProduct(reference_at(L));
}

Eigen::Matrix<double, 12, 3> C1Triangle::pull_back(const Eigen::Matrix<double, 12, 3>& q) const {
  const DofTransformCoefficients numbers(shape_);
  Eigen::Matrix<double, 12, 3> r;
  for (int i = 0; i < 3; ++i) {
    const double* g = numbers.gradient[i];
    r.row(3 * i) = q.row(3 * i);
    r.row(3 * i + 1) = g[0] * q.row(3 * i + 1) + g[1] * q.row(3 * i + 2);
    r.row(3 * i + 2) = g[2] * q.row(3 * i + 1) + g[3] * q.row(3 * i + 2);
  }
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    r.row(9 + i) = numbers.altitude[i] * q.row(9 + i) +
                   numbers.slant[i] * (1.5 * (r.row(3 * k) - r.row(3 * j)) -
                                       0.25 * (r.row(3 * j + 1) - r.row(3 * k + 2)));
  }
  return r;
}

Vec3 C1Triangle::position(const Vec3& L, const Eigen::Matrix<double, 12, 3>& q) const {
  const Eigen::Matrix<double, 12, 3> reference = pull_back(q);
  if (kind_ != TriangleElement::HCT)
    return reference.transpose().lazyProduct(reference_functions(kind_, L).col(0));
  const HctSubtriangle at(L);
  const Vec12 functions = hct_ordinates(at.sub).transpose().lazyProduct(bernstein_cubics(at.local));
  return reference.transpose().lazyProduct(functions);
}

Eigen::Matrix<double, 3, kDerivatives> C1Triangle::jet(
    const Vec3& L, const Eigen::Matrix<double, 12, 3>& q) const {
  return pull_back(q).transpose().lazyProduct(reference_at(L));
}

Mat12 C1Triangle::stiffness(const SurfaceStiffness& material) const {
  Mat12 K;
  constant_stiffness(reference_tensors(kind_), shape_, material, K.data());
  return K;
}

Mat12 C1Triangle::mass() const {
  const Mat12 P = pull_back_matrix();
  return shape_.area * P.transpose() * reference_tensors(kind_).mass * P;
}

Vec12 C1Triangle::load() const {
  return shape_.area * pull_back_matrix().transpose() * reference_tensors(kind_).load;
}

const TriangleRule& C1Triangle::default_quadrature(TriangleElement kind) {
  static const TriangleRule hct = split_triangle_rule(4);
  static const TriangleRule z12 = six_duffy_rule(5);
  return kind == TriangleElement::HCT ? hct : z12;
}

Eigen::Matrix<double, 10, 3> C1Triangle::bezier(int sub,
                                                const Eigen::Matrix<double, 12, 3>& q) const {
  if (kind_ != TriangleElement::HCT)
    throw InputError("Bezier ordinates exist for HCT triangles only: Z12 triangles are rational");
  return hct_ordinates(sub) * pull_back(q);
}

}  // namespace batten
