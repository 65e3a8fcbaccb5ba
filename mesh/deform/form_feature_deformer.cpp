#include "batten/mesh/deform/form_feature_deformer.h"

#include <cmath>

#include "batten/core/chunks.h"
#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/core/parallel.h"
#include "batten/mesh/deform/form_feature_data.h"
#include "batten/mesh/deform/normal_equations.h"

namespace batten {
namespace {

DeformProblem checked(DeformProblem problem, const TriangleMesh& mesh) {
  check(problem, mesh.vertex_count());
  return with_whole_nodes(std::move(problem), mesh.topology());
}

}  // namespace

FormFeatureData::FormFeatureData(const TriangleMesh& given, DeformProblem stated)
    : mesh(given),
      problem(checked(std::move(stated), mesh)),
      system(mesh, problem),
      positions(system.positions, AffineReduction::Values::Later),
      rotations(system, static_cast<long>(problem.handles.size())),
      size(mesh.size()) {
  const auto dofs = static_cast<long>(system.vertex.size());
  const RowMatrix rows = reduced_rows(system.A, positions);
  B = rows;
  keep_held_columns();
  const SparseMatrix N = normal_matrix(B, rows);
  parallel_parts(2, [&](int part) {
    if (part == 1) {
      rotations.solve_weights(system, mesh);
      return;
    }
    if (positions.free_count() == 0) return;
    factor.analyze(N);
    if (!factor.factorize(N)) throw NoSolutionError("the deformation: " + factor.message());
  });

  couple_guides();
  q = good_q = Points::Zero(dofs, 3);
  right = MatX::Zero(static_cast<long>(system.values.size()), 3);
  g.resize(static_cast<long>(guide_of.size()));
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

void FormFeatureData::keep_held_columns() {
  const auto dofs = static_cast<long>(system.vertex.size());
  // d0 vanishes on dofs that stay free.
  std::vector<char> held(dofs, 1);
  for (const int d : positions.free_dofs()) held[d] = 0;
  A_held_rows.resize(system.A.rows(), dofs);
  for (long i = 0; i < system.A.rows(); ++i) {
    A_held_rows.startVec(i);
    for (RowMatrix::InnerIterator a(system.A, i); a; ++a)
      if (held[a.col()]) A_held_rows.insertBack(i, a.col()) = a.value();
  }
  A_held_rows.finalize();
}

void FormFeatureData::couple_guides() {
  const auto dofs = static_cast<long>(system.vertex.size());
  std::vector<Coupling::Row> coupled;
  std::vector<Triplet> combination;
  for (size_t k = 0; k < problem.guided.size(); ++k) {
    const GuidedPoint& guide = problem.guided[k];
    for (const auto& e : guide.point.entries)
      combination.emplace_back(system.dof[e.vertex], static_cast<int>(k), e.coefficient);
    double coefficients = 0;
    for (const auto& e : guide.point.entries) coefficients += e.coefficient * e.coefficient;
    coefficients = std::sqrt(coefficients);
    const Vec3 n = guide.direction.normalized();
    if (guide.kind == GuidedPoint::Kind::OnPlane) {
      coupled.push_back({static_cast<int>(k), n, coefficients});
      guide_of.push_back(static_cast<int>(k));
    } else {
      const Vec3 l = n.unitOrthogonal(), m = n.cross(l);
      for (const Vec3& across : {l, m}) {
        coupled.push_back({static_cast<int>(k), across, coefficients});
        guide_of.push_back(static_cast<int>(k));
      }
    }
  }
  for (const auto& row : coupled) guide_directions.push_back(row.direction);
  if (!coupled.empty()) {
    SparseMatrix U(dofs, static_cast<long>(problem.guided.size()));
    U.setFromTriplets(combination.begin(), combination.end());
    SparseMatrix reduced = SparseMatrix(positions.D().transpose()) * U;
    coupling = Coupling(factor, reduced.pruned(), coupled);
  }
}

void FormFeatureData::add_guide_row(ConstraintSet& set, size_t k, double value) const {
  const GuidedPoint& guide = problem.guided[guide_of[k]];
  std::vector<ConstraintSet::CoupledEntry> entries;
  for (const auto& e : guide.point.entries)
    entries.push_back({system.dof[e.vertex], e.coefficient * guide_directions[k]});
  set.add_coupled(guide.name, std::move(entries), value);
}

void FormFeatureData::start_residual() {
  const MatX& d0 = positions.d0();
  in_chunks(b.rows(), [&](long first, long last) {
    for (long i = first; i < last; ++i) {
      Eigen::RowVector3d sum = b.row(i) - rest_rows.row(i);
      for (RowMatrix::InnerIterator a(A_held_rows, i); a; ++a) sum -= a.value() * d0.row(a.col());
      r.row(i) = sum;
    }
  });
}

void FormFeatureData::reduce_residual() {
  in_chunks(B.cols(), [&](long first, long last) {
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
    if (const int h = system.holder[v]; h == DeformSystem::kMoves)
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
  d.correctable = false;
  d.rotations.evaluate(d.system, edit, d.q);
  d.set_hard_values(edit);
  d.set_guides(edit);
  d.set_targets(edit, nullptr);
  return d.solve(edit);
}

const Points& FormFeatureDeformer::deform(const DeformEdit& edit, const ShapeEstimate& estimate) {
  FormFeatureData& d = *data_;
  check(d.problem, edit);
  d.check_estimate(estimate);
  d.correctable = false;
  d.rotations.evaluate(d.system, edit, d.q);
  d.take_turns(estimate);
  d.set_hard_values(edit);
  d.set_guides(edit);
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
  good_q.swap(q);
  last = edit;
  solved = correctable = true;
  return result;
}

double FormFeatureDeformer::correct() {
  FormFeatureData& d = *data_;
  if (!d.correctable) throw InputError("there is no edit to correct, expected deform() before");
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
      q.row(v) = d.good_q.row(dof);
    else if (const int h = d.system.holder[v]; h >= 0 && d.solved)
      q.row(v) = d.last.handles[h].turn;
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
  c.soft_rows = static_cast<int>(d.system.A.rows());
  c.hard_rows = count_of(d.system.values);
  c.feature_rows = d.system.feature_rows;
  c.dropped_rows = d.positions.dropped_rows();
  c.guide_rows = count_of(d.guide_of);
  c.factor_entries = d.positions.free_count() > 0 ? d.factor.factor_entries() : 0;
  return c;
}

FormFeatureDeformer::Statement FormFeatureDeformer::statement(const DeformEdit& edit) {
  deform(edit);
  const FormFeatureData& d = *data_;
  Statement s{d.system.vertex, d.system.origin, d.system.A, d.b,
              ConstraintSet(count_of(d.system.vertex))};
  const auto& rows = d.system.positions.rows();
  std::vector<char> implied(rows.size(), 0);
  for (const int k : d.positions.dropped()) implied[k] = 1;
  for (size_t k = 0; k < rows.size(); ++k)
    if (!implied[k])
      s.constraints.add(d.system.positions.names()[rows[k].name], rows[k].entries,
                        d.right.row(static_cast<long>(k)).transpose());
  for (const int k : d.coupling.independent())
    d.add_guide_row(s.constraints, static_cast<size_t>(k),
                    d.guide_directions[k].dot(d.through(edit, k)));
  return s;
}

}  // namespace batten
