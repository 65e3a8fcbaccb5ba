// Right-hand sides of an edit: where rows, handles, features and guides want to be.
#include <cmath>

#include "batten/core/chunks.h"
#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/core/rotations.h"
#include "batten/mesh/deform/form_feature_data.h"
#include "batten/mesh/rotation_of_faces.h"

namespace batten {
namespace {

constexpr double kContradiction =
    1e-9;  // of the size: guided points that cannot be where they should

bool knows(const ShapeEstimate& estimate, int vertex) {
  return estimate.known.empty() || estimate.known[vertex];
}

}  // namespace

double FormFeatureData::scale_of(const DeformEdit& edit, int scaled_by) const {
  if (scaled_by < 0) return 1;
  const auto features = count_of(problem.features);
  if (scaled_by >= features) return edit.handles[scaled_by - features].scale;
  return edit.feature_scales.empty() ? 1 : edit.feature_scales[scaled_by];
}

Vec3 FormFeatureData::told_target(const DeformEdit& edit, long row) const {
  const CombinationRow& told = problem.rows[system.target_row[row]];
  const Vec3 target = edit.targets.empty() ? told.target : edit.targets[system.target_row[row]];
  return std::sqrt(*told.weight) * target;
}

bool FormFeatureData::known_target(const ShapeEstimate& estimate, long row, Vec3& target) const {
  if (row >= system.curvature_rows || estimate.use != ShapeEstimate::Use::Shape) return false;
  Vec3 sum = Vec3::Zero();
  for (RowMatrix::InnerIterator a(system.A, row); a; ++a) {
    const int v = system.vertex[a.col()];
    if (!knows(estimate, v)) return false;
    sum += a.value() * (estimate.positions.row(v) - system.origin.transpose()).transpose();
  }
  target = sum;
  return true;
}

void FormFeatureData::set_targets(const DeformEdit& edit, const ShapeEstimate* estimate) {
  const bool still = rotations.still() && !estimate;
  in_chunks(b.rows(), [&](long first, long last) {
    for (long i = first; i < last; ++i) {
      Vec3 target = system.base.row(i).transpose();
      int scaled_by = system.scaled_by[i];
      if (estimate && known_target(*estimate, i, target)) {
        if (scaled_by >= count_of(problem.features)) scaled_by = -1;  // handles have theirs there
      } else {
        if (system.target_row[i] >= 0) target = told_target(edit, i);
        const int turns_with = system.turns_with[i];
        if (!still && turns_with >= 0) target = rotated(turn_at(turns_with), target);
      }
      if (system.target_row[i] >= 0) {
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
  if (!e.feature_turns.empty())
    fits("turns of features", e.feature_turns.size(), problem.features.size());
  if (!e.positions.allFinite()) throw InputError("the estimate has a position that is not finite");
}

Vec3 FormFeatureData::turn_of_ring(const ShapeEstimate& estimate, int dof) const {
  const MeshTopology& topology = mesh.topology();
  std::vector<int> ring{system.vertex[dof]};
  for (const int v : topology.together(system.vertex[dof]))
    ring.insert(ring.end(), topology.neighbours(v).begin(), topology.neighbours(v).end());
  return rotation_log(rotation_of_face(ring, mesh.points(), estimate.positions));
}

void FormFeatureData::take_turns(const ShapeEstimate& estimate) {
  std::vector<std::pair<int, Vec3>> given;
  for (size_t f = 0; f < estimate.feature_turns.size(); ++f)
    if (estimate.feature_turns[f])
      given.emplace_back(system.feature_dof[f], rotation_log(*estimate.feature_turns[f]));
  rotations.pass_through(system, mesh, given, q);
  if (estimate.use == ShapeEstimate::Use::Turns) return;
  // Lines and rows turn with the shape that all else has.
  for (long i = system.curvature_rows; i < b.rows(); ++i)
    if (const int d = system.turns_with[i]; d >= 0 && knows(estimate, system.vertex[d]) &&
                                            system.holder[system.vertex[d]] == DeformSystem::kMoves)
      q.row(d) = turn_of_ring(estimate, d);
}

void FormFeatureData::set_hard_values(const DeformEdit& edit) {
  using Kind = DeformSystem::Value::Kind;
  for (size_t k = 0; k < system.values.size(); ++k) {
    const auto& value = system.values[k];
    Vec3 d;
    if (value.kind == Kind::Fixed) {
      d = system.rest.row(value.vertex);
    } else if (value.kind == Kind::Handle) {
      d = edit.handles[value.who](mesh.point(value.vertex)) - system.origin;
    } else if (value.kind == Kind::Feature) {
      d = scale_of(edit, value.who) *
          rotated(turn_at(system.feature_dof[value.who]),
                  (system.rest.row(value.vertex) - system.rest.row(value.reference)).transpose());
    } else if (value.kind == Kind::Joint) {
      d = Vec3::Zero();
    } else {
      const CombinationRow& row = problem.rows[value.who];
      d = edit.targets.empty() ? row.target : edit.targets[value.who];
      if (row.turns_with >= 0) d = rotated(turn_at(system.dof[row.turns_with]), d);
      double sum = 0;
      for (const auto& e : row.combination.entries) sum += e.coefficient;
      d -= sum * system.origin;
    }
    right.row(static_cast<long>(k)) = d;
  }
  positions.set_right(right);
}

void FormFeatureData::set_guides(const DeformEdit& edit) {
  for (size_t k = 0; k < guide_of.size(); ++k) {
    double reached = guide_directions[k].dot(through(edit, k));
    for (const auto& e : problem.guided[guide_of[k]].point.entries)
      reached -= e.coefficient * guide_directions[k].dot(positions.d0().row(system.dof[e.vertex]));
    g[static_cast<long>(k)] = reached;
  }
  const auto [missed, row] = coupling.contradiction(g);
  if (!(missed > kContradiction * size)) return;
  // The elimination of all rows together names those that take part.
  ConstraintSet all = system.positions;
  for (size_t k = 0; k < guide_of.size(); ++k) add_guide_row(all, k, 0);
  AffineReduction named(all, AffineReduction::Values::Later);
  MatX stacked(3 * right.rows() + g.size(), 1);
  for (long k = 0; k < right.rows(); ++k) stacked.block<3, 1>(3 * k, 0) = right.row(k).transpose();
  for (size_t k = 0; k < guide_of.size(); ++k)
    stacked(3 * right.rows() + static_cast<long>(k), 0) = guide_directions[k].dot(through(edit, k));
  named.set_right(stacked);
  throw ConflictError({{{problem.guided[guide_of[row]].name}, missed}});
}

}  // namespace batten
