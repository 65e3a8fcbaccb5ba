#include "batten/mesh/deform/form_feature_deformer.h"

#include <cmath>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/core/parallel.h"
#include "batten/core/parallel_chunks.h"
#include "batten/mesh/deform/form_feature_data.h"
#include "batten/mesh/deform/normal_equations.h"

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
  // d0 vanishes on dofs that stay free.
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
    SparseMatrix reduced = SparseMatrix(positions.D().transpose()) * U;
    coupling = SchurComplementConstraints(factor, reduced.pruned(), coupled);
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

void FormFeatureData::expand(const DeformEdit& edit) {
  x.noalias() = positions.D() * y;
  x += positions.d0();
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    // What is held is where it was told to be, to the last bit.
    if (const int h = system.constrained_by[v]; h == DeformSystem::kFree)
      result.row(v) = x.row(system.dof[v]) + system.origin.transpose();
    else if (h >= 0)
      result.row(v) = edit.handles[h](mesh.point(v));
  }
}

FormFeatureDeformer::FormFeatureDeformer(const TriangleMesh& mesh, DeformProblem problem)
    : data_(std::make_unique<FormFeatureData>(mesh, std::move(problem))) {}
FormFeatureDeformer::~FormFeatureDeformer() = default;
FormFeatureDeformer::FormFeatureDeformer(FormFeatureDeformer&&) noexcept = default;
FormFeatureDeformer& FormFeatureDeformer::operator=(FormFeatureDeformer&&) noexcept = default;

const Points& FormFeatureDeformer::deform(const DeformEdit& edit) {
  FormFeatureData& d = *data_;
  check(d.problem, edit);
  d.can_correct = false;
  d.rotations.evaluate(d.system, edit, d.q);
  d.set_hard_values(edit);
  d.set_point_constraints(edit);
  d.set_targets(edit, nullptr);
  return d.solve(edit);
}

const Points& FormFeatureDeformer::deform(const DeformEdit& edit, const ShapeEstimate& estimate) {
  FormFeatureData& d = *data_;
  check(d.problem, edit);
  d.check_estimate(estimate);
  d.can_correct = false;
  d.rotations.evaluate(d.system, edit, d.q);
  d.apply_estimated_rotations(estimate);
  d.set_hard_values(edit);
  d.set_point_constraints(edit);
  d.set_targets(edit, &estimate);
  return d.solve(edit);
}

const Points& FormFeatureData::solve(const DeformEdit& edit) {
  start_residual();
  if (positions.free_count() > 0) {
    reduce_residual();
    factor.solve_in_place(load);
    y = y_rest + load;
    coupling.apply(y, g);
  }
  if (!y.allFinite() || !positions.d0().allFinite())
    throw NoSolutionError("the edit leads to positions that are not finite");
  expand(edit);
  last_valid_q.swap(q);
  last = edit;
  solved = can_correct = true;
  return result;
}

double FormFeatureDeformer::correct() {
  FormFeatureData& d = *data_;
  if (!d.can_correct) throw InputError("there is no edit to correct, expected deform() before");
  if (d.positions.free_count() == 0 || d.size == 0) return 0;
  // What is left of b - A x, in the rows' own accuracy.
  d.start_residual();
  for (long c = 0; c < d.B.cols(); ++c)
    for (SparseMatrix::InnerIterator e(d.B, c); e; ++e)
      d.r.row(e.row()) -= e.value() * (d.y.row(c) - d.y_rest.row(c));
  d.reduce_residual();
  d.factor.solve_in_place(d.load);
  d.y += d.load;
  d.coupling.apply(d.y, d.g);
  const Points before = d.result;
  d.expand(d.last);
  return (d.result - before).cwiseAbs().maxCoeff() / d.size;
}

const Points& FormFeatureDeformer::positions() const { return data_->result; }
const TriangleMesh& FormFeatureDeformer::mesh() const { return data_->mesh; }
const DeformProblem& FormFeatureDeformer::problem() const { return data_->problem; }
const std::vector<std::string>& FormFeatureDeformer::notes() const { return data_->system.notes; }

Points FormFeatureDeformer::rotation_logs() const {
  const FormFeatureData& d = *data_;
  Points q = Points::Zero(d.mesh.vertex_count(), 3);
  for (int v = 0; v < d.mesh.vertex_count(); ++v)
    if (const int dof = d.system.dof[v]; dof >= 0)
      q.row(v) = d.last_valid_q.row(dof);
    else if (const int h = d.system.constrained_by[v]; h >= 0 && d.solved)
      q.row(v) = d.last.handles[h].rotation_vector;
  return q;
}

double FormFeatureDeformer::hard_residual() const {
  const FormFeatureData& d = *data_;
  return d.solved ? batten::hard_residual(d.mesh, d.problem, d.last, d.result, rotation_logs()) : 0;
}

FormFeatureDeformer::Counts FormFeatureDeformer::counts() const {
  const FormFeatureData& d = *data_;
  Counts c;
  c.moving = d.system.moving;
  c.unknowns = d.positions.free_count();
  c.soft_equations = static_cast<int>(d.system.A.rows());
  c.hard_constraints = isize(d.system.values);
  c.feature_constraints = d.system.feature_constraints;
  c.redundant_count = d.positions.redundant_count();
  c.point_equations = isize(d.constraint_of_equation);
  c.factor_entries = d.positions.free_count() > 0 ? d.factor.factor_entries() : 0;
  return c;
}

FormFeatureDeformer::ProblemMatrices FormFeatureDeformer::problem_matrices(const DeformEdit& edit) {
  deform(edit);
  const FormFeatureData& d = *data_;
  ProblemMatrices s{d.system.vertex, d.system.origin, d.system.A, d.b,
                    ConstraintSet(isize(d.system.vertex))};
  const auto& rows = d.system.positions.constraints();
  std::vector<char> implied(rows.size(), 0);
  for (const int k : d.positions.redundant()) implied[k] = 1;
  for (size_t k = 0; k < rows.size(); ++k)
    if (!implied[k])
      s.constraints.add(d.system.positions.names()[rows[k].name], rows[k].entries,
                        d.rhs.row(static_cast<long>(k)).transpose());
  for (const int k : d.coupling.independent())
    d.add_point_equation(s.constraints, static_cast<size_t>(k),
                         d.equation_directions[k].dot(d.constraint_origin(edit, k)));
  return s;
}

}  // namespace batten
