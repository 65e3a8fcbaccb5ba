// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/von_mises_norm.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include "batten/core/errors.h"
#include "batten/core/parallel.h"

namespace batten {
namespace {

// σ_vm² = sᵀ V s for the stress s = (11, 22, 12).
const Mat3 kVonMises = (Mat3() << 1, -0.5, 0, -0.5, 1, 0, 0, 0, 3).finished();

/// Stresses at the top and bottom of one quadrature point, and the area that it represents.
struct PointStresses {
  double area, half_thickness;
  Vec3 top, bottom;
};

double von_mises_of(const Vec3& s) { return std::sqrt(std::max(0.0, s.dot(kVonMises * s))); }

PointStresses stresses_at(const ShellSection& section, const ShellStrain& strain, const Vec3& L,
                          double area) {
  const double half = 0.5 * section.thickness_at(L);
  const Vec3 membrane = section.material.Q * strain.membrane,
             bending = half * (section.material.Q * strain.curvature);
  return {area, half, membrane + bending, membrane - bending};
}

/// Stresses at the quadrature points of each triangle. Points with negative weights, which only cut
/// triangles have, are left out: their sum with a high power could be negative.
std::vector<std::vector<PointStresses>> all_stresses(const ShellAssembler& shell, const Points& q) {
  std::vector<std::vector<PointStresses>> all(
      static_cast<size_t>(shell.surface().mesh().triangle_count()));
  parallel_for_each<64>(isize(all), [&](int t) {
    std::optional<ShellTriangle::Dofs> reference;
    shell.for_each_quadrature_point(
        t, [&](const ShellTriangle& triangle, const ReferenceTabulation& functions,
               const ShellPoint& at, const Vec3& L, double area) {
          if (!(area > 0)) return;
          if (!reference) reference = triangle.reference(shell.dofs_on(q, t));
          all[static_cast<size_t>(t)].push_back(stresses_at(
              shell.section(t), at.strain(triangle.jet(*reference, functions)), L, area));
        });
  });
  return all;
}

/// Sum of value(t) over the triangles, in their order for any number of threads.
template <class Value>
double sum_over_triangles(int count, const Value& value) {
  std::vector<double> values(static_cast<size_t>(count));
  parallel_for_each<64>(count, [&](int t) { values[static_cast<size_t>(t)] = value(t); });
  return std::accumulate(values.begin(), values.end(), 0.0);
}

double norm_of(const std::vector<std::vector<PointStresses>>& all, double exponent, double area) {
  double largest = 0;
  for (const auto& points : all)
    for (const PointStresses& p : points)
      largest = std::max({largest, von_mises_of(p.top), von_mises_of(p.bottom)});
  if (!(largest > 0)) return 0;
  const double sum = sum_over_triangles(isize(all), [&](int t) {
    double of_triangle = 0;
    for (const PointStresses& p : all[static_cast<size_t>(t)])
      of_triangle += p.area * (std::pow(von_mises_of(p.top) / largest, exponent) +
                               std::pow(von_mises_of(p.bottom) / largest, exponent));
    return of_triangle;
  });
  return largest * std::pow(sum / (2 * area), 1 / exponent);
}

/// Derivative of the norm with respect to the dofs of one triangle.
ShellTriangle::Dofs gradient_on(const ShellAssembler& shell, int t,
                                const std::vector<PointStresses>& points, double exponent,
                                double value, double area) {
  ShellTriangle::Dofs gradient = ShellTriangle::Dofs::Zero();
  const Mat3 weights = shell.section(t).material.Q * kVonMises;
  // ∂σ_P/∂s of a stress s at a point, multiplied by Q.
  const auto of_stress = [&](const PointStresses& p, const Vec3& s) -> Vec3 {
    const double factor =
        p.area / (2 * area) * std::pow(von_mises_of(s) / value, exponent - 2) / value;
    return factor * (weights * s);
  };
  std::optional<Mat12> pull_back;
  size_t next = 0;
  shell.for_each_quadrature_point(
      t, [&](const ShellTriangle& triangle, const ReferenceTabulation& functions,
             const ShellPoint& at, const Vec3&, double weight) {
        if (!(weight > 0)) return;
        if (!pull_back) pull_back = triangle.pull_back_matrix();
        const PointStresses& p = points[next++];
        const Vec3 top = of_stress(p, p.top), bottom = of_stress(p, p.bottom),
                   membrane = top + bottom, bending = p.half_thickness * (top - bottom);
        const Tabulation N = triangle.functions(*pull_back, functions);
        const Vec12 f1 = at.along_axes(0, N.col(kU), N.col(kV)),
                    f2 = at.along_axes(1, N.col(kU), N.col(kV)),
                    curved = at.bending_matrix(N).transpose() * bending;
        gradient += f1 * (membrane[0] * at.e1() + membrane[2] * at.e2()).transpose() +
                    f2 * (membrane[1] * at.e2() + membrane[2] * at.e1()).transpose() -
                    curved * at.normal().transpose();
      });
  return gradient;
}

}  // namespace

VonMisesNorm von_mises_norm(const ShellAssembler& shell, const Points& q, double exponent) {
  constexpr double least = 2, most = 100;
  if (!(exponent >= least && exponent <= most))
    throw InputError("exponent: found " + format_number(exponent) + ", expected 2 to 100");
  const Surface& surface = shell.surface();
  if (q.rows() != surface.dof_map().count())
    throw InputError("found displacements of " + std::to_string(q.rows()) + " dofs, expected " +
                     std::to_string(surface.dof_map().count()) + " of the shell");
  const auto all = all_stresses(shell, q);
  double area = 0;
  for (const auto& points : all)
    for (const PointStresses& p : points) area += p.area;
  VonMisesNorm norm{norm_of(all, exponent, area), Points::Zero(q.rows(), 3)};
  if (!(norm.value > 0)) return norm;
  std::vector<ShellTriangle::Dofs> parts(all.size());
  parallel_for_each<64>(isize(all), [&](int t) {
    const auto i = static_cast<size_t>(t);
    parts[i] = gradient_on(shell, t, all[i], exponent, norm.value, area);
  });
  for (int t = 0; t < isize(parts); ++t) {
    const auto dofs = surface.dof_map().triangle(surface.mesh(), t);
    for (int a = 0; a < isize(dofs); ++a)
      norm.gradient.row(dofs[static_cast<size_t>(a)]) += parts[static_cast<size_t>(t)].row(a);
  }
  return norm;
}

double shell_mass(const ShellAssembler& shell) {
  return sum_over_triangles(shell.surface().mesh().triangle_count(), [&](int t) {
    const ShellSection& section = shell.section(t);
    double mass = 0;
    shell.for_each_quadrature_point(
        t, [&](const ShellTriangle&, const ReferenceTabulation&, const ShellPoint&, const Vec3& L,
               double area) { mass += area * section.material.density * section.thickness_at(L); });
    return mass;
  });
}

}  // namespace batten
