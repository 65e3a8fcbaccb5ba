#include "batten/apps/commands/meshes/edit_session.h"

#include <algorithm>
#include <chrono>
#include <limits>

#include "batten/apps/commands/runs/run_parts.h"

namespace batten {
namespace {

using Clock = std::chrono::steady_clock;
constexpr double kSettled = 0.05;  // degrees

/// Coordinates that change by roundings only are as they were, so that their text stays.
Points unmoved_as_before(const Points& before, const Points& after) {
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
  report.soft_rows = c.soft_rows;
  report.hard_rows = c.hard_rows;
  report.feature_rows = c.feature_rows;
  report.dropped_rows = c.dropped_rows;
  report.guide_rows = c.guide_rows;
  report.hard_residual = deformer.hard_residual();
}

}  // namespace

template <class Function>
void EditSession::naming(const Function& f) const {
  const auto fail = [&](const std::string& why) {
    return scene_.at(rule_.place) + "the edit '" + rule_.name + "': " + why;
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

EditSession::EditSession(const DeformScene& scene, const EditRule& rule, const Kept& kept,
                         VertexSelector& select, const PreparedMesh& prepared, const Points& before)
    : scene_(scene),
      rule_(rule),
      kept_(kept),
      prepared_(prepared),
      mesh_(prepared.mesh.with_points(before)),
      turns_(prepared_, mesh_),
      task_(task_of(scene, rule, kept, select, mesh_)),
      shape_(before) {
  naming([&] { set_up(); });
}

// Without rows for the centres of features: they need a shape first.
void EditSession::set_up() {
  const auto start = Clock::now();
  deformer_ = std::make_unique<FormFeatureDeformer>(mesh_, task_.problem);
  centres_kept_ = false;
  set_up_s_ += seconds_since(start);
}

void EditSession::set(const EditRule& rule) {
  task_.edit = edit_of(scene_, rule, kept_, task_.problem, mesh_);
  rule_ = rule;
  if (!centres_kept_) return;
  task_.problem.rows = kept_.rows;
  set_up();
}

const Points& EditSession::answer() {
  naming([&] {
    DeformReport::Edit none;
    rests_ = true;
    const bool leans = rule_.turn == EditRule::Turn::Found && kept_.attached->connections().empty();
    if (live_ && leans)
      rests_ = turns_.lean_on(rule_, task_, kept_.features.size(), shape_, *live_) < kSettled;
    else
      live_ = turns_.estimate(rule_, task_, none);
    shape_ = live_ ? deformer_->deform(task_.edit, *live_) : deformer_->deform(task_.edit);
  });
  return shape_;
}

const Points& EditSession::settle(DeformReport::Edit& report) {
  report.name = rule_.name;
  live_.reset();
  naming([&] {
    auto start = Clock::now();
    std::optional<ShapeEstimate> estimate = turns_.estimate(rule_, task_, report);
    report.set_up_s = set_up_s_ + seconds_since(start);
    start = Clock::now();
    if (!centres_kept_ && rule_.keep_centres && scales_features(task_.edit)) {
      const std::vector<double> scales = std::move(task_.edit.feature_scales);
      task_.edit.feature_scales.clear();
      settle_turns(estimate, report);
      task_.edit.feature_scales = scales;
      task_ = with_kept_centres(std::move(task_), kept_, deformer_->positions());
      deformer_ = std::make_unique<FormFeatureDeformer>(mesh_, task_.problem);
      centres_kept_ = true;
    }
    settle_turns(estimate, report);
    report.edit_s = seconds_since(start);
    report.last_correction = deformer_->correct();
    count_into(report, *deformer_);
    const Points& found = deformer_->positions();
    report.largest_displacement = (found - before()).rowwise().norm().maxCoeff();
    shape_ = unmoved_as_before(before(), found);
    kept_.attached->follow(before(), shape_, task_.problem.features);
  });
  return shape_;
}

// Features lean on the sheet beside them, which they bend themselves.
void EditSession::settle_turns(std::optional<ShapeEstimate>& estimate, DeformReport::Edit& report) {
  estimate ? deformer_->deform(task_.edit, *estimate) : deformer_->deform(task_.edit);
  constexpr int most_rounds = 20;
  if (estimate && rule_.turn == EditRule::Turn::Found) {
    report.found = false;
    for (report.rounds = 1; report.rounds < most_rounds && !report.found; ++report.rounds) {
      report.found = turns_.lean_on(rule_, task_, kept_.features.size(), deformer_->positions(),
                                    *estimate) < kSettled;
      deformer_->deform(task_.edit, *estimate);
    }
  }
  deformer_->correct();
}

}  // namespace batten
