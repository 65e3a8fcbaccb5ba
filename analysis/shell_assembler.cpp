// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/shell_assembler.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <optional>

#include "batten/core/cancellation.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/core/solvers/supernodal_kernels.h"
#include "batten/elements/c1_triangle.h"

namespace batten {
namespace {

std::vector<int> stacked_dofs(const Surface& surface) {
  const DofMap& dofs = surface.dof_map();
  std::vector<int> all;
  for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
    poll_every<8192>(t);
    const auto of_triangle = dofs.triangle(surface.mesh(), t);
    for (int c = 0; c < 3; ++c)
      for (const int d : of_triangle) all.push_back(c * dofs.count() + d);
  }
  return all;
}

const TabulatedRule& whole_rule(TriangleElement kind) {
  static const TabulatedRule hct(TriangleElement::HCT, split_triangle_rule(4)),
      z12(TriangleElement::Z12, six_duffy_rule(4));
  return kind == TriangleElement::HCT ? hct : z12;
}

// Products of two cubics have degree 6.
constexpr int kMassDegree = 6;
const TabulatedRule& mass_rule(TriangleElement kind) {
  static const TabulatedRule hct(TriangleElement::HCT, split_triangle_rule(kMassDegree)),
      z12(TriangleElement::Z12, six_duffy_rule(5));
  return kind == TriangleElement::HCT ? hct : z12;
}

}  // namespace

ShellAssembler::ShellAssembler(Surface surface, std::vector<ShellSection> sections, double outside)
    : surface_(std::move(surface)),
      outside_(outside),
      pattern_(std::make_shared<const ElementPattern>(3 * surface_.dof_map().count(), 36,
                                                      stacked_dofs(surface_))) {
  update_sections(std::move(sections));
}

void ShellAssembler::update_sections(std::vector<ShellSection> sections) {
  if (sections.size() != 1 && isize(sections) != surface_.mesh().triangle_count())
    throw InputError("found " + std::to_string(sections.size()) + " shell sections for " +
                     std::to_string(surface_.mesh().triangle_count()) +
                     " triangles, expected one, or one for each");
  for (const ShellSection& section : sections) require_section(section);
  sections_ = std::move(sections);
}

void ShellAssembler::update_shape(Surface surface) {
  if (surface.dof_map().count() != surface_.dof_map().count() ||
      surface.mesh().triangles() != surface_.mesh().triangles())
    throw InputError("the new shape of a shell must have the same mesh");
  surface_ = std::move(surface);
}

template <class Visit>
void ShellAssembler::for_each_point(int t, const TabulatedRule& points, const Visit& visit) const {
  const ShellTriangle triangle(surface_, t, section(t).along);
  const Mat12 P = triangle.pull_back_matrix();
  for (long p = 0; p < points.rule.weights.size(); ++p) {
    const ReferenceTabulation& functions = points.functions[p];
    const ShellPoint at = triangle.point(functions);
    visit(triangle.functions(P, functions), at, Vec3(points.rule.L.row(p)),
          points.rule.weights[p] * triangle.parametric_area() * at.jacobian());
  }
}

namespace {

constexpr int kElementDofs = 36, kColumnsPerPoint = 6, kColumns = 18 * kColumnsPerPoint;

constexpr std::array<int, kElementDofs> kRowsInOrder = [] {
  std::array<int, kElementDofs> rows{};
  for (int i = 0; i < kElementDofs; ++i) rows[static_cast<size_t>(i)] = i;
  return rows;
}();

// The lower triangle of -B Bᵀ for the first columns of B, with the vector units of the machine.
Eigen::Matrix<double, kElementDofs, kElementDofs> negative_product(
    const Eigen::Matrix<double, kElementDofs, kColumns>& B, int columns) {
  Eigen::Matrix<double, kElementDofs, kElementDofs> product;
  product.setZero();
  std::array<double, static_cast<size_t>(scratch_size(kColumns))> scratch;
  subtract_product({B.data(), B.data(), kElementDofs, columns, kElementDofs, kElementDofs,
                    kRowsInOrder.data(), kRowsInOrder.data(), product.data(), kElementDofs},
                   scratch.data());
  return product;
}

}  // namespace

