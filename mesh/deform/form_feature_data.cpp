// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/deform/form_feature_data.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {
namespace {

DeformProblem checked(DeformProblem problem, const TriangleMesh& mesh) {
  check(problem, mesh.vertex_count());
  return expand_to_nodes(std::move(problem), mesh.topology());
}

}  // namespace

FormFeatureData::FormFeatureData(const TriangleMesh& given, DeformProblem stated)
    : mesh(given),
      problem(checked(std::move(stated), mesh)),
      system(mesh, problem),
      positions(system.positions, AffineReduction::RhsMode::Deferred),
      rotations(system, static_cast<long>(problem.handles.size())),
      size(mesh.size()) {
  const auto dofs = static_cast<long>(system.vertex.size());
  const RowMatrix rows = reduced_matrix(system.A, positions);
  B = rows;
  extract_constrained_columns();
  const SparseMatrix N = normal_matrix(B, rows);
  parallel_for(2, [&](int part) {
    if (part == 1) {
      rotations.solve_weights(system, mesh);
      return;
    }
    if (positions.free_count() == 0) return;
    factor.analyze(N);
    if (!factor.factorize(N)) throw NoSolutionError("the deformation: " + factor.message());
  });

  couple_point_constraints();
  q = last_valid_q = Points::Zero(dofs, 3);
  rhs = MatX::Zero(static_cast<long>(system.values.size()), 3);
  g.resize(static_cast<long>(constraint_of_equation.size()));
  multipliers = VecX::Zero(g.size());
  b = r = system.base;
  load.resize(positions.free_count(), 3);
  y_rest.resize(positions.free_count(), 3);
  for (int i = 0; i < positions.free_count(); ++i)
    y_rest.row(i) = system.rest.row(system.vertex[positions.free_dofs()[i]]);
  y = y_rest;
  rest_rows = rows * y_rest;
  x.resize(dofs, 3);
  result = mesh.points();
}

void FormFeatureData::extract_constrained_columns() {
  const auto dofs = static_cast<long>(system.vertex.size());
  // d0 vanishes on the dofs that remain free.
  std::vector<char> is_constrained(dofs, 1);
  for (const int d : positions.free_dofs()) is_constrained[d] = 0;
  A_constrained_columns.resize(system.A.rows(), dofs);
  for (long i = 0; i < system.A.rows(); ++i) {
    A_constrained_columns.startVec(i);
    for (RowMatrix::InnerIterator a(system.A, i); a; ++a)
      if (is_constrained[a.col()]) A_constrained_columns.insertBack(i, a.col()) = a.value();
  }
  A_constrained_columns.finalize();
}

void FormFeatureData::couple_point_constraints() {
  const auto dofs = static_cast<long>(system.vertex.size());
  std::vector<SchurComplementConstraints::Constraint> coupled;
  std::vector<Triplet> combination;
  for (size_t k = 0; k < problem.point_constraints.size(); ++k) {
    const PointConstraint& constraint = problem.point_constraints[k];
    for (const auto& e : constraint.point.entries)
      combination.emplace_back(system.dof[e.vertex], static_cast<int>(k), e.coefficient);
    double coefficients = 0;
    for (const auto& e : constraint.point.entries) coefficients += e.coefficient * e.coefficient;
    coefficients = std::sqrt(coefficients);
    const Vec3 n = constraint.direction.normalized();
    if (constraint.kind == PointConstraint::Kind::OnPlane) {
      coupled.push_back({static_cast<int>(k), n, coefficients});
      constraint_of_equation.push_back(static_cast<int>(k));
    } else {
      const Vec3 l = n.unitOrthogonal(), m = n.cross(l);
      for (const Vec3& across : {l, m}) {
        coupled.push_back({static_cast<int>(k), across, coefficients});
        constraint_of_equation.push_back(static_cast<int>(k));
      }
    }
  }
  for (const auto& row : coupled) equation_directions.push_back(row.direction);
  if (!coupled.empty()) {
    SparseMatrix U(dofs, static_cast<long>(problem.point_constraints.size()));
    U.setFromTriplets(combination.begin(), combination.end());
    constrained_points = (SparseMatrix(positions.D().transpose()) * U).pruned();
    coupling = SchurComplementConstraints(factor, constrained_points, coupled);
  }
}

void FormFeatureData::add_point_equation(ConstraintSet& set, size_t k, double value) const {
  const PointConstraint& constraint = problem.point_constraints[constraint_of_equation[k]];
  std::vector<ConstraintSet::CoupledEntry> entries;
  for (const auto& e : constraint.point.entries)
    entries.push_back({system.dof[e.vertex], e.coefficient * equation_directions[k]});
  set.add_coupled(constraint.name, std::move(entries), value);
}

