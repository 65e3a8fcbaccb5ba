// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/surface_assembler.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/elements/reference_triangle.h"
#include "batten/fem/surface.h"

namespace batten {
namespace {

std::vector<int> surface_dofs(const ParametricMesh& mesh, const DofMap& dofs) {
  std::vector<int> all;
  all.reserve(12 * static_cast<size_t>(mesh.triangle_count()));
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    poll_every<16384>(t);
    for (const int d : dofs.triangle(mesh, t)) all.push_back(d);
  }
  return all;
}

const TabulatedRule& varying_functions(TriangleElement kind) {
  static const TabulatedRule hct(TriangleElement::HCT,
                                 C1Triangle::default_quadrature(TriangleElement::HCT));
  static const TabulatedRule z12(TriangleElement::Z12,
                                 C1Triangle::default_quadrature(TriangleElement::Z12));
  return kind == TriangleElement::HCT ? hct : z12;
}

const TabulatedRule& pressure_functions(TriangleElement kind) {
  static const TabulatedRule hct(TriangleElement::HCT, split_triangle_rule(8));
  static const TabulatedRule z12(TriangleElement::Z12, six_duffy_rule(5));
  return kind == TriangleElement::HCT ? hct : z12;
}

}  // namespace

SurfaceAssembler::SurfaceAssembler(const ParametricMesh& mesh, TriangleElement kind,
                                   std::shared_ptr<const Trim> trim, double outside)
    : mesh_(mesh),
      kind_(kind),
      trim_(std::move(trim)),
      outside_(outside),
      dofs_(mesh),
      pattern_(dofs_.count(), 12, surface_dofs(mesh, dofs_)) {
  shapes_.reserve(mesh.triangle_count());
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    poll_every<16384>(t);
    shapes_.push_back(mesh.shape(t));
  }
}

void SurfaceAssembler::cut(int t, const MaterialAt& material, double* K) const {
  Eigen::Map<Mat12> element(K, 12, 12);
  element *= outside_;
  if (is_outside(t)) return;
  // Second derivatives of HCT functions are linear, those of Z12 functions rational.
  const int degree = kind_ == TriangleElement::HCT ? 4 : 8;
  Mat12 inside;
  variable_stiffness(TabulatedRule(kind_, trim_->rule(t, degree)), shapes_[t], material,
                     inside.data());
  element += (1 - outside_) * inside;
}

void SurfaceAssembler::stiffness(const SurfaceStiffness& material, SparseMatrix& K) const {
  const ReferenceTensors& tensors = reference_tensors(kind_);
  pattern_.assemble(
      [&](int t, double* element) {
        constant_stiffness(tensors, shapes_[t], material, element);
        if (is_cut(t) || is_outside(t))
          cut(
              t, [&](const Vec3&) { return material; }, element);
      },
      K);
}

void SurfaceAssembler::stiffness(const std::vector<SurfaceStiffness>& materials,
                                 SparseMatrix& K) const {
  if (isize(materials) != mesh_.triangle_count())
    throw InputError("found " + std::to_string(materials.size()) + " stiffnesses for " +
                     std::to_string(mesh_.triangle_count()) + " triangles, expected one for each");
  const ReferenceTensors& tensors = reference_tensors(kind_);
  pattern_.assemble(
      [&](int t, double* element) {
        constant_stiffness(tensors, shapes_[t], materials[t], element);
        if (is_cut(t) || is_outside(t))
          cut(
              t, [&](const Vec3&) { return materials[t]; }, element);
      },
      K);
}

void SurfaceAssembler::stiffness(const MaterialField& material, SparseMatrix& K) const {
  const TabulatedRule& points = varying_functions(kind_);
  pattern_.assemble(
      [&](int t, double* element) {
        const auto at = [&](const Vec3& L) { return material(shapes_[t].point(L)); };
        variable_stiffness(points, shapes_[t], at, element);
        if (is_cut(t) || is_outside(t)) cut(t, at, element);
      },
      K);
}

SparseMatrix SurfaceAssembler::stiffness(const SurfaceStiffness& material) const {
  SparseMatrix K = pattern();
  stiffness(material, K);
  return K;
}

