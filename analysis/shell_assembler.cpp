#include "batten/analysis/shell_assembler.h"

#include <cmath>

#include "batten/core/errors.h"
#include "batten/elements/c1_triangle.h"

namespace batten {
namespace {

std::vector<int> stacked_dofs(const Surface& surface) {
  const DofMap& dofs = surface.dof_map();
  std::vector<int> all;
  for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
    const auto of_triangle = dofs.triangle(surface.mesh(), t);
    for (int c = 0; c < 3; ++c)
      for (const int d : of_triangle) all.push_back(c * dofs.count() + d);
  }
  return all;
}

TriangleRule rule_of(TriangleElement kind) {
  return kind == TriangleElement::HCT ? split_triangle(4) : six_duffy(4);
}

// What f,1 or f,2 of a function in one coordinate adds to (ε11, ε22, 2ε12).
Vec3 strain_along(const Vec3& e1, const Vec3& e2, int axis, int coordinate) {
  return axis == 0 ? Vec3(e1[coordinate], 0, e2[coordinate])
                   : Vec3(0, e2[coordinate], e1[coordinate]);
}

}  // namespace

ShellAssembler::ShellAssembler(Surface surface, std::vector<ShellSection> sections, double outside)
    : surface_(std::move(surface)),
      sections_(std::move(sections)),
      outside_(outside),
      pattern_(3 * surface_.dof_map().count(), 36, stacked_dofs(surface_)) {
  if (sections_.size() != 1 && count_of(sections_) != surface_.mesh().triangle_count())
    throw InputError(std::to_string(sections_.size()) + " sections for " +
                     std::to_string(surface_.mesh().triangle_count()) + " triangles");
  for (const ShellSection& section : sections_) require_section(section);
}

template <class Visit>
void ShellAssembler::for_points(int t, const TriangleRule& rule, const Visit& visit) const {
  const TriangleShape shape = surface_.mesh().shape(t);
  const C1Triangle triangle(surface_.kind(), shape);
  const Eigen::Matrix<double, 12, 3> q = surface_.triangle_dofs(t);
  for (long p = 0; p < rule.weights.size(); ++p) {
    const Vec3 L = rule.L.row(p);
    const Tabulation N = triangle.evaluate(L);
    const Eigen::Matrix<double, 3, kDerivatives> x = q.transpose() * N;
    const ShellPoint at({x.col(kW), x.col(kU), x.col(kV), x.col(kUU), x.col(kUV), x.col(kVV)},
                        section(t).along);
    visit(N, at, L, rule.weights[p] * shape.area * at.jacobian());
  }
}

void ShellAssembler::add(int t, const TriangleRule& rule, double factor, ElementMatrix& K) const {
  const ShellSection& s = section(t);
  for_points(t, rule, [&](const Tabulation& N, const ShellPoint& at, const Vec3& L, double area) {
    const double w = factor * area, thickness = s.thickness_at(L),
                 bending = std::pow(thickness, 3) / 12;
    const Vec12 f[2] = {at.along_axes(0, N.col(kU), N.col(kV)),
                        at.along_axes(1, N.col(kU), N.col(kV))};
    const Eigen::Matrix<double, 3, 12> rows = at.bending_rows(N);
    const Mat12 bent = w * bending * rows.transpose() * s.material.Q * rows;
    const Vec3& n = at.normal();
    for (int c = 0; c < 3; ++c)
      for (int d = 0; d <= c; ++d) {
        auto block = K.block<12, 12>(12 * c, 12 * d);
        block += n[c] * n[d] * bent;
        for (int a = 0; a < 2; ++a) {
          const Vec3 stress = w * thickness * s.material.Q * strain_along(at.e1(), at.e2(), a, c);
          const Vec12 g = stress.dot(strain_along(at.e1(), at.e2(), 0, d)) * f[0] +
                          stress.dot(strain_along(at.e1(), at.e2(), 1, d)) * f[1];
          block += f[a] * g.transpose();
        }
      }
  });
}