void FormFeatureData::start_residual() {
  const MatX& d0 = positions.d0();
  parallel_chunks(b.rows(), [&](long first, long last) {
    for (long i = first; i < last; ++i) {
      Eigen::RowVector3d sum = b.row(i) - rest_rows.row(i);
      for (RowMatrix::InnerIterator a(A_constrained_columns, i); a; ++a)
        sum -= a.value() * d0.row(a.col());
      r.row(i) = sum;
    }
  });
}

void FormFeatureData::reduce_residual() {
  parallel_chunks(B.cols(), [&](long first, long last) {
    for (long c = first; c < last; ++c) {
      Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
      for (SparseMatrix::InnerIterator e(B, c); e; ++e) sum += e.value() * r.row(e.row());
      load.row(c) = sum;
    }
  });
}

void FormFeatureData::apply_point_constraints() {
  coupling.apply(y, g);
  multipliers.setZero();
  coupling.add_multipliers(multipliers);
}

void FormFeatureData::expand(const DeformEdit& edit) {
  x.noalias() = positions.D() * y;
  x += positions.d0();
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    // Constrained vertices are exactly at their prescribed positions, to the last bit.
    if (const int h = system.constrained_by[v]; h == DeformSystem::kFree)
      result.row(v) = x.row(system.dof[v]) + system.origin.transpose();
    else if (h >= 0)
      result.row(v) = edit.handles[h](mesh.point(v));
  }
}

const Points& FormFeatureData::solve(const DeformEdit& edit) {
  start_residual();
  if (positions.free_count() > 0) {
    reduce_residual();
    factor.solve_in_place(load);
    y = y_rest + load;
    apply_point_constraints();
  }
  if (!y.allFinite() || !positions.d0().allFinite())
    throw NoSolutionError("the edit results in positions that are not finite");
  expand(edit);
  last_valid_q.swap(q);
  last = edit;
  solved = can_correct = true;
  return result;
}

// Right-hand sides of an edit: targets of rows, handles, features and point constraints.

namespace {

constexpr double kContradiction =
    1e-9;  // relative to the mesh size: larger residuals of point equations are conflicts

bool is_known(const ShapeEstimate& estimate, int vertex) {
  return estimate.known.empty() || estimate.known[vertex];
}

}  // namespace

double FormFeatureData::scale_of(const DeformEdit& edit, int scaled_by) const {
  if (scaled_by < 0) return 1;
  const auto features = isize(problem.features);
  if (scaled_by >= features) return edit.handles[scaled_by - features].scale;
  return edit.feature_scales.empty() ? 1 : edit.feature_scales[scaled_by];
}

Vec3 FormFeatureData::unrotated_target(const DeformEdit& edit, long row) const {
  const LinearConstraint& constraint = problem.rows[system.linear_constraint_of_row[row]];
  const Vec3 target =
      edit.targets.empty() ? constraint.target : edit.targets[system.linear_constraint_of_row[row]];
  return std::sqrt(*constraint.weight) * target;
}

bool FormFeatureData::estimated_target(const ShapeEstimate& estimate, long row,
                                       Vec3& target) const {
  if (row >= system.curvature_rows || estimate.use != ShapeEstimate::Use::Shape) return false;
  Vec3 sum = Vec3::Zero();
  for (RowMatrix::InnerIterator a(system.A, row); a; ++a) {
    const int v = system.vertex[a.col()];
    if (!is_known(estimate, v)) return false;
    sum += a.value() * (estimate.positions.row(v) - system.origin.transpose()).transpose();
  }
  target = sum;
  return true;
}

void FormFeatureData::set_targets(const DeformEdit& edit, const ShapeEstimate* estimate) {
  const bool is_identity = rotations.is_identity() && !estimate;
  parallel_chunks(b.rows(), [&](long first, long last) {
    for (long i = first; i < last; ++i) {
      Vec3 target = system.base.row(i).transpose();
      int scaled_by = system.scaled_by[i];
      if (estimate && estimated_target(*estimate, i, target)) {
        if (scaled_by >= isize(problem.features))
          scaled_by = -1;  // the estimate already contains
                           // the scale of handles
      } else {
        if (system.linear_constraint_of_row[i] >= 0) target = unrotated_target(edit, i);
        const int rotates_with = system.rotates_with[i];
        if (!is_identity && rotates_with >= 0)
          target = rotated(rotation_vector_at(rotates_with), target);
      }
      if (system.linear_constraint_of_row[i] >= 0) {
        // Positions are relative to the origin.
        double sum = 0;
        for (RowMatrix::InnerIterator a(system.A, i); a; ++a) sum += a.value();
        target -= sum * system.origin;
      }
      b.row(i) = scale_of(edit, scaled_by) * target.transpose();
    }
  });
}