SparseMatrix SurfaceAssembler::mass(const VecX& triangle_weights) const {
  if (triangle_weights.size() > 0) check_weights(triangle_weights);
  SparseMatrix M = pattern();
  pattern_.assemble(
      [&](int t, double* element) {
        Eigen::Map<Mat12> mass(element, 12, 12);
        const double w = triangle_weights.size() > 0 ? triangle_weights[t] : 1;
        if (!is_cut(t) && !is_outside(t)) {
          mass = w * C1Triangle(kind_, shapes_[t]).mass();
          return;
        }
        mass.setZero();
        const TriangleRule rule = trim_->rule(t, 6);
        for (long p = 0; p < rule.weights.size(); ++p) {
          const Vec12 N = C1Triangle(kind_, shapes_[t]).evaluate(rule.L.row(p)).col(kW);
          mass += w * shapes_[t].area * rule.weights[p] * N * N.transpose();
        }
      },
      M);
  return M;
}

Vec12 SurfaceAssembler::unit_load(int t) const {
  const C1Triangle triangle(kind_, shapes_[t]);
  if (is_outside(t)) return Vec12::Zero();
  if (!is_cut(t)) return triangle.load();
  Vec12 element = Vec12::Zero();
  const TriangleRule rule = trim_->rule(t, kind_ == TriangleElement::HCT ? 3 : 8);
  for (long p = 0; p < rule.weights.size(); ++p)
    element += shapes_[t].area * rule.weights[p] * triangle.evaluate(rule.L.row(p)).col(kW);
  return element;
}

Points SurfaceAssembler::load(const Vec3& f) const {
  Points F = Points::Zero(dofs_.count(), 3);
  for (int t = 0; t < mesh_.triangle_count(); ++t) {
    poll_every<4096>(t);
    const Vec12 element = unit_load(t);
    const auto dof = dofs_.triangle(mesh_, t);
    for (int a = 0; a < 12; ++a) F.row(dof[a]) += element[a] * f.transpose();
  }
  return F;
}

void SurfaceAssembler::check_weights(const VecX& triangle_weights) const {
  if (triangle_weights.size() != mesh_.triangle_count())
    throw InputError("found " + std::to_string(triangle_weights.size()) + " factors for " +
                     std::to_string(mesh_.triangle_count()) + " triangles, expected one for each");
}

VecX SurfaceAssembler::load(const VecX& triangle_weights) const {
  check_weights(triangle_weights);
  VecX F = VecX::Zero(dofs_.count());
  for (int t = 0; t < mesh_.triangle_count(); ++t) {
    poll_every<4096>(t);
    if (is_outside(t) || triangle_weights[t] == 0) continue;
    const Vec12 element = triangle_weights[t] * unit_load(t);
    const auto dof = dofs_.triangle(mesh_, t);
    for (int a = 0; a < 12; ++a) F[dof[a]] += element[a];
  }
  return F;
}

Points SurfaceAssembler::gather(const std::function<void(int, ElementLoad&)>& element) const {
  std::vector<ElementLoad> elements(mesh_.triangle_count());
  parallel_for_each<64>(mesh_.triangle_count(), [&](int t) {
    ElementLoad reference = ElementLoad::Zero();
    if (!is_outside(t)) element(t, reference);
    elements[t] = C1Triangle(kind_, shapes_[t]).pull_back_matrix().transpose() * reference;
  });
  Points F = Points::Zero(dofs_.count(), 3);
  for (int t = 0; t < mesh_.triangle_count(); ++t) {
    poll_every<16384>(t);
    const auto dof = dofs_.triangle(mesh_, t);
    for (int a = 0; a < 12; ++a) F.row(dof[a]) += elements[t].row(a);
  }
  return F;
}

