// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/theory_limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/parallel.h"

namespace batten {
namespace {

/// Membrane energy of the quadratic strains of a displacement, and the load with which they act on
/// linear displacements.
struct QuadraticStrains {
  double energy = 0;
  Points load;
};

QuadraticStrains quadratic_strains(const ShellAssembler& shell, const Points& q) {
  struct OfTriangle {
    double energy = 0;
    ShellTriangle::Dofs load = ShellTriangle::Dofs::Zero();
  };
  const Surface& surface = shell.surface();
  std::vector<OfTriangle> parts(static_cast<size_t>(surface.mesh().triangle_count()));
  parallel_for_each<64>(isize(parts), [&](int t) {
    OfTriangle& part = parts[static_cast<size_t>(t)];
    std::optional<ShellTriangle::Dofs> reference;
    std::optional<Mat12> pull_back;
    shell.for_each_quadrature_point(
        t, [&](const ShellTriangle& triangle, const ReferenceTabulation& functions,
               const ShellPoint& at, const Vec3& L, double area) {
          if (!reference) {
            reference = triangle.reference(shell.dofs_on(q, t));
            pull_back = triangle.pull_back_matrix();
          }
          const DisplacementJet U = triangle.jet(*reference, functions);
          const Vec3 U1 = at.along_axes(0, U.col(kU), U.col(kV)),
                     U2 = at.along_axes(1, U.col(kU), U.col(kV));
          ShellStrain strain;
          strain.membrane = {0.5 * U1.squaredNorm(), 0.5 * U2.squaredNorm(), U1.dot(U2)};
          const auto resultants = shell.resultants(t, L, strain);
          part.energy += 0.5 * area * strain.membrane.dot(resultants.forces);
          part.load -= area * nodal_forces(triangle.functions(*pull_back, functions), at,
                                           resultants.forces, resultants.moments);
        });
  });
  QuadraticStrains sum{0, Points::Zero(q.rows(), 3)};
  for (int t = 0; t < isize(parts); ++t) {
    sum.energy += parts[static_cast<size_t>(t)].energy;
    const auto dofs = surface.dof_map().triangle(surface.mesh(), t);
    for (int a = 0; a < isize(dofs); ++a)
      sum.load.row(dofs[static_cast<size_t>(a)]) += parts[static_cast<size_t>(t)].load.row(a);
  }
  return sum;
}

/// Transverse shear stiffness per length.
double shear_stiffness(const ShellSection& section, double thickness) {
  constexpr double correction = 5.0 / 6;
  double compliance = 0;
  for (int k = 0; k < section.ply_count(); ++k)
    compliance += (section.ply(k).top - section.ply(k).bottom) / section.ply(k).material.Q(2, 2);
  return correction * thickness / compliance;
}

/// Shear forces at the centroid of a triangle, from the gradient of the recovered moments.
Vec3 shear_forces(const ShellAssembler& shell, const ShellStresses& stresses, int t) {
  constexpr double step = 0.25;
  const Location centre{t, Vec3::Constant(1.0 / 3)};
  const Vec3 x = shell.surface().position(centre), n = shell.surface().jet(centre).normal();
  const Mat3 moments = stresses.at(centre).moments;
  std::array<Vec3, 2> arms;
  std::array<Mat3, 2> changes;
  for (int i = 0; i < 2; ++i) {
    const Location near{t, centre.L + step * (Vec3::Unit(i) - Vec3::Unit(2))};
    const auto k = static_cast<size_t>(i);
    arms[k] = shell.surface().position(near) - x;
    arms[k] -= arms[k].dot(n) * n;
    changes[k] = stresses.at(near).moments - moments;
  }
  // The vectors that are dual to the arms.
  const Vec3 area = arms[0].cross(arms[1]);
  const Vec3 dual0 = arms[1].cross(area) / area.squaredNorm(),
             dual1 = area.cross(arms[0]) / area.squaredNorm();
  const Vec3 divergence = changes[0] * dual0 + changes[1] * dual1;
  return divergence - divergence.dot(n) * n;
}

}  // namespace

double nonlinearity(const ShellModel& shell, const Points& q, double energy,
                    const ShellTemperature& temperature) {
  if (!(energy > 0)) return 0;
  const ShellAssembler& assembler = shell.assembler();
  const SparseMatrix G = shell.geometric_stiffness(q, temperature);
  const double cubic = 0.5 * q.cwiseProduct(G.selfadjointView<Eigen::Lower>() * q).sum();
  const QuadraticStrains strains = quadratic_strains(assembler, q);
  const double quartic =
      strains.energy - 0.5 * strains.load.cwiseProduct(shell.adjoint(strains.load)).sum();
  return std::abs(3 * cubic + 4 * quartic) / (2 * energy);
}

double transverse_shear_energy(const ShellAssembler& shell, const ShellStresses& stresses) {
  const Surface& surface = shell.surface();
  const Trim* trim = surface.trim().get();
  std::vector<double> energies(static_cast<size_t>(surface.mesh().triangle_count()), 0);
  parallel_for_each<64>(isize(energies), [&](int t) {
    if (trim && trim->side(t) != Trim::Side::Inside) return;
    const Location centre{t, Vec3::Constant(1.0 / 3)};
    const double area = surface.mesh().shape(t).area * surface.jet(centre).area_vector().norm();
    const ShellSection& section = shell.section(t);
    const double shear = 0.5 * area * shear_forces(shell, stresses, t).squaredNorm() /
                         shear_stiffness(section, section.thickness_at(centre.L));
    double moments = 0;  // the largest one, squared
    for (int i = 0; i < 3; ++i)
      moments = std::max(moments, stresses.at({t, Vec3::Unit(i)}).moments.squaredNorm());
    const double bending = 0.5 * area * moments / section.bending_stiffness();
    energies[static_cast<size_t>(t)] = std::min(shear, bending);
  });
  return std::accumulate(energies.begin(), energies.end(), 0.0);
}

}  // namespace batten