namespace {

// The Cholesky factor [L11 0; L21 L22] of [A B; B D], see SectionIntegrals.
struct SectionFactor {
  explicit SectionFactor(const ShellSection& section) : offset(section.offset) {
    const SectionIntegrals of = section.integrals();
    L11 = Eigen::LLT<Mat3>(of.A).matrixL();
    L21 = L11.triangularView<Eigen::Lower>().solve(of.B).transpose();
    L22 = Eigen::LLT<Mat3>(of.D - L21 * L21.transpose()).matrixL();
    is_coupled = offset != 0 || !L21.isZero(0);
    L21 += offset * L11;  // of strains on the reference surface
  }
  double offset;
  Mat3 L11, L21, L22;
  bool is_coupled;
};

}  // namespace

// K = B Bᵀ with six columns of B per point, (ε L11 + t κ (L21 + o L11), t κ L22) √(w t), with the
// factor L of the section, its offset o and the area w of the point. One matrix product is several
// times as fast as summing the terms one by one.
void ShellAssembler::add(int t, const TabulatedRule& rule, double factor, ElementMatrix& K) const {
  const ShellSection& s = section(t);
  const SectionFactor root(s);
  Eigen::Matrix<double, kElementDofs, kColumns> B;
  int columns = 0;
  double sign = 1;  // rules of cut triangles may have negative weights
  const auto add_columns = [&] {
    if (columns > 0) K -= sign * negative_product(B, columns);
    columns = 0;
  };
  for_each_point(t, rule,
                 [&](const Tabulation& N, const ShellPoint& at, const Vec3& L, double area) {
                   if ((area < 0) != (sign < 0) || columns == kColumns) add_columns();
                   sign = area < 0 ? -1 : 1;
                   const double thickness = s.thickness_at(L),
                                membrane = std::sqrt(sign * factor * area * thickness);
                   const Mat3 M = membrane * root.L11;
                   const Vec12 f1 = at.along_axes(0, N.col(kU), N.col(kV)),
                               f2 = at.along_axes(1, N.col(kU), N.col(kV));
                   using Columns = Eigen::Matrix<double, 12, 3>;
                   const Columns bending = -membrane * thickness * at.bending_matrix(N).transpose();
                   const Columns curved = bending * root.L22;
                   // The strains of coordinate c are e1[c] f1, e2[c] f2 and e1[c] f2 + e2[c] f1.
                   for (int c = 0; c < 3; ++c) {
                     const double e1 = at.e1()[c], e2 = at.e2()[c];
                     for (int k = 0; k < 3; ++k)
                       B.block<12, 1>(12 * c, columns + k) =
                           (e1 * M(0, k) + e2 * M(2, k)) * f1 + (e2 * M(1, k) + e1 * M(2, k)) * f2;
                     if (root.is_coupled)
                       B.block<12, 3>(12 * c, columns) += at.normal()[c] * bending * root.L21;
                     B.block<12, 3>(12 * c, columns + 3) = at.normal()[c] * curved;
                   }
                   columns += kColumnsPerPoint;
                 });
  add_columns();
}

// Second derivatives of HCT functions are linear, those of Z12 functions rational.
int ShellAssembler::cut_degree() const { return surface_.kind() == TriangleElement::HCT ? 4 : 8; }

void ShellAssembler::for_each_quadrature_point(int t, const PointVisitor& visit) const {
  for_each_quadrature_point(t, whole_rule(surface_.kind()), cut_degree(), visit);
}

void ShellAssembler::for_each_quadrature_point(int t, const TabulatedRule& whole, int degree,
                                               const PointVisitor& visit) const {
  const Trim* trim = surface_.trim().get();
  if (trim && trim->side(t) == Trim::Side::Outside) return;
  std::optional<TabulatedRule> cut;
  if (trim && trim->side(t) == Trim::Side::Cut) cut.emplace(surface_.kind(), trim->rule(t, degree));
  const TabulatedRule& points = cut ? *cut : whole;
  const ShellTriangle triangle(surface_, t, section(t).along);
  for (long p = 0; p < points.rule.weights.size(); ++p) {
    const ShellPoint at = triangle.point(points.functions[p]);
    visit(triangle, points.functions[p], at, Vec3(points.rule.L.row(p)),
          points.rule.weights[p] * triangle.parametric_area() * at.jacobian());
  }
}

