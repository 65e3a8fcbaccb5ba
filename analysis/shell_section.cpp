// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/shell_section.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "batten/core/errors.h"

namespace batten {
namespace {

void require_positive(const char* what, double value) {
  if (!(value > 0) || !std::isfinite(value))
    throw InputError(std::string("material: found ") + what + " = " + format_number(value) +
                     ", expected a number above 0");
}

void require_density(double density) {
  if (!(density >= 0) || !std::isfinite(density))
    throw InputError("material: found density = " + format_number(density) +
                     ", expected 0 or more");
}

}  // namespace

ShellMaterial ShellMaterial::isotropic(double E, double nu, double density) {
  require_positive("E", E);
  require_density(density);
  if (!(nu > -1 && nu < 0.5))
    throw InputError("material: found nu = " + format_number(nu) +
                     ", expected a number between -1 and 0.5");
  Mat3 Q;
  Q << 1, nu, 0, nu, 1, 0, 0, 0, 0.5 * (1 - nu);
  return {E / (1 - nu * nu) * Q, density};
}

ShellMaterial ShellMaterial::orthotropic(double E1, double E2, double nu12, double G12,
                                         double density) {
  require_positive("E1", E1);
  require_positive("E2", E2);
  require_positive("G12", G12);
  require_density(density);
  if (!(nu12 * nu12 * E2 < E1))
    throw InputError("material: found nu12 = " + format_number(nu12) +
                     ", expected nu12² below E1/E2 = " + format_number(E1 / E2));
  const double share = 1 - nu12 * nu12 * E2 / E1;
  Mat3 Q;
  Q << E1, nu12 * E2, 0, nu12 * E2, E2, 0, 0, 0, G12 * share;
  return {Q / share, density};
}

void require_section(const ShellSection& section) {
  const Mat3& Q = section.material.Q;
  const double least = section.thickness + std::min(0.0, section.thickness_offset.minCoeff());
  if (!(section.thickness > 0 && least > 0) || !std::isfinite(section.thickness) ||
      !section.thickness_offset.allFinite())
    throw InputError("shell section: found thickness = " +
                     format_number(section.thickness > 0 ? least : section.thickness) +
                     ", expected a length above 0");
  if (!section.along.allFinite()) throw InputError("the material direction is not finite");
  constexpr double rounding = 1e-12;
  if (!Q.allFinite() || (Q - Q.transpose()).norm() > rounding * Q.norm() ||
      Eigen::LLT<Mat3>(Q).info() != Eigen::Success)
    throw InputError("the material stiffness matrix Q is not symmetric and positive definite");
}

}  // namespace batten
