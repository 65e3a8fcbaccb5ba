#include "batten/apps/commands/meshes/edit_session.h"

#include <numbers>
#include <utility>

#include "batten/apps/commands/runs/run_support.h"
#include "batten/core/containers.h"

namespace batten {
namespace {

/// The prescribed rotations of an edit, in the order of the scene.
std::vector<PrescribedRotation> prescribed_rotations(const EditSpec& rule,
                                                     const DeformProblem& problem) {
  std::vector<PrescribedRotation> prescribed;
  for (const auto& rotated : rule.rotated_features)
    for (int f = 0; f < isize(problem.features); ++f)
      if (matches_wildcard(rotated.feature.text, problem.features[f].name))
        prescribed.push_back(
            {f,
             Eigen::AngleAxisd(rotated.degrees * std::numbers::pi / 180, rotated.axis).matrix()});
  return prescribed;
}

}  // namespace

template <class Function>
void EditSession::with_edit_context(const Function& f) const {
  const auto fail = [&](const std::string& why) {
    return scene_.at(rule_.location) + "the edit '" + rule_.name + "': " + why;
  };
  try {
    f();
  } catch (const ConflictError& e) {
    throw ConflictError(e.conflicts(), fail(""));
  } catch (const InputError& e) {
    throw InputError(fail(e.what()));
  } catch (const NoSolutionError& e) {
    throw NoSolutionError(fail(e.what()));
  }
}

EditSession::EditSession(const DeformScene& scene, const EditSpec& rule,
                         const SharedConstraints& shared, VertexSelector& select,
                         const PreparedMesh& prepared, const Points& before)
    : scene_(scene), rule_(rule), shared_(shared) {
  DeformTask task =
      make_deform_task(scene, rule, shared, select, prepared.mesh.with_points(before));
  const MeshEditorOptions options{rule.rotation_mode, rule.keep_centres, shared.centres};
  with_edit_context([&] {
    editor_ = std::make_unique<MeshEditor>(prepared, before, std::move(task.problem), options,
                                           shared.attached);
    editor_->set(std::move(task.edit), prescribed_rotations(rule, editor_->problem()));
  });
}

void EditSession::set(const EditSpec& rule) {
  editor_->set(edit_of(scene_, rule, shared_, editor_->problem(), editor_->mesh()),
               prescribed_rotations(rule, editor_->problem()));
  rule_ = rule;
}

const Points& EditSession::solve_preview() {
  with_edit_context([&] { editor_->solve_preview(); });
  return editor_->shape();
}

const Points& EditSession::solve_to_equilibrium(DeformReport::Edit& report) {
  report.name = rule_.name;
  with_edit_context([&] { editor_->solve_to_equilibrium(); });
  const MeshEditStatistics& s = editor_->statistics();
  report.moving = s.counts.moving;
  report.unknowns = s.counts.unknowns;
  report.soft_equations = s.counts.soft_equations;
  report.hard_constraints = s.counts.hard_constraints;
  report.feature_constraints = s.counts.feature_constraints;
  report.redundant_count = s.counts.redundant_count;
  report.point_equations = s.counts.point_equations;
  report.largest_displacement = s.largest_displacement;
  report.hard_residual = s.hard_residual;
  report.last_correction = s.last_correction;
  report.iterations = s.iterations;
  report.found = s.converged;
  report.setup_s = s.setup_seconds;
  report.edit_s = s.edit_seconds;
  return editor_->shape();
}

}  // namespace batten
