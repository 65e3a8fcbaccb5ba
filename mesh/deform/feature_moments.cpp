// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/deform/feature_moments.h"

#include <algorithm>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/mesh/deform/form_feature_data.h"

namespace batten {
namespace {

constexpr int kProbes = 256;      // largest number of groups of bodies that rotate in turn
constexpr int kProbesAtOnce = 9;  // right-hand sides of one solve: three per probe

/// A sum of vectors at few of many indices.
class SparseSum {
 public:
  explicit SparseSum(long size) : at_(size, -1) {}
  void add(long index, const Vec3& value) {
    if (at_[index] < 0) {
      at_[index] = isize(entries_);
      entries_.emplace_back(index, Vec3::Zero());
    }
    entries_[at_[index]].second += value;
  }
  /// The indices with their sums, ascending; the sum is empty afterwards.
  std::vector<std::pair<long, Vec3>> take() {
    for (const auto& [index, value] : entries_) at_[index] = -1;
    std::sort(entries_.begin(), entries_.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    return std::exchange(entries_, {});
  }

 private:
  std::vector<int> at_;
  std::vector<std::pair<long, Vec3>> entries_;
};

}  // namespace

FeatureMoments::FeatureMoments(const FormFeatureData& data)
    : of_rows_(data.problem.features.size()),
      of_equations_(data.problem.features.size()),
      tensors_(Points::Zero(3L * isize(data.problem.features), 3)) {
  const DeformSystem& system = data.system;
  std::vector<std::vector<long>> values(of_rows_.size());  // right-hand sides of each feature
  for (size_t k = 0; k < system.values.size(); ++k)
    if (system.values[k].kind == DeformSystem::Value::Kind::Feature)
      values[system.values[k].source].push_back(static_cast<long>(k));
  const SparseMatrix columns = system.A;
  const SparseMatrix& particular = data.positions.rhs_to_particular();
  SparseSum displacements(columns.cols()), rows(columns.rows());
  std::vector<Vec3> displacement(columns.cols(), Vec3::Zero());
  std::vector<int> unknown(columns.cols(), -1);
  for (int c = 0; c < data.positions.free_count(); ++c) unknown[data.positions.free_dofs()[c]] = c;
  const SparseMatrix& D = data.positions.D();
  for (size_t f = 0; f < values.size(); ++f) {
    Vec3 sum = Vec3::Zero();
    for (const long k : values[f]) {
      const auto& value = system.values[k];
      const Vec3 arm =
          (system.rest.row(value.vertex) - system.rest.row(value.reference)).transpose();
      sum += arm;
      for (SparseMatrix::InnerIterator t(particular, k); t; ++t)
        displacements.add(t.row(), t.value() * arm);
    }
    // Rotations about the mean of the vertices: forces of stiff springs at it have no lever, whose
    // rounding errors would be large.
    if (const int c = unknown[system.feature_dof[f]]; c >= 0 && !values[f].empty()) {
      const Vec3 mean = sum / static_cast<double>(values[f].size() + 1);
      for (SparseMatrix::InnerIterator t(D, c); t; ++t)
        displacements.add(t.row(), -t.value() * mean);
    }
    const auto moved = displacements.take();
    for (const auto& [dof, arm] : moved) {
      displacement[dof] = arm;
      for (SparseMatrix::InnerIterator a(columns, dof); a; ++a) rows.add(a.row(), a.value() * arm);
    }
    for (const auto& [row, arm] : rows.take()) of_rows_[f].push_back({row, arm});
    for (size_t e = 0; e < data.constraint_of_equation.size(); ++e) {
      Vec3 arm = Vec3::Zero();
      for (const auto& entry :
           data.problem.point_constraints[data.constraint_of_equation[e]].point.entries)
        arm += entry.coefficient * displacement[system.dof[entry.vertex]];
      if (!arm.isZero(0)) of_equations_[f].push_back({static_cast<long>(e), arm});
    }
    for (const auto& [dof, arm] : moved) displacement[dof].setZero();
  }
}

const Points& FeatureMoments::evaluate(const FormFeatureData& d) {
  parallel_for_each<8>(isize(of_rows_), [&](int f) {
    Mat3 sum = Mat3::Zero();
    for (const auto& [row, arm] : of_rows_[f]) {
      Vec3 force = -d.b.row(row).transpose();
      for (RowMatrix::InnerIterator a(d.system.A, row); a; ++a)
        force += a.value() * d.x.row(a.col()).transpose();
      sum += arm * force.transpose();
    }
    for (const auto& [equation, arm] : of_equations_[f])
      sum += arm * (d.multipliers[equation] * d.equation_directions[equation]).transpose();
    const Vec3 log = d.last_valid_q.row(d.system.feature_dof[f]).transpose();
    tensors_.middleRows<3>(3L * f) = d.scale_of(d.last, f) * rotation_matrix(log) * sum;
  });
  return tensors_;
}

namespace {

/// The inverse of the compliance of the point constraints: forces that move their points by units.
MatX stiffness_of_constraints(const FormFeatureData& d) {
  MatX H(d.g.size(), d.g.size());
  for (long k = 0; k < H.cols(); ++k) {
    MatX y = MatX::Zero(d.positions.free_count(), 3);
    d.coupling.apply(y, -VecX::Unit(H.cols(), k));
    VecX forces = VecX::Zero(H.rows());
    d.coupling.add_multipliers(forces);
    H.col(k) = forces;
  }
  return H;
}

}  // namespace

FeatureStiffness FeatureMoments::stiffness(FormFeatureData& d, std::span<const int> body) const {
  const int bodies =
      body.empty() ? 0 : std::max(0, 1 + *std::max_element(body.begin(), body.end()));
  const bool full = bodies <= kProbes;
  const int probes = std::min(bodies, kProbes);
  const long equations = d.g.size();
  FeatureStiffness result{MatX::Zero(3L * bodies, full ? 3L * bodies : 3),
                          MatX::Zero(3L * bodies, equations),
                          {},
                          stiffness_of_constraints(d),
                          d.equation_directions};
  for (size_t f = 0; f < body.size(); ++f)
    for (const auto& [equation, arm] : of_equations_[f])
      if (body[f] >= 0)
        result.v.block<3, 1>(3L * body[f], equation) +=
            d.scale_of(d.last, static_cast<int>(f)) * arm;
  result.w = result.v;
  add_forces(d, body, result.w);
  for (int first = 0; first < probes; first += kProbesAtOnce) {
    const int count = std::min(kProbesAtOnce, probes - first);
    const Response found = response(d, body, first, count);
    for (size_t f = 0; f < body.size(); ++f)
      for (int k = 0; k < count && body[f] >= 0; ++k) {
        if (!full && body[f] % kProbes != first + k) continue;  // the probe rotates other bodies
        auto block = result.S.block<3, 3>(3L * body[f], full ? 3L * (first + k) : 0);
        const double scale = d.scale_of(d.last, static_cast<int>(f));
        for (const auto& [row, arm] : of_rows_[f])
          block += scale * arm * found.residuals.row(row).segment<3>(3L * k);
      }
    for (int b = 0; b < bodies; ++b)
      if (const int k = b % kProbes - first; k >= 0 && k < count)
        for (long e = 0; e < equations; ++e)
          result.v.block<3, 1>(3L * b, e) +=
              found.points.block<1, 3>(d.constraint_of_equation[e], 3L * k).transpose();
  }
  return result;
}

// Unit forces at the constrained points move the free unknowns by -N⁻¹ Dᵀ U.
void FeatureMoments::add_forces(FormFeatureData& d, std::span<const int> body, MatX& w) const {
  if (d.constrained_points.cols() == 0) return;
  MatX y = d.constrained_points;
  d.factor.solve_in_place(y);
  const MatX residuals = d.B * y;
  for (size_t f = 0; f < body.size(); ++f)
    for (long e = 0; e < w.cols() && body[f] >= 0; ++e) {
      Vec3 sum = Vec3::Zero();
      for (const auto& [row, arm] : of_rows_[f])
        sum += residuals(row, d.constraint_of_equation[e]) * arm;
      w.block<3, 1>(3L * body[f], e) -= d.scale_of(d.last, static_cast<int>(f)) * sum;
    }
}

// The residuals of the rows if body h rotates by ω are Σ_j r_hj (ω × e_j), with the residuals r_hj of
// three right-hand sides: the lever c_h and the base times the weight of h in the rotation field,
// both times e_j. So are the movements of the constrained points.
FeatureMoments::Response FeatureMoments::response(FormFeatureData& d, std::span<const int> body,
                                                  int first, int count) const {
  const auto probe = [&](int f) { return body[f] < 0 ? -1 : body[f] % kProbes - first; };
  const long rows = d.system.A.rows();
  Response result{RowMajor::Zero(rows, 3L * count),
                  MatX::Zero(d.constrained_points.cols(), 3L * count)};
  RowMajor& r = result.residuals;
  std::vector<std::pair<int, Vec3>> rotations;
  for (int p = 0; p < count; p += 3) {  // a rotation vector is the weight of three probes
    rotations.clear();
    for (const int f : d.rotated_features)
      rotations.emplace_back(d.system.feature_dof[f], probe(f) >= p && probe(f) < p + 3
                                                          ? Vec3(Vec3::Unit(probe(f) - p))
                                                          : Vec3(Vec3::Zero()));
    Points weights = Points::Zero(isize(d.system.vertex), 3);
    d.rotations.prescribe(d.system, d.mesh, rotations, weights);
    parallel_chunks(rows, [&](long begin, long end) {
      for (long i = begin; i < end; ++i)
        if (const int dof = d.system.rotates_with[i]; dof >= 0)
          for (int k = p; k < std::min(p + 3, count); ++k)
            r.row(i).segment<3>(3L * k) = -weights(dof, k - p) *
                                          d.scale_of(d.last, d.system.scaled_by[i]) *
                                          d.system.base.row(i);
    });
  }
  for (int f = 0; f < isize(body); ++f)
    if (const int k = probe(f); k >= 0 && k < count)
      for (const auto& [row, arm] : of_rows_[f])
        r.row(row).segment<3>(3L * k) += d.scale_of(d.last, f) * arm.transpose();
  if (d.positions.free_count() == 0) return result;
  MatX y = d.B.transpose() * r;
  d.factor.solve_in_place(y);
  r -= d.B * y;
  if (d.constrained_points.cols() > 0) result.points = -(d.constrained_points.transpose() * y);
  return result;
}

}  // namespace batten
