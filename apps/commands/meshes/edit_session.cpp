#include "batten/apps/commands/meshes/edit_session.h"

#include <algorithm>
#include <chrono>
#include <limits>

#include "batten/apps/commands/runs/run_support.h"

namespace batten {
namespace {

using Clock = std::chrono::steady_clock;
constexpr double kConvergedDegrees = 0.05;  // degrees

/// Coordinates that change by roundings only are as they were, so that their text stays.
Points restore_unmoved(const Points& before, const Points& after) {
  const double rounding =
      16 * std::numeric_limits<double>::epsilon() * before.cwiseAbs().maxCoeff();
  return ((after - before).array().abs() <= rounding).select(before, after);
}

bool scales_features(const DeformEdit& edit) {
  return std::any_of(edit.feature_scales.begin(), edit.feature_scales.end(),
                     [](double scale) { return scale != 1; });
}

void count_into(DeformReport::Edit& report, const FormFeatureDeformer& deformer) {
  const auto c = deformer.counts();
  report.moving = c.moving;
  report.unknowns = c.unknowns;
  report.soft_equations = c.soft_equations;
  report.hard_constraints = c.hard_constraints;
  report.feature_constraints = c.feature_constraints;
  report.redundant_count = c.redundant_count;
  report.point_equations = c.point_equations;
  report.hard_residual = deformer.hard_residual();
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
    : scene_(scene),
      rule_(rule),
      shared_(shared),
      prepared_(prepared),
      mesh_(prepared.mesh.with_points(before)),
      rotations_(prepared_, mesh_),
      task_(make_deform_task(scene, rule, shared, select, mesh_)),
      shape_(before) {
  with_edit_context([&] { set_up(); });
}

// Without rows for the centres of features: they need a shape first.
void EditSession::set_up() {
  const auto start = Clock::now();
  deformer_ = std::make_unique<FormFeatureDeformer>(mesh_, task_.problem);
  centres_kept_ = false;
  set_up_s_ += seconds_since(start);
}

void EditSession::set(const EditSpec& rule) {
  task_.edit = edit_of(scene_, rule, shared_, task_.problem, mesh_);
  rule_ = rule;
  if (!centres_kept_) return;
  task_.problem.rows = shared_.rows;
  set_up();
}

const Points& EditSession::solve_preview() {
  with_edit_context([&] {
    DeformReport::Edit none;
    at_rest_ = true;
    const bool uses_adjacent_faces = rule_.rotation_mode == EditSpec::RotationMode::Estimated &&
                                     shared_.attached->connections().empty();
    if (live_ && uses_adjacent_faces)
      at_rest_ = rotations_.update_from_adjacent_faces(rule_, task_, shared_.features.size(),
                                                       shape_, *live_) < kConvergedDegrees;
    else
      live_ = rotations_.estimate(rule_, task_, none);
    shape_ = live_ ? deformer_->deform(task_.edit, *live_) : deformer_->deform(task_.edit);
  });
  return shape_;
}

const Points& EditSession::solve_to_equilibrium(DeformReport::Edit& report) {
  report.name = rule_.name;
  live_.reset();
  with_edit_context([&] {
    auto start = Clock::now();
    std::optional<ShapeEstimate> estimate = rotations_.estimate(rule_, task_, report);
    report.setup_s = set_up_s_ + seconds_since(start);
    start = Clock::now();
    if (!centres_kept_ && rule_.keep_centres && scales_features(task_.edit)) {
      const std::vector<double> scales = std::move(task_.edit.feature_scales);
      task_.edit.feature_scales.clear();
      converge_rotations(estimate, report);
      task_.edit.feature_scales = scales;
      task_ = with_fixed_centres(std::move(task_), shared_, deformer_->positions());
      deformer_ = std::make_unique<FormFeatureDeformer>(mesh_, task_.problem);
      centres_kept_ = true;
    }
    converge_rotations(estimate, report);
    report.edit_s = seconds_since(start);
    report.last_correction = deformer_->correct();
    count_into(report, *deformer_);
    const Points& found = deformer_->positions();
    report.largest_displacement = (found - before()).rowwise().norm().maxCoeff();
    shape_ = restore_unmoved(before(), found);
    shared_.attached->propagate_to_attached(before(), shape_, task_.problem.features);
  });
  return shape_;
}

// Features lean on the sheet beside them, which they bend themselves.
void EditSession::converge_rotations(std::optional<ShapeEstimate>& estimate,
                                     DeformReport::Edit& report) {
  estimate ? deformer_->deform(task_.edit, *estimate) : deformer_->deform(task_.edit);
  constexpr int max_iterations = 20;
  if (estimate && rule_.rotation_mode == EditSpec::RotationMode::Estimated) {
    report.found = false;
    for (report.iterations = 1; report.iterations < max_iterations && !report.found;
         ++report.iterations) {
      report.found = rotations_.update_from_adjacent_faces(rule_, task_, shared_.features.size(),
                                                           deformer_->positions(),
                                                           *estimate) < kConvergedDegrees;
      deformer_->deform(task_.edit, *estimate);
    }
  }
  deformer_->correct();
}

}  // namespace batten