void FormFeatureData::check_estimate(const ShapeEstimate& e) const {
  const auto fits = [](const char* what, size_t found, size_t expected) {
    if (found != expected)
      throw InputError("the estimate has " + std::to_string(found) + " " + what + ", expected " +
                       std::to_string(expected));
  };
  fits("positions", static_cast<size_t>(e.positions.rows()),
       static_cast<size_t>(mesh.vertex_count()));
  if (!e.known.empty())
    fits("known vertices", e.known.size(), static_cast<size_t>(mesh.vertex_count()));
  if (!e.feature_rotations.empty())
    fits("rotations of features", e.feature_rotations.size(), problem.features.size());
  if (!e.positions.allFinite()) throw InputError("the estimate has a position that is not finite");
}

Vec3 FormFeatureData::ring_rotation_vector(const ShapeEstimate& estimate, int dof) const {
  const MeshTopology& topology = mesh.topology();
  std::vector<int> ring{system.vertex[dof]};
  for (const int v : topology.coincident_vertices(system.vertex[dof]))
    ring.insert(ring.end(), topology.neighbours(v).begin(), topology.neighbours(v).end());
  return to_rotation_vector(rotation_of_face(ring, mesh.points(), estimate.positions));
}

void FormFeatureData::apply_estimated_rotations(const ShapeEstimate& estimate) {
  std::vector<std::pair<int, Vec3>> given;
  rotated_features.clear();
  for (size_t f = 0; f < estimate.feature_rotations.size(); ++f)
    if (estimate.feature_rotations[f]) {
      given.emplace_back(system.feature_dof[f], to_rotation_vector(*estimate.feature_rotations[f]));
      rotated_features.push_back(static_cast<int>(f));
    }
  rotations.prescribe(system, mesh, given, q);
  if (estimate.use == ShapeEstimate::Use::Rotations) return;
  // Chains and linear constraints rotate with the estimated shape, like everything else.
  for (long i = system.curvature_rows; i < b.rows(); ++i)
    if (const int d = system.rotates_with[i];
        d >= 0 && is_known(estimate, system.vertex[d]) &&
        system.constrained_by[system.vertex[d]] == DeformSystem::kFree)
      q.row(d) = ring_rotation_vector(estimate, d);
}

void FormFeatureData::set_hard_values(const DeformEdit& edit) {
  using Kind = DeformSystem::Value::Kind;
  for (size_t k = 0; k < system.values.size(); ++k) {
    const auto& value = system.values[k];
    Vec3 d;
    if (value.kind == Kind::Fixed) {
      d = system.rest.row(value.vertex);
    } else if (value.kind == Kind::Handle) {
      d = edit.handles[value.source](mesh.point(value.vertex)) - system.origin;
    } else if (value.kind == Kind::Feature) {
      d = scale_of(edit, value.source) *
          rotated(rotation_vector_at(system.feature_dof[value.source]),
                  (system.rest.row(value.vertex) - system.rest.row(value.reference)).transpose());
    } else if (value.kind == Kind::CoincidentVertices) {
      d = Vec3::Zero();
    } else {
      const LinearConstraint& row = problem.rows[value.source];
      d = edit.targets.empty() ? row.target : edit.targets[value.source];
      if (row.rotates_with >= 0) d = rotated(rotation_vector_at(system.dof[row.rotates_with]), d);
      double sum = 0;
      for (const auto& e : row.combination.entries) sum += e.coefficient;
      d -= sum * system.origin;
    }
    rhs.row(static_cast<long>(k)) = d;
  }
  positions.set_rhs(rhs);
}

void FormFeatureData::set_point_constraints(const DeformEdit& edit) {
  for (size_t k = 0; k < constraint_of_equation.size(); ++k) {
    double reached = equation_directions[k].dot(constraint_origin(edit, k));
    for (const auto& e : problem.point_constraints[constraint_of_equation[k]].point.entries)
      reached -=
          e.coefficient * equation_directions[k].dot(positions.d0().row(system.dof[e.vertex]));
    g[static_cast<long>(k)] = reached;
  }
  const auto [missed, row] = coupling.contradiction(g);
  if (!(missed > kContradiction * size)) return;
  // Eliminating all rows together finds and names the constraints that contradict each other.
  ConstraintSet all = system.positions;
  for (size_t k = 0; k < constraint_of_equation.size(); ++k) add_point_equation(all, k, 0);
  AffineReduction named(all, AffineReduction::RhsMode::Deferred);
  MatX stacked(3 * rhs.rows() + g.size(), 1);
  for (long k = 0; k < rhs.rows(); ++k) stacked.block<3, 1>(3 * k, 0) = rhs.row(k).transpose();
  for (size_t k = 0; k < constraint_of_equation.size(); ++k)
    stacked(3 * rhs.rows() + static_cast<long>(k), 0) =
        equation_directions[k].dot(constraint_origin(edit, k));
  named.set_rhs(stacked);
  throw ConflictError({{{problem.point_constraints[constraint_of_equation[row]].name}, missed}});
}

}  // namespace batten
