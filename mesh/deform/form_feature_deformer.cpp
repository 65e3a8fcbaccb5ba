// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/deform/form_feature_deformer.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "batten/constraints/affine_reduction.h"
#include "batten/constraints/schur_complement_constraints.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/mesh/deform/deform_system.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {

// Implementation of FormFeatureDeformer.

// The smooth rotation field that rotates the curvature vectors.

/// The logarithms of the rotations are harmonic and linear in the handle rotations. The weights of
/// each handle are therefore computed once, and an edit needs no solve.
class RotationField {
 public:
  RotationField(const DeformSystem& system, long handles);

  /// Computes the weights with one factorization. Throws NoSolutionError.
  void solve_weights(const DeformSystem& system, const TriangleMesh& mesh);

  /// Logarithms for an edit (dofs × 3), Σ weights · handle rotations. Does not allocate. Throws
  /// ConflictError if redundant rows contradict each other.
  void evaluate(const DeformSystem& system, const DeformEdit& edit, Points& logs);

  /// Modifies the logs of evaluate(): given dofs, and all that rotate with them, get prescribed
  /// values, and the rest is harmonic in between. Costs one factorization per set of dofs. Values
  /// from handles and fixed vertices are unchanged. Throws NoSolutionError.
  void prescribe(const DeformSystem& system, const TriangleMesh& mesh,
                 const std::vector<std::pair<int, Vec3>>& given, Points& logs);

  /// Rates of the logarithms for rates of the handle rotations (handles × 3).
  Points rates(const MatX& handle_rates) const { return weights_ * handle_rates; }
  /// Transpose of rates(): handles × 3.
  MatX transposed_rates(const Points& logs) const { return weights_.transpose() * logs; }

  /// True if no handle rotated in the last edit.
  bool is_identity() const { return handle_rotations_.isZero(0); }

 private:
  void factorize_free(const DeformSystem& system, const TriangleMesh& mesh,
                      std::vector<int> prescribed);

  AffineReduction reduction_;
  MatX weights_;           // dofs × handles
  MatX handle_rotations_;  // handles × 3
  MatX rhs_;               // right-hand sides of the rows
  // Data of prescribe(): the unknown of each dof (rotations are only equated), or -1; the prescribed
  // unknowns; the index of each unknown among the others, or -1 minus its index in prescribed_; the
  // factor of the Laplacian of the others, and its negative coupling with the prescribed ones.
  std::vector<int> unknown_of_dof_, prescribed_, index_;
  SparseMatrix coupling_;
  SparseCholesky free_factor_;
  MatX change_, load_;
};

struct FormFeatureData {
  FormFeatureData(const TriangleMesh& mesh, DeformProblem problem);

  void extract_constrained_columns();
  void couple_point_constraints();
  void set_targets(const DeformEdit& edit, const ShapeEstimate* estimate);
  /// Target of a LinearConstraint row before it is rotated.
  Vec3 unrotated_target(const DeformEdit& edit, long row) const;
  /// Curvature in the estimate. Returns false if the estimate does not know all vertices of the
  /// row.
  bool estimated_target(const ShapeEstimate& estimate, long row, Vec3& target) const;
  /// Best rotation of the one-ring of a dof in the estimate.
  Vec3 ring_rotation_vector(const ShapeEstimate& estimate, int dof) const;
  /// Applies the rotations of features and, with Use::Shape, of chains and linear constraints from
  /// the estimate.
  void apply_estimated_rotations(const ShapeEstimate& estimate);
  void check_estimate(const ShapeEstimate& estimate) const;
  /// Solves with the hard values, point constraints and targets that are currently set.
  const Points& solve(const DeformEdit& edit);
  void set_hard_values(const DeformEdit& edit);
  void set_point_constraints(const DeformEdit& edit);
  void expand(const DeformEdit& edit);
  double scale_of(const DeformEdit& edit, int scaled_by) const;
  /// Target of point equation k, relative to the origin; a vector is not shifted.
  Vec3 constraint_origin(const DeformEdit& edit, size_t k) const {
    const VertexCombination& point = problem.point_constraints[constraint_of_equation[k]].point;
    const Vec3 place = edit.constraint_origins.empty()
                           ? point.at(mesh.points())
                           : edit.constraint_origins[constraint_of_equation[k]];
    return std::abs(point.sum()) < 0.5 ? place : Vec3(place - system.origin);
  }
  void add_point_equation(ConstraintSet& set, size_t k, double value) const;
  /// r = b - A x, with x the shape that has the free unknowns at rest. The solution, and its
  /// rounding errors, are then changes of the shape.
  void start_residual();
  /// load = Bᵀ r.
  void reduce_residual();
  Vec3 rotation_vector_at(int dof) const { return q.row(dof).transpose(); }