Points SurfaceAssembler::load(const LoadField& f, int degree) const {
  const TabulatedRule whole(
      kind_, kind_ == TriangleElement::HCT ? split_triangle_rule(degree) : six_duffy_rule(5));
  return gather([&](int t, ElementLoad& reference) {
    std::optional<TabulatedRule> part;
    if (is_cut(t)) part.emplace(kind_, trim_->rule(t, std::max(degree, 3)));
    const TabulatedRule& points = part ? *part : whole;
    for (size_t p = 0; p < points.functions.size(); ++p) {
      const auto row = static_cast<long>(p);
      const Vec3 L = points.rule.L.row(row);
      const Vec3 value =
          shapes_[t].area * points.rule.weights[row] * f({t, L}, shapes_[t].point(L));
      reference += points.functions[p].col(0) * value.transpose();
    }
  });
}

SurfaceAssembler::ElementLoad SurfaceAssembler::reference_dofs(int t, const Points& q) const {
  ElementLoad local;
  const auto dof = dofs_.triangle(mesh_, t);
  for (int a = 0; a < 12; ++a) local.row(a) = q.row(dof[a]);
  return C1Triangle(kind_, shapes_[t]).pull_back_matrix() * local;
}

VecX SurfaceAssembler::area_load(const Surface& surface) const {
  const Points& q = surface.dofs();
  if (q.rows() != dofs_.count())
    throw InputError("found " + std::to_string(q.rows()) + " dofs of a surface, expected " +
                     std::to_string(dofs_.count()) + " of its mesh");
  const TabulatedRule& whole = pressure_functions(kind_);
  return gather([&](int t, ElementLoad& reference) {
           std::optional<TabulatedRule> part;
           if (is_cut(t)) part.emplace(kind_, trim_->rule(t, 8));
           const TabulatedRule& points = part ? *part : whole;
           const ElementLoad local = reference_dofs(t, q);
           for (size_t p = 0; p < points.functions.size(); ++p) {
             const auto& N = points.functions[p];
             const Vec3 x1 = local.transpose() * N.col(1), x2 = local.transpose() * N.col(2);
             reference.col(0) +=
                 0.5 * points.rule.weights[static_cast<long>(p)] * x1.cross(x2).norm() * N.col(0);
           }
         })
      .col(0);
}

Points SurfaceAssembler::pressure_load(const Points& q) const {
  const TabulatedRule& whole = pressure_functions(kind_);
  return gather([&](int t, ElementLoad& reference) {
    std::optional<TabulatedRule> part;
    if (is_cut(t)) part.emplace(kind_, trim_->rule(t, 7));
    const TabulatedRule& points = part ? *part : whole;
    const ElementLoad local = reference_dofs(t, q);
    // x_u × x_v times the area of the triangle is half of ∂1x × ∂2x: the determinant of the map is
    // 1/(2A).
    for (size_t p = 0; p < points.functions.size(); ++p) {
      const auto& N = points.functions[p];
      const Vec3 x1 = local.transpose() * N.col(1), x2 = local.transpose() * N.col(2);
      const Vec3 value = 0.5 * points.rule.weights[static_cast<long>(p)] * x1.cross(x2);
      reference += N.col(0) * value.transpose();
    }
  });
}

Points SurfaceAssembler::point_load(const Location& where, const Vec3& force) const {
  if (where.triangle < 0 || where.triangle >= mesh_.triangle_count())
    throw InputError("found a point load on triangle " + std::to_string(where.triangle) +
                     ", expected 0 to " + std::to_string(mesh_.triangle_count() - 1));
  Points F = Points::Zero(dofs_.count(), 3);
  const Vec12 N = C1Triangle(kind_, shapes_[where.triangle]).evaluate(where.L).col(kW);
  const auto dof = dofs_.triangle(mesh_, where.triangle);
  for (int a = 0; a < 12; ++a) F.row(dof[a]) += N[a] * force.transpose();
  return F;
}

namespace {

// The cubic of an element that contains a parameter of the curve.
struct Cubic {
  int triangle, sub;
  bool operator==(const Cubic&) const = default;
};

// Splits a curve at the borders of the cubics that it passes through.
class ElementCrossings {
 public:
  ElementCrossings(const ParametricMesh& mesh, TriangleElement kind, const TriangleLocator& locator,
                   const HermiteCurve& pcurve)
      : mesh_(mesh), kind_(kind), locator_(locator), pcurve_(pcurve) {}

