// How far positions are from what a problem states, apart from the deformer's own rows.
#include <cmath>

#include "batten/core/rotations.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/deform/similarity.h"

namespace batten {

double hard_residual(const TriangleMesh& mesh, const DeformProblem& problem, const DeformEdit& edit,
                     const Points& p, const Points& logs) {
  double worst = 0;
  const auto accumulate = [&](double off) {
    // What is not a number is worse than everything.
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
