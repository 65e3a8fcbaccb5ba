// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/shell_material.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <string>

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

// The factor R with a R² + b R = 1.
double positive_root(double a, double b) {
  const double root = b * b + 4 * a;
  if (!(root >= 0)) return std::numeric_limits<double>::infinity();
  const double sum = b + std::sqrt(root);
  return sum > 0 ? 2 / sum : std::numeric_limits<double>::infinity();
}

double square(double x) { return x * x; }

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

void require_material(const ShellMaterial& material) {
  const Mat3& Q = material.Q;
  constexpr double rounding = 1e-12;
  if (!Q.allFinite() || (Q - Q.transpose()).norm() > rounding * Q.norm() ||
      Eigen::LLT<Mat3>(Q).info() != Eigen::Success)
    throw InputError("the material stiffness matrix Q is not symmetric and positive definite");
  require_density(material.density);
  if (!material.expansion.allFinite())
    throw InputError("material: found a thermal expansion that is not finite");
  if (!material.strength) return;
  const PlyStrength& s = *material.strength;
  for (const double strength :
       {s.tension_1, s.compression_1, s.tension_2, s.compression_2, s.shear})
    require_positive("a strength", strength);
}

double reserve_factor(FailureCriterion criterion, const PlyStrength& s, const Vec3& stress) {
  const double s1 = stress[0], s2 = stress[1], shear = square(stress[2] / s.shear);
  if (criterion == FailureCriterion::TsaiHill) {
    const double X = s1 < 0 ? s.compression_1 : s.tension_1,
                 Y = s2 < 0 ? s.compression_2 : s.tension_2;
    return positive_root((s1 * s1 - s1 * s2) / square(X) + square(s2 / Y) + shear, 0);
  }
  const double XX = s.tension_1 * s.compression_1, YY = s.tension_2 * s.compression_2;
  return positive_root(
      (s1 * s1 - s1 * s2) / XX + s2 * s2 / YY + shear,
      s1 * (1 / s.tension_1 - 1 / s.compression_1) + s2 * (1 / s.tension_2 - 1 / s.compression_2));
}

}  // namespace batten