SparseMatrix ShellAssembler::stiffness() const {
  const TriangleRule whole = rule_of(surface_.kind());
  const Trim* trim = surface_.trim().get();
  SparseMatrix result = pattern_.zero();
  pattern_.assemble(
      [&](int t, double* out) {
        Eigen::Map<ElementMatrix> mapped(out);
        ElementMatrix K = ElementMatrix::Zero();
        const bool cut = trim && trim->side(t) == Trim::Side::Cut;
        const bool outside = trim && trim->side(t) == Trim::Side::Outside;
        add(t, whole, cut || outside ? outside_ : 1, K);
        // Second derivatives of HCT functions are linear, those of Z12 functions rational.
        if (cut)
          add(t, trim->rule(t, surface_.kind() == TriangleElement::HCT ? 4 : 8), 1 - outside_, K);
        mapped = K;
      },
      result);
  return result;
}

SparseMatrix ShellAssembler::over_inside(
    const std::function<void(int triangle, const TriangleRule& rule, ScalarMatrix& K)>& add) const {
  const DofMap& map = surface_.dof_map();
  std::vector<int> dofs;
  for (int t = 0; t < surface_.mesh().triangle_count(); ++t) {
    const auto of_triangle = map.triangle(surface_.mesh(), t);
    dofs.insert(dofs.end(), of_triangle.begin(), of_triangle.end());
  }
  const ElementPattern pattern(map.count(), 12, dofs);
  // Products of cubics are of degree 6.
  constexpr int degree = 6, order = 5;
  const TriangleRule whole =
      surface_.kind() == TriangleElement::HCT ? split_triangle(degree) : six_duffy(order);
  const Trim* trim = surface_.trim().get();
  SparseMatrix result = pattern.zero();
  pattern.assemble(
      [&](int t, double* out) {
        Eigen::Map<ScalarMatrix> mapped(out);
        ScalarMatrix K = ScalarMatrix::Zero();
        const bool cut = trim && trim->side(t) == Trim::Side::Cut;
        if (!trim || trim->side(t) != Trim::Side::Outside)
          add(t, cut ? trim->rule(t, degree) : whole, K);
        mapped = K;
      },
      result);
  return result;
}

SparseMatrix ShellAssembler::mass() const {
  return over_inside([&](int t, const TriangleRule& rule, ScalarMatrix& M) {
    const ShellSection& s = section(t);
    for_points(t, rule, [&](const Tabulation& N, const ShellPoint&, const Vec3& L, double area) {
      M += area * s.material.density * s.thickness_at(L) * N.col(kW) * N.col(kW).transpose();
    });
  });
}

SparseMatrix ShellAssembler::geometric_stiffness(const Points& q) const {
  return over_inside([&](int t, const TriangleRule& rule, ScalarMatrix& G) {
    for_points(t, rule, [&](const Tabulation& N, const ShellPoint& at, const Vec3& L, double area) {
      const Vec3 force = area * resultants(q, {t, L}).forces;
      const Vec12 f1 = at.along_axes(0, N.col(kU), N.col(kV)),
                  f2 = at.along_axes(1, N.col(kU), N.col(kV));
      G += f1 * (force[0] * f1 + force[2] * f2).transpose() +
           f2 * (force[2] * f1 + force[1] * f2).transpose();
    });
  });
}

ShellPoint ShellAssembler::point(const Location& where) const {
  return {surface_.jet(where), section(where.triangle).along};
}

ShellStrain ShellAssembler::strain(const Points& q, const Location& where) const {
  if (q.rows() != surface_.dof_map().count())
    throw InputError("a displacement of " + std::to_string(q.rows()) + " dofs on a shell of " +
                     std::to_string(surface_.dof_map().count()));
  const auto dof = surface_.dof_map().triangle(surface_.mesh(), where.triangle);
  Eigen::Matrix<double, 12, 3> local;
  for (int a = 0; a < 12; ++a) local.row(a) = q.row(dof[a]);
  const C1Triangle triangle(surface_.kind(), surface_.mesh().shape(where.triangle));
  return point(where).strain(triangle.jet(where.L, local));
}

Vec3 ShellAssembler::stress(const Points& q, const Location& where, double z) const {
  const ShellStrain s = strain(q, where);
  return section(where.triangle).material.Q * (s.membrane + z * s.curvature);
}

ShellAssembler::Resultants ShellAssembler::resultants(const Points& q,
                                                      const Location& where) const {
  const ShellStrain s = strain(q, where);
  const ShellSection& of = section(where.triangle);
  const double t = of.thickness_at(where.L);
  return {t * of.material.Q * s.membrane, t * t * t / 12 * of.material.Q * s.curvature};
}

}  // namespace batten