TemperatureAt ShellAssembler::temperature_at(const ShellTemperature& temperature, int triangle,
                                             const Vec3& L) const {
  if (temperature.empty()) return {};
  TemperatureAt at;
  for (int i = 0; i < 3; ++i) {
    const int v = surface_.mesh().triangles()[triangle][i];
    at.middle += L[i] * temperature.middle[v];
    at.difference += L[i] * temperature.difference[v];
  }
  return at;
}

ShellAssembler::Resultants ShellAssembler::resultants(int triangle, const Vec3& L,
                                                      const ShellStrain& s,
                                                      const TemperatureAt& temperature) const {
  const ShellSection& of = section(triangle);
  const SectionIntegrals sum = of.integrals();
  const double t = of.thickness_at(L);
  const Vec3 bending = t * s.curvature, membrane = s.membrane + of.offset * bending;
  const auto& [a0, a1, a2] = sum.thermal;
  Resultants result;
  result.forces = t * (sum.A * membrane + sum.B * bending - temperature.middle * a0 -
                       temperature.difference * a1);
  result.moments = t * t *
                       (sum.B * membrane + sum.D * bending - temperature.middle * a1 -
                        temperature.difference * a2) +
                   of.offset * t * result.forces;
  return result;
}

Points ShellAssembler::thermal_load(const ShellTemperature& temperature) const {
  const int vertices = surface_.mesh().vertex_count();
  if (temperature.middle.size() != vertices || temperature.difference.size() != vertices)
    throw InputError("found temperatures of " + std::to_string(temperature.middle.size()) +
                     " vertices, expected " + std::to_string(vertices) + " of the shell");
  std::vector<Eigen::Matrix<double, 12, 3>> parts(
      static_cast<size_t>(surface_.mesh().triangle_count()), Eigen::Matrix<double, 12, 3>::Zero());
  parallel_for_each<64>(isize(parts), [&](int t) {
    std::optional<Mat12> pull_back;
    for_each_quadrature_point(t, [&](const ShellTriangle& triangle,
                                     const ReferenceTabulation& functions, const ShellPoint& at,
                                     const Vec3& L, double area) {
      if (!pull_back) pull_back = triangle.pull_back_matrix();
      const Resultants r = resultants(t, L, {}, temperature_at(temperature, t, L));
      parts[static_cast<size_t>(t)] -=
          area * nodal_forces(triangle.functions(*pull_back, functions), at, r.forces, r.moments);
    });
  });
  Points load = Points::Zero(surface_.dof_map().count(), 3);
  for (int t = 0; t < isize(parts); ++t) {
    const auto dofs = surface_.dof_map().triangle(surface_.mesh(), t);
    for (int a = 0; a < isize(dofs); ++a)
      load.row(dofs[static_cast<size_t>(a)]) += parts[static_cast<size_t>(t)].row(a);
  }
  return load;
}

SparseMatrix ShellAssembler::stiffness() const {
  const TabulatedRule& whole = whole_rule(surface_.kind());
  const Trim* trim = surface_.trim().get();
  SparseMatrix result = pattern_->zero();
  pattern_->assemble(
      [&](int t, double* out) {
        Eigen::Map<ElementMatrix> mapped(out);
        ElementMatrix K = ElementMatrix::Zero();
        const bool cut = trim && trim->side(t) == Trim::Side::Cut;
        const bool outside = trim && trim->side(t) == Trim::Side::Outside;
        add(t, whole, cut || outside ? outside_ : 1, K);
        if (cut)
          add(t, TabulatedRule(surface_.kind(), trim->rule(t, cut_degree())), 1 - outside_, K);
        mapped = K.selfadjointView<Eigen::Lower>();
      },
      result);
  return result;
}

