// Right-hand sides of an edit: where rows, handles, features and guides want to be.
#include <cmath>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/core/parallel_chunks.h"
#include "batten/core/rotations.h"
#include "batten/mesh/deform/form_feature_data.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {
namespace {

constexpr double kContradiction =
    1e-9;  // of the size: guided points that cannot be where they should

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
        if (scaled_by >= isize(problem.features)) scaled_by = -1;  // handles have theirs there
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
    fits("turns of features", e.feature_rotations.size(), problem.features.size());
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
  // Lines and rows turn with the shape that all else has.
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
  // The elimination of all rows together names those that take part.
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