  TriangleMesh mesh;
  DeformProblem problem;
  DeformSystem system;
  AffineReduction positions;
  RotationField rotations;
  SparseMatrix B;                   // A D
  RowMatrix A_constrained_columns;  // columns of A where d0 may be nonzero
  SparseCholesky factor;
  SchurComplementConstraints coupling;
  std::vector<Vec3> equation_directions;    // direction of each point equation
  std::vector<int> constraint_of_equation;  // point constraint of each point equation
  double size;

  Points q, last_valid_q;     // logarithms, dofs × 3, of this edit and of the last successful one
  MatX rhs;                   // right-hand sides of the hard constraints
  VecX g;                     // right-hand sides of the point equations
  RowPoints b, r, rest_rows;  // rest_rows = B y_rest
  MatX y, y_rest, load, x;
  Points result;
  DeformEdit last;
  bool solved = false;        // result is the solution for `last`
  bool is_estimated = false;  // guided by an estimate
  bool can_correct = false;   // and y, b, d0 belong to it
};

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
    // Constrained vertices are exactly at their prescribed positions, to the last bit.
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
  d.is_estimated = false;
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
  d.is_estimated = true;
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
    throw NoSolutionError("the edit results in positions that are not finite");
  expand(edit);
  last_valid_q.swap(q);
  last = edit;
  solved = can_correct = true;
  return result;
}

