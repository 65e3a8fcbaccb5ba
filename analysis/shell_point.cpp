#include "batten/analysis/shell_point.h"

#include <Eigen/LU>

#include "batten/core/errors.h"

namespace batten {

ShellPoint::ShellPoint(const SurfaceJet& jet, const Vec3& along) {
  const Vec3 area = jet.area_vector();
  jacobian_ = area.norm();
  constexpr double singular = 1e-12;
  if (!(jacobian_ > singular * jet.x_u.norm() * jet.x_v.norm()))
    throw InputError("the surface is singular at (" + format_number(jet.x.x()) + ", " +
                     format_number(jet.x.y()) + ", " + format_number(jet.x.z()) +
                     "): a shell needs a normal everywhere");
  n_ = area / jacobian_;
  constexpr double steep = 1e-6;
  const Vec3 projected = along - along.dot(n_) * n_;
  e1_ = (projected.norm() > steep * along.norm() ? projected : jet.x_u).normalized();
  e2_ = n_.cross(e1_);

  // Contravariant base vectors: a^u = (x_v × n)/J, a^v = (n × x_u)/J.
  const Vec3 dual_u = jet.x_v.cross(n_) / jacobian_, dual_v = n_.cross(jet.x_u) / jacobian_;
  gradient_ << e1_.dot(dual_u), e1_.dot(dual_v), e2_.dot(dual_u), e2_.dot(dual_v);
  christoffel_ << jet.x_uu.dot(dual_u), jet.x_uu.dot(dual_v), jet.x_uv.dot(dual_u),
      jet.x_uv.dot(dual_v), jet.x_vv.dot(dual_u), jet.x_vv.dot(dual_v);
  const auto& r = gradient_;
  voigt_ << r(0, 0) * r(0, 0), 2 * r(0, 0) * r(0, 1), r(0, 1) * r(0, 1),  //
      r(1, 0) * r(1, 0), 2 * r(1, 0) * r(1, 1), r(1, 1) * r(1, 1),        //
      2 * r(0, 0) * r(1, 0), 2 * (r(0, 0) * r(1, 1) + r(0, 1) * r(1, 0)), 2 * r(0, 1) * r(1, 1);
}

Eigen::Matrix<double, 3, 12> ShellPoint::bending_matrix(const Tabulation& N) const {
  Eigen::Matrix<double, 3, 12> second;
  for (int k = 0; k < 3; ++k)
    second.row(k) =
        (N.col(kUU + k) - christoffel_(k, 0) * N.col(kU) - christoffel_(k, 1) * N.col(kV))
            .transpose();
  return voigt_ * second;
}

ShellStrain ShellPoint::strain(const DisplacementJet& U) const {
  const Vec3 U1 = along_axes(0, U.col(kU), U.col(kV)), U2 = along_axes(1, U.col(kU), U.col(kV));
  Vec3 second;
  for (int k = 0; k < 3; ++k)
    second[k] =
        -n_.dot(U.col(kUU + k) - christoffel_(k, 0) * U.col(kU) - christoffel_(k, 1) * U.col(kV));
  return {{e1_.dot(U1), e2_.dot(U2), e1_.dot(U2) + e2_.dot(U1)}, voigt_ * second};
}

}  // namespace batten
