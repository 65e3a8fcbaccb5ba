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

/// A face of a ply: the height z of the reference surface's strains divided by the thickness, and its
/// material in the axes of the section.
struct PlyFace {
  double height;
  Mat3 Q;
  Vec3 thermal;       // Q α
  double in_section;  // height above the middle, relative to the thickness
};

std::vector<PlyFace> faces_of(const ShellSection& section) {
  std::vector<PlyFace> faces;
  for (int k = 0; k < section.ply_count(); ++k) {
    const ShellSection::PlyView ply = section.ply(k);
    const Mat3 T = strain_rotation(ply.angle);
    for (const double height : {ply.top, ply.bottom})
      faces.push_back({height + section.offset, T.transpose() * ply.material.Q * T,
                       T.transpose() * ply.material.thermal_stress(), height});
  }
  return faces;
}

double von_mises_of(const Vec3& s) { return std::sqrt(std::max(0.0, s.dot(kVonMises * s))); }

/// Stresses on the faces of the plies at one quadrature point, and the area that it represents.
struct PointStresses {
  double area, thickness;
  std::vector<Vec3> faces;
};

/// Stresses at the quadrature points of each triangle. Points with negative weights, which only cut
/// triangles have, are left out: their sum with a high power could be negative.
std::vector<std::vector<PointStresses>> all_stresses(const ShellAssembler& shell, const Points& q,
                                                     const ShellTemperature& temperature) {
  std::vector<std::vector<PointStresses>> all(
      static_cast<size_t>(shell.surface().mesh().triangle_count()));
  parallel_for_each<64>(isize(all), [&](int t) {
    std::optional<ShellTriangle::Dofs> reference;
    const std::vector<PlyFace> faces = faces_of(shell.section(t));
    shell.for_each_quadrature_point(
        t, [&](const ShellTriangle& triangle, const ReferenceTabulation& functions,
               const ShellPoint& at, const Vec3& L, double area) {
          if (!(area > 0)) return;
          if (!reference) reference = triangle.reference(shell.dofs_on(q, t));
          const ShellStrain strain = at.strain(triangle.jet(*reference, functions));
          const TemperatureAt here = shell.temperature_at(temperature, t, L);
          PointStresses point{area, shell.section(t).thickness_at(L), {}};
          for (const PlyFace& face : faces)
            point.faces.push_back(
                face.Q * (strain.membrane + face.height * point.thickness * strain.curvature) -
                (here.middle + face.in_section * here.difference) * face.thermal);
          all[static_cast<size_t>(t)].push_back(std::move(point));
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
      for (const Vec3& stress : p.faces) largest = std::max(largest, von_mises_of(stress));
  if (!(largest > 0)) return 0;
  const double sum = sum_over_triangles(isize(all), [&](int t) {
    double of_triangle = 0;
    for (const PointStresses& p : all[static_cast<size_t>(t)])
      for (const Vec3& stress : p.faces)
        of_triangle += p.area / static_cast<double>(p.faces.size()) *
                       std::pow(von_mises_of(stress) / largest, exponent);
    return of_triangle;
  });
  return largest * std::pow(sum / area, 1 / exponent);
}

/// Derivative of the norm with respect to the dofs of one triangle.
ShellTriangle::Dofs gradient_on(const ShellAssembler& shell, int t,
                                const std::vector<PointStresses>& points, double exponent,
                                double value, double area) {
  ShellTriangle::Dofs gradient = ShellTriangle::Dofs::Zero();
  const std::vector<PlyFace> faces = faces_of(shell.section(t));
  // ∂σ_P/∂s of a stress s on a face at a point, multiplied by Q.
  const auto of_stress = [&](const PointStresses& p, size_t face) -> Vec3 {
    const Vec3& s = p.faces[face];
    const double factor = p.area / (static_cast<double>(faces.size()) * area) *
                          std::pow(von_mises_of(s) / value, exponent - 2) / value;
    return factor * (faces[face].Q * (kVonMises * s));
  };
  std::optional<Mat12> pull_back;
  size_t next = 0;
  shell.for_each_quadrature_point(
      t, [&](const ShellTriangle& triangle, const ReferenceTabulation& functions,
             const ShellPoint& at, const Vec3&, double weight) {
        if (!(weight > 0)) return;
        if (!pull_back) pull_back = triangle.pull_back_matrix();
        const PointStresses& p = points[next++];
        Vec3 membrane = Vec3::Zero(), bending = Vec3::Zero();
        for (size_t face = 0; face < faces.size(); ++face) {
          const Vec3 part = of_stress(p, face);
          membrane += part;
          bending += faces[face].height * p.thickness * part;
        }
        gradient += nodal_forces(triangle.functions(*pull_back, functions), at, membrane, bending);
      });
  return gradient;
}

}  // namespace

VonMisesNorm von_mises_norm(const ShellAssembler& shell, const Points& q, double exponent,
                            const ShellTemperature& temperature) {
  constexpr double least = 2, most = 100;
  if (!(exponent >= least && exponent <= most))
    throw InputError("exponent: found " + format_number(exponent) + ", expected 2 to 100");
  const Surface& surface = shell.surface();
  if (q.rows() != surface.dof_map().count())
    throw InputError("found displacements of " + std::to_string(q.rows()) + " dofs, expected " +
                     std::to_string(surface.dof_map().count()) + " of the shell");
  const auto all = all_stresses(shell, q, temperature);
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
               double area) { mass += area * section.density() * section.thickness_at(L); });
    return mass;
  });
}

}  // namespace batten
