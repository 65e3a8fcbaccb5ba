// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/curve_assembler.h"

#include "batten/core/containers.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

std::vector<int> all_dofs(const CurveMesh& mesh) {
  std::vector<int> all;
  for (int s = 0; s < mesh.segment_count(); ++s)
    for (const int d : mesh.segment_dofs(s)) all.push_back(d);
  return all;
}

template <class Value>
void check_count(const std::vector<Value>& values, const CurveMesh& mesh) {
  if (values.size() != 1 && isize(values) != mesh.segment_count())
    throw InputError("found " + std::to_string(values.size()) + " coefficients for " +
                     std::to_string(mesh.segment_count()) +
                     " curve segments, expected one, or one for each");
}

template <class Value>
const Value& of(const std::vector<Value>& values, int segment) {
  return values[values.size() == 1 ? 0 : segment];
}

}  // namespace

CurveAssembler::CurveAssembler(CurveMesh mesh)
    : mesh_(std::move(mesh)), pattern_(mesh_.dof_count(), 4, all_dofs(mesh_)) {}

void CurveAssembler::stiffness(const Coefficient& alpha, const Coefficient& beta,
                               SparseMatrix& K) const {
  check_count(alpha, mesh_);
  check_count(beta, mesh_);
  pattern_.assemble(
      [&](int s, double* element) {
        const HermiteSegment segment(mesh_.length(s));
        Eigen::Map<HermiteSegment::Matrix>(element, 4, 4) =
            segment.stretching(of(alpha, s)) + segment.bending(of(beta, s));
      },
      K);
}

SparseMatrix CurveAssembler::stiffness(const Coefficient& alpha, const Coefficient& beta) const {
  SparseMatrix K = pattern();
  stiffness(alpha, beta, K);
  return K;
}

SparseMatrix CurveAssembler::mass(const std::vector<double>& weight) const {
  check_count(weight, mesh_);
  SparseMatrix M = pattern();
  pattern_.assemble(
      [&](int s, double* element) {
        Eigen::Map<HermiteSegment::Matrix>(element, 4, 4) =
            of(weight, s) * HermiteSegment(mesh_.length(s)).mass();
      },
      M);
  return M;
}

Points CurveAssembler::load(const Points& f) const {
  if (f.rows() != mesh_.segment_count() + 1)
    throw InputError("found " + std::to_string(f.rows()) + " load values for " +
                     std::to_string(mesh_.segment_count() + 1) +
                     " curve parameters, expected one for each");
  Points F = Points::Zero(mesh_.dof_count(), 3);
  for (int s = 0; s < mesh_.segment_count(); ++s) {
    const HermiteSegment segment(mesh_.length(s));
    const auto dof = mesh_.segment_dofs(s);
    for (int c = 0; c < 3; ++c) {
      const auto part = segment.load({f(s, c), f(s + 1, c)});
      for (int a = 0; a < 4; ++a) F(dof[a], c) += part[a];
    }
  }
  return F;
}

Points CurveAssembler::point_load(double u, const Vec3& force) const {
  const auto at = mesh_.locate(u);
  const auto H = HermiteSegment(mesh_.length(at.segment)).evaluate(at.s);
  const auto dof = mesh_.segment_dofs(at.segment);
  Points F = Points::Zero(mesh_.dof_count(), 3);
  for (int a = 0; a < 4; ++a) F.row(dof[a]) += H[a] * force.transpose();
  return F;
}

}  // namespace batten