  // Parameters of the samples, and those at which the cubic changes.
  std::vector<double> cut(const std::vector<double>& samples) const {
    std::vector<double> cuts{samples.front()};
    for (size_t i = 0; i + 1 < samples.size(); ++i) {
      poll_every<64>(static_cast<long>(i));
      double t = samples[i];
      Cubic here = at(t);
      while (t < samples[i + 1]) {
        double next = step_towards(samples[i + 1], t, here);
        Cubic there = at(next);
        if (!(there == here)) {
          const double left = bisect_end_of(here, t, next);
          if (left < next) {
            next = left;
            there = at(next);
          }
        }
        cuts.push_back(next);
        t = next;
        here = there;
      }
    }
    return cuts;
  }

 private:
  Cubic at(double t) const {
    const Location on = locator_.locate(drop_z(pcurve_.evaluate(t)));
    int sub = 0;
    if (kind_ == TriangleElement::HCT) on.L.minCoeff(&sub);
    return {on.triangle, sub};
  }

  // Step towards `end`, at most half of the current element.
  double step_towards(double end, double t, const Cubic& here) const {
    const double h = std::sqrt(2 * mesh_.shape(here.triangle).area),
                 speed = drop_z(pcurve_.evaluate(t, 1)).norm(), rest = end - t;
    const double steps = std::max(1.0, std::ceil(2 * speed * rest / h));
    return steps == 1 ? end : t + rest / steps;
  }

  double bisect_end_of(const Cubic& here, double low, double high) const {
    for (int step = 0; step < 60 && high - low > 1e-13 * (pcurve_.end() - pcurve_.start());
         ++step) {
      const double middle = 0.5 * (low + high);
      (at(middle) == here ? low : high) = middle;
    }
    return high;
  }

  const ParametricMesh& mesh_;
  TriangleElement kind_;
  const TriangleLocator& locator_;
  const HermiteCurve& pcurve_;
};

std::vector<double> merged_parameters(const HermiteCurve& pcurve, const HermiteCurve& curve) {
  std::vector<double> samples = pcurve.parameters();
  samples.insert(samples.end(), curve.parameters().begin(), curve.parameters().end());
  std::sort(samples.begin(), samples.end());
  samples.erase(std::unique(samples.begin(), samples.end()), samples.end());
  return samples;
}

}  // namespace

VecX line_load(const ParametricMesh& mesh, TriangleElement kind, const TriangleLocator& locator,
               const HermiteCurve& pcurve, const HermiteCurve& curve) {
  if (pcurve.start() != curve.start() || pcurve.end() != curve.end())
    throw InputError("line load: found a curve over [" + format_number(curve.start()) + ", " +
                     format_number(curve.end()) + "] with a parameter curve over [" +
                     format_number(pcurve.start()) + ", " + format_number(pcurve.end()) +
                     "], expected equal intervals");
  const std::vector<double> cuts =
      ElementCrossings(mesh, kind, locator, pcurve).cut(merged_parameters(pcurve, curve));

  static const SegmentRule gauss = gauss_legendre(6);
  const DofMap dofs(mesh);
  VecX F = VecX::Zero(dofs.count());
  // Near a vertex, the rational functions of Z12 vary on a scale below the element size.
  const int parts = kind == TriangleElement::HCT ? 1 : 8;
  for (size_t i = 0; i + 1 < cuts.size(); ++i) {
    poll_every<256>(static_cast<long>(i));
    for (long g = 0; g < parts * gauss.s.size(); ++g) {
      const double length = (cuts[i + 1] - cuts[i]) / parts,
                   t = cuts[i] +
                       (static_cast<double>(g / gauss.s.size()) + gauss.s[g % gauss.s.size()]) *
                           length;
      const Location on = locator.locate(drop_z(pcurve.evaluate(t)));
      const Vec12 N = C1Triangle(kind, mesh.shape(on.triangle)).evaluate(on.L).col(kW);
      const double weight =
          gauss.weights[g % gauss.s.size()] * length * curve.evaluate(t, 1).norm();
      const auto dof = dofs.triangle(mesh, on.triangle);
      for (int a = 0; a < 12; ++a) F[dof[a]] += weight * N[a];
    }
  }
  return F;
}

}  // namespace batten