SparseMatrix ShellAssembler::integrate_inside(
    const std::function<void(int triangle, const TabulatedRule& rule, ScalarMatrix& K)>& add)
    const {
  const DofMap& map = surface_.dof_map();
  std::vector<int> dofs;
  for (int t = 0; t < surface_.mesh().triangle_count(); ++t) {
    const auto of_triangle = map.triangle(surface_.mesh(), t);
    dofs.insert(dofs.end(), of_triangle.begin(), of_triangle.end());
  }
  const ElementPattern pattern(map.count(), 12, dofs);
  const TabulatedRule& whole = mass_rule(surface_.kind());
  const Trim* trim = surface_.trim().get();
  SparseMatrix result = pattern.zero();
  pattern.assemble(
      [&](int t, double* out) {
        Eigen::Map<ScalarMatrix> mapped(out);
        ScalarMatrix K = ScalarMatrix::Zero();
        const bool cut = trim && trim->side(t) == Trim::Side::Cut;
        if (!trim || trim->side(t) != Trim::Side::Outside)
          add(t, cut ? TabulatedRule(surface_.kind(), trim->rule(t, kMassDegree)) : whole, K);
        mapped = K;
      },
      result);
  return result;
}

SparseMatrix ShellAssembler::mass() const {
  return integrate_inside([&](int t, const TabulatedRule& rule, ScalarMatrix& M) {
    const ShellSection& s = section(t);
    const double density = s.density();
    for_each_point(t, rule,
                   [&](const Tabulation& N, const ShellPoint&, const Vec3& L, double area) {
                     M += area * density * s.thickness_at(L) * N.col(kW) * N.col(kW).transpose();
                   });
  });
}

SparseMatrix ShellAssembler::geometric_stiffness(const Points& q,
                                                 const ShellTemperature& temperature) const {
  return integrate_inside([&](int t, const TabulatedRule& rule, ScalarMatrix& G) {
    const Eigen::Matrix<double, 12, 3> local = dofs_on(q, t);
    for_each_point(
        t, rule, [&](const Tabulation& N, const ShellPoint& at, const Vec3& L, double area) {
          const Vec3 force = area * resultants(t, L, at.strain(local.transpose().lazyProduct(N)),
                                               temperature_at(temperature, t, L))
                                        .forces;
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

Eigen::Matrix<double, 12, 3> ShellAssembler::dofs_on(const Points& q, int t) const {
  const auto dof = surface_.dof_map().triangle(surface_.mesh(), t);
  Eigen::Matrix<double, 12, 3> local;
  for (int a = 0; a < 12; ++a) local.row(a) = q.row(dof[a]);
  return local;
}

ShellStrain ShellAssembler::strain(const Points& q, const Location& where) const {
  if (q.rows() != surface_.dof_map().count())
    throw InputError("found displacements of " + std::to_string(q.rows()) + " dofs, expected " +
                     std::to_string(surface_.dof_map().count()) + " of the shell");
  const C1Triangle triangle(surface_.kind(), surface_.mesh().shape(where.triangle));
  return point(where).strain(triangle.jet(where.L, dofs_on(q, where.triangle)));
}

Vec3 ShellAssembler::stress(const Points& q, const Location& where, double z) const {
  const ShellStrain s = strain(q, where);
  const ShellSection& of = section(where.triangle);
  const Vec3 at = s.membrane + (z + of.offset * of.thickness_at(where.L)) * s.curvature;
  const double height = z / of.thickness_at(where.L);
  int k = 0;
  while (k + 1 < of.ply_count() && of.ply(k).top < height) ++k;
  const Mat3 T = strain_rotation(of.ply(k).angle);
  return T.transpose() * of.ply(k).material.Q * T * at;
}

ShellAssembler::Resultants ShellAssembler::resultants(const Points& q, const Location& where,
                                                      const ShellTemperature& temperature) const {
  return resultants(where.triangle, where.L, strain(q, where),
                    temperature_at(temperature, where.triangle, where.L));
}

Eigen::Matrix<double, 12, 3> nodal_forces(const Tabulation& N, const ShellPoint& at,
                                          const Vec3& forces, const Vec3& moments) {
  const Vec12 f1 = at.along_axes(0, N.col(kU), N.col(kV)),
              f2 = at.along_axes(1, N.col(kU), N.col(kV)),
              curved = at.bending_matrix(N).transpose() * moments;
  return f1 * (forces[0] * at.e1() + forces[2] * at.e2()).transpose() +
         f2 * (forces[1] * at.e2() + forces[2] * at.e1()).transpose() -
         curved * at.normal().transpose();
}

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