double FormFeatureDeformer::correct() {
  FormFeatureData& d = *data_;
  if (!d.can_correct) throw InputError("correct() without an edit: call deform() first");
  if (d.positions.free_count() == 0 || d.size == 0) return 0;
  // Residual b - A x, computed with the accuracy of the original rows.
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
  for (size_t f = 0; f < estimate.feature_rotations.size(); ++f)
    if (estimate.feature_rotations[f])
      given.emplace_back(system.feature_dof[f], to_rotation_vector(*estimate.feature_rotations[f]));
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

RotationField::RotationField(const DeformSystem& system, long handles)
    : reduction_(system.rotations, AffineReduction::RhsMode::Deferred),
      handle_rotations_(MatX::Zero(handles, 3)),
      rhs_(MatX::Zero(static_cast<long>(system.rotated_by.size()), 3)) {}

// Weights: 1 on the own vertices of a handle, 0 on all other constrained ones, harmonic in between.
void RotationField::solve_weights(const DeformSystem& system, const TriangleMesh& mesh) {
  const long handles = handle_rotations_.rows();
  MatX indicator = MatX::Zero(static_cast<long>(system.rotated_by.size()), handles);
  for (size_t r = 0; r < system.rotated_by.size(); ++r)
    if (system.rotated_by[r] >= 0) indicator(static_cast<long>(r), system.rotated_by[r]) = 1;
  weights_ = reduction_.particular_solution(indicator);
  if (reduction_.free_count() == 0 || handles == 0) return;
  const SparseMatrix L = laplacian_of(system, mesh);
  const SparseMatrix reduced = reduction_.reduce(L);
  SparseCholesky factor;
  factor.analyze(reduced);
  if (!factor.factorize(reduced)) throw NoSolutionError("the rotation field: " + factor.message());
  MatX load = reduction_.D().transpose() * MatX(L.selfadjointView<Eigen::Lower>() * -weights_);
  factor.solve_in_place(load);
  weights_.noalias() += reduction_.D() * load;
}

void RotationField::evaluate(const DeformSystem& system, const DeformEdit& edit, Points& logs) {
  for (size_t h = 0; h < edit.handles.size(); ++h)
    handle_rotations_.row(static_cast<long>(h)) = edit.handles[h].rotation_vector;
  if (reduction_.redundant_count() > 0) {  // only redundant rows can be contradicted
    for (size_t k = 0; k < system.rotated_by.size(); ++k)
      if (const int h = system.rotated_by[k]; h >= 0)
        rhs_.row(static_cast<long>(k)) = handle_rotations_.row(h);
    try {
      reduction_.set_rhs(rhs_);
    } catch (const ConflictError& e) {
      std::vector<ConflictError::Conflict> conflicts = e.conflicts();
      for (auto& c : conflicts) {
        c.amount *= 180 / std::numbers::pi;
        c.unit = " degrees of rotation";
      }
      throw ConflictError(std::move(conflicts));
    }
  }
  // Explicit loop: Eigen's product may allocate.
  parallel_chunks(logs.rows(), [&](long first, long last) {
    for (int c = 0; c < 3; ++c) {
      auto column = logs.col(c).segment(first, last - first);
      column.setZero();
      for (long h = 0; h < handle_rotations_.rows(); ++h)
        if (handle_rotations_(h, c) != 0)
          column += handle_rotations_(h, c) * weights_.col(h).segment(first, last - first);
    }
  });
}

void RotationField::factorize_free(const DeformSystem& system, const TriangleMesh& mesh,
                                   std::vector<int> prescribed) {
  if (prescribed == prescribed_ && !index_.empty()) return;
  index_.assign(static_cast<size_t>(reduction_.free_count()), 0);  // of the others: below
  for (int k = 0; k < isize(prescribed); ++k) index_[prescribed[k]] = -1 - k;
  int open = 0;
  for (int& index : index_)
    if (index >= 0) index = open++;
  const SparseMatrix reduced = reduction_.reduce(laplacian_of(system, mesh));  // lower triangle
  std::vector<Triplet> entries, coupled;
  for (int c = 0; c < reduced.cols(); ++c)
    for (SparseMatrix::InnerIterator e(reduced, c); e; ++e) {
      const int i = index_[e.row()], j = index_[c];
      if (i >= 0 && j >= 0) entries.emplace_back(i, j, e.value());
      if (i >= 0 && j < 0) coupled.emplace_back(i, -1 - j, -e.value());
      if (i < 0 && j >= 0) coupled.emplace_back(j, -1 - i, -e.value());
    }
  coupling_ = SparseMatrix(open, isize(prescribed));
  coupling_.setFromTriplets(coupled.begin(), coupled.end());
  change_ = MatX::Zero(isize(prescribed), 3);
  load_ = MatX::Zero(open, 3);
  prescribed_ = std::move(prescribed);
  if (open == 0) return;
  SparseMatrix rest(open, open);
  rest.setFromTriplets(entries.begin(), entries.end());
  free_factor_.analyze(rest);
  if (free_factor_.factorize(rest)) return;
  index_.clear();  // invalid
  throw NoSolutionError("the rotation field: " + free_factor_.message());
}

void RotationField::prescribe(const DeformSystem& system, const TriangleMesh& mesh,
                              const std::vector<std::pair<int, Vec3>>& given, Points& logs) {
  if (unknown_of_dof_.empty()) {
    unknown_of_dof_.assign(static_cast<size_t>(logs.rows()), -1);
    const SparseMatrix& D = reduction_.D();
    for (int c = 0; c < D.cols(); ++c)
      for (SparseMatrix::InnerIterator e(D, c); e; ++e) unknown_of_dof_[e.row()] = c;
  }
  std::vector<int> prescribed;
  for (const auto& [dof, log] : given)
    if (unknown_of_dof_[dof] >= 0) prescribed.push_back(unknown_of_dof_[dof]);
  factorize_free(system, mesh, sorted_unique(std::move(prescribed)));
  std::vector<char> is_set(prescribed_.size(), 0);  // the first value of an unknown applies
  for (const auto& [dof, log] : given) {
    if (unknown_of_dof_[dof] < 0) continue;
    const int k = -1 - index_[unknown_of_dof_[dof]];
    if (std::exchange(is_set[k], 1) == 0) change_.row(k) = log.transpose() - logs.row(dof);
  }
  load_.noalias() = coupling_ * change_;
  if (load_.rows() > 0) free_factor_.solve_in_place(load_);
  parallel_chunks(logs.rows(), [&](long first, long last) {
    for (long dof = first; dof < last; ++dof)
      if (const int c = unknown_of_dof_[dof]; c >= 0)
        logs.row(dof) += index_[c] >= 0 ? load_.row(index_[c]) : change_.row(-1 - index_[c]);
  });
}

// Derivatives. The solution is linear in the right-hand sides; these are products of scales,
// rotations and given vectors.

namespace {

/// Derivatives of the right-hand sides of the last solution, in either direction.
class EditDerivatives {
 public:
  explicit EditDerivatives(FormFeatureData& data)
      : d_(data), features_(isize(d_.problem.features)) {}

  Points tangent(const DeformEditRates& rates) {
    MatX rotation_rates = MatX::Zero(isize(d_.problem.handles), 3);
    for (long h = 0; h < rotation_rates.rows(); ++h)
      rotation_rates.row(h) = rates.handles[h].rotation_vector.transpose();
    const Points dq = d_.rotations.rates(rotation_rates);
    MatX rhs = MatX::Zero(d_.rhs.rows(), 3);
    for (long k = 0; k < rhs.rows(); ++k) rhs.row(k) = value_rate(k, rates, dq).transpose();
    const MatX d0 = d_.positions.rhs_to_particular() * rhs;
    RowPoints b(d_.b.rows(), 3);
    for (long i = 0; i < b.rows(); ++i) b.row(i) = target_rate(i, rates, dq).transpose();
    b -= d_.A_constrained_columns * d0;
    Points x = d0;
    if (d_.positions.free_count() > 0) {
      MatX y = d_.B.transpose() * b;
      d_.factor.solve_in_place(y);
      d_.coupling.apply(y, equation_rates(rates, d0));
      x += d_.positions.D() * y;
    }
    Points result = Points::Zero(d_.mesh.vertex_count(), 3);
    for (int v = 0; v < d_.mesh.vertex_count(); ++v)
      if (const int h = d_.system.constrained_by[v]; h == DeformSystem::kFree)
        result.row(v) = x.row(d_.system.dof[v]);
      else if (h >= 0)
        result.row(v) = handle_rate(h, v, rates.handles[h]).transpose();
    return result;
  }

  DeformEditRates gradient(const Points& weights) {
    DeformEditRates result(d_.problem);
    Points d0 = Points::Zero(isize(d_.system.vertex), 3);
    for (int v = 0; v < d_.mesh.vertex_count(); ++v)
      if (const int h = d_.system.constrained_by[v]; h == DeformSystem::kFree)
        d0.row(d_.system.dof[v]) += weights.row(v);
      else if (h >= 0)
        add_handle(h, v, weights.row(v).transpose(), result.handles[h]);
    Points q = Points::Zero(d0.rows(), 3);
    if (d_.positions.free_count() > 0) {
      MatX y = d_.positions.D().transpose() * d0;
      d_.factor.solve_in_place(y);
      d_.coupling.apply(y, VecX::Zero(d_.g.size()));
      const VecX multipliers = d_.coupling.empty() ? VecX() : d_.coupling.multipliers();
      const RowPoints b = d_.B * y;
      for (long i = 0; i < b.rows(); ++i) add_target(i, b.row(i).transpose(), result, q);
      d0 -= Points(d_.A_constrained_columns.transpose() * b);
      add_equations(multipliers, result, d0);
    }
    const MatX rhs = d_.positions.rhs_to_particular().transpose() * d0;
    for (long k = 0; k < rhs.rows(); ++k) add_value(k, rhs.row(k).transpose(), result, q);
    const MatX rotations = d_.rotations.transposed_rates(q);
    for (long h = 0; h < rotations.rows(); ++h)
      result.handles[h].rotation_vector += rotations.row(h).transpose();
    return result;
  }

 private:
  using Kind = DeformSystem::Value::Kind;

  /// A vector s R(q) v, where s is the scale of a feature or handle (-1: 1), and R the rotation of a
  /// dof (-1: none).
  struct Rotated {
    int scaled_by = -1, dof = -1;
    Vec3 vector = Vec3::Zero();
    int target = -1;  // of which the vector is `factor` times the target; -1: constant
    double factor = 1;
    Vec3 shift = Vec3::Zero();  // added to the rotated vector before it is scaled
  };

  Vec3 turned(const Rotated& r) const {
    return r.dof < 0 ? r.vector : rotated(d_.last_valid_q.row(r.dof).transpose(), r.vector);
  }
  double scale_rate(int scaled_by, const DeformEditRates& rates) const {
    return scaled_by < 0           ? 0
           : scaled_by < features_ ? rates.feature_scales[scaled_by]
                                   : rates.handles[scaled_by - features_].scale;
  }

  Vec3 rate(const Rotated& r, const DeformEditRates& rates, const Points& dq) const {
    const Vec3 now = turned(r);
    Vec3 change = Vec3::Zero();
    if (r.dof >= 0) {
      const Vec3 log = d_.last_valid_q.row(r.dof).transpose();
      change = left_jacobian(log, dq.row(r.dof).transpose()).cross(now);
      if (r.target >= 0) change += rotated(log, r.factor * rates.targets[r.target]);
    } else if (r.target >= 0) {
      change = r.factor * rates.targets[r.target];
    }
    return d_.scale_of(d_.last, r.scaled_by) * change +
           scale_rate(r.scaled_by, rates) * (now + r.shift);
  }

  void add(const Rotated& r, const Vec3& weight, DeformEditRates& result, Points& q) const {
    const Vec3 now = turned(r);
    const double scale = d_.scale_of(d_.last, r.scaled_by), share = weight.dot(now + r.shift);
    if (r.scaled_by >= features_)
      result.handles[r.scaled_by - features_].scale += share;
    else if (r.scaled_by >= 0)
      result.feature_scales[r.scaled_by] += share;
    const Vec3 log = r.dof < 0 ? Vec3(Vec3::Zero()) : Vec3(d_.last_valid_q.row(r.dof).transpose());
    if (r.dof >= 0) q.row(r.dof) += scale * left_jacobian(-log, now.cross(weight)).transpose();
    if (r.target >= 0) result.targets[r.target] += scale * r.factor * rotated(-log, weight);
  }

  /// The right-hand side of a hard constraint of a feature or of DeformProblem::rows.
  Rotated value(long k) const {
    const DeformSystem::Value& value = d_.system.values[k];
    if (value.kind == Kind::Feature)
      return {value.source, d_.system.feature_dof[value.source],
              (d_.system.rest.row(value.vertex) - d_.system.rest.row(value.reference)).transpose()};
    const LinearConstraint& row = d_.problem.rows[value.source];
    return {-1, row.rotates_with >= 0 ? d_.system.dof[row.rotates_with] : -1,
            d_.last.targets.empty() ? row.target : d_.last.targets[value.source], value.source};
  }
  /// The target of a soft row.
  Rotated target(long i) const {
    Rotated r{d_.system.scaled_by[i], d_.system.rotates_with[i], d_.system.base.row(i).transpose()};
    if (const int row = d_.system.linear_constraint_of_row[i]; row >= 0) {
      r.vector = d_.unrotated_target(d_.last, i);
      r.target = row;
      r.factor = std::sqrt(*d_.problem.rows[row].weight);
      double sum = 0;
      for (RowMatrix::InnerIterator a(d_.system.A, i); a; ++a) sum += a.value();
      r.shift = -sum * d_.system.origin;
    }
    return r;
  }

  bool is_constant(long k) const {
    const Kind kind = d_.system.values[k].kind;
    return kind == Kind::Fixed || kind == Kind::CoincidentVertices;
  }
  Vec3 value_rate(long k, const DeformEditRates& rates, const Points& dq) const {
    const DeformSystem::Value& value = d_.system.values[k];
    if (is_constant(k)) return Vec3::Zero();
    if (value.kind == Kind::Handle)
      return handle_rate(value.source, value.vertex, rates.handles[value.source]);
    return rate(this->value(k), rates, dq);
  }
  void add_value(long k, const Vec3& weight, DeformEditRates& result, Points& q) const {
    const DeformSystem::Value& value = d_.system.values[k];
    if (is_constant(k)) return;
    if (value.kind == Kind::Handle)
      add_handle(value.source, value.vertex, weight, result.handles[value.source]);
    else
      add(this->value(k), weight, result, q);
  }
  Vec3 target_rate(long i, const DeformEditRates& rates, const Points& dq) const {
    return rate(target(i), rates, dq);
  }
  void add_target(long i, const Vec3& weight, DeformEditRates& result, Points& q) const {
    add(target(i), weight, result, q);
  }

  Vec3 handle_rate(int h, int vertex, const DeformEditRates::Handle& rates) const {
    const HandleTransform& move = d_.last.handles[h];
    const Vec3 arm = rotated(move.rotation_vector, d_.mesh.point(vertex) - move.about);
    return rates.translation + rates.scale * arm +
           move.scale * left_jacobian(move.rotation_vector, rates.rotation_vector).cross(arm);
  }
  void add_handle(int h, int vertex, const Vec3& weight, DeformEditRates::Handle& result) const {
    const HandleTransform& move = d_.last.handles[h];
    const Vec3 arm = rotated(move.rotation_vector, d_.mesh.point(vertex) - move.about);
    result.translation += weight;
    result.scale += weight.dot(arm);
    result.rotation_vector += move.scale * left_jacobian(-move.rotation_vector, arm.cross(weight));
  }

  VecX equation_rates(const DeformEditRates& rates, const MatX& d0) const {
    VecX g(d_.g.size());
    for (long k = 0; k < g.size(); ++k) {
      const int constraint = d_.constraint_of_equation[k];
      const Vec3& n = d_.equation_directions[k];
      g[k] = n.dot(rates.constraint_origins[constraint]);
      for (const auto& e : d_.problem.point_constraints[constraint].point.entries)
        g[k] -= e.coefficient * n.dot(d0.row(d_.system.dof[e.vertex]));
    }
    return g;
  }
  void add_equations(const VecX& multipliers, DeformEditRates& result, Points& d0) const {
    for (long k = 0; k < multipliers.size(); ++k) {
      const int constraint = d_.constraint_of_equation[k];
      const Vec3 part = multipliers[k] * d_.equation_directions[k];
      result.constraint_origins[constraint] += part;
      for (const auto& e : d_.problem.point_constraints[constraint].point.entries)
        d0.row(d_.system.dof[e.vertex]) -= e.coefficient * part.transpose();
    }
  }

  FormFeatureData& d_;
  int features_;
};

/// Checks that the last solution has derivatives.
void require_derivatives(const FormFeatureData& d) {
  if (!d.solved || d.is_estimated)
    throw InputError("derivatives without an edit: call deform() without an estimate first");
}

}  // namespace

Points FormFeatureDeformer::tangent(const DeformEditRates& rates) {
  require_derivatives(*data_);
  check(data_->problem, rates);
  return EditDerivatives(*data_).tangent(rates);
}

DeformEditRates FormFeatureDeformer::gradient(const Points& weights) {
  require_derivatives(*data_);
  if (weights.rows() != data_->mesh.vertex_count() || !weights.allFinite())
    throw InputError("found " + std::to_string(weights.rows()) + " weights, expected " +
                     std::to_string(data_->mesh.vertex_count()) + " with finite numbers");
  return EditDerivatives(*data_).gradient(weights);
}

// Constraint violation, evaluated independently of the deformer's own rows.

double hard_residual(const TriangleMesh& mesh, const DeformProblem& problem, const DeformEdit& edit,
                     const Points& p, const Points& logs) {
  double worst = 0;
  const auto accumulate = [&](double off) {
    // NaN counts as the worst value.
    if (!std::isnan(worst) && !(off <= worst)) worst = off;
  };
  const auto point = [&](int v) { return Vec3(p.row(v).transpose()); };
  std::vector<char> may_move(mesh.vertex_count(), problem.region ? 0 : 1);
  if (problem.region)
    for (const int v : *problem.region) may_move[v] = 1;
  for (size_t h = 0; h < problem.handles.size(); ++h)
    for (const int v : problem.handles[h].vertices) {
      may_move[v] = 1;
      accumulate((point(v) - edit.handles[h](mesh.point(v))).norm());
    }
  for (const int v : problem.fixed) may_move[v] = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (!may_move[v]) accumulate((point(v) - mesh.point(v)).norm());

  for (size_t f = 0; f < problem.features.size(); ++f) {
    const double scale = edit.feature_scales.empty() ? 1 : edit.feature_scales[f];
    const auto& feature = problem.features[f];
    const Similarity fit = fit_similarity(mesh.points(), p, feature.vertices, scale);
    const Vec3 first = mesh.point(feature.vertices[0]);
    for (const int v : feature.vertices) {
      accumulate((fit.scale * (fit.R * mesh.point(v)) + fit.translation - point(v)).norm());
      if (feature.kind == FormFeature::Kind::TranslationOnly)
        accumulate(
            (scale * (mesh.point(v) - first) - (point(v) - point(feature.vertices[0]))).norm());
    }
  }
  for (size_t k = 0; k < problem.point_constraints.size(); ++k) {
    const PointConstraint& constraint = problem.point_constraints[k];
    const Vec3 constraint_origin = edit.constraint_origins.empty()
                                       ? constraint.point.at(mesh.points())
                                       : edit.constraint_origins[k];
    const Vec3 off = constraint.point.at(p) - constraint_origin,
               n = constraint.direction.normalized();
    accumulate(constraint.kind == PointConstraint::Kind::OnPlane ? std::abs(n.dot(off))
                                                                 : n.cross(off).norm());
  }
  for (size_t k = 0; k < problem.rows.size(); ++k) {
    const LinearConstraint& row = problem.rows[k];
    if (row.weight) continue;
    Vec3 target = edit.targets.empty() ? row.target : edit.targets[k];
    if (row.rotates_with >= 0) target = rotated(logs.row(row.rotates_with).transpose(), target);
    accumulate((row.combination.at(p) - target).norm());
  }
  const double size = mesh.size();
  return size > 0 ? worst / size : worst;
}

}  // namespace batten
