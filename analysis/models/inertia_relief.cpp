// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/inertia_relief.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "batten/analysis/models/shell_loads.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

constexpr int kRigid = 6;

// The dofs of the three translations, and of the three rotations about a centre.
std::vector<Points> rigid_body_displacements(const ModelLayout& model, const Points& shape) {
  const VecX positions = model.position_dofs();
  const Vec3 c = centre(model, shape);
  std::vector<Points> R;
  for (int k = 0; k < kRigid; ++k) {
    const Vec3 axis = Vec3::Unit(k % 3);
    Points r(shape.rows(), 3);
    for (long m = 0; m < shape.rows(); ++m)
      r.row(m) =
          k < 3 ? Vec3(positions[m] * axis) : axis.cross(Vec3(shape.row(m)) - positions[m] * c);
    R.push_back(std::move(r));
  }
  return R;
}

}  // namespace

InertiaRelief::InertiaRelief(const ModelLayout& model, const Points& shape, const SparseMatrix& M)
    : R_(rigid_body_displacements(model, shape)) {
  Eigen::Matrix<double, kRigid, kRigid> mass;
  for (const Points& r : R_) MR_.push_back(M.selfadjointView<Eigen::Lower>() * r);
  for (int i = 0; i < kRigid; ++i)
    for (int j = 0; j < kRigid; ++j) mass(i, j) = R_[i].cwiseProduct(MR_[j]).sum();
  const Eigen::FullPivLU<Eigen::Matrix<double, kRigid, kRigid>> factor(mass);
  if (!(mass(0, 0) > 0) || !factor.isInvertible())
    throw InputError("inertia relief needs a density");
  inverse_mass_ = factor.inverse();
}

VecX InertiaRelief::moments(const Points& F) const {
  VecX result(kRigid);
  for (int k = 0; k < kRigid; ++k) result[k] = R_[k].cwiseProduct(F).sum();
  return result;
}

Points InertiaRelief::balanced(const Points& F) const {
  const VecX a = inverse_mass_ * moments(F);
  Points result = F;
  for (int k = 0; k < kRigid; ++k) result -= a[k] * MR_[k];
  return result;
}

Points InertiaRelief::without_rigid_motion(const Points& q) const {
  VecX momentum(kRigid);
  for (int k = 0; k < kRigid; ++k) momentum[k] = MR_[k].cwiseProduct(q).sum();
  const VecX a = inverse_mass_ * momentum;
  Points result = q;
  for (int k = 0; k < kRigid; ++k) result -= a[k] * R_[k];
  return result;
}

}  // namespace batten
