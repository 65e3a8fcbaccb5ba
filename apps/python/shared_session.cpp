#include "batten/apps/python/shared_session.h"

#include <atomic>

#include "batten/core/errors.h"

namespace batten::python {

SharedSession::SharedSession(std::shared_ptr<const Model> of, const Progress& progress)
    : scene_(of->scene()), lines_(of->lines()) {
  require_surface(*of);
  const ProgressScope scope(active_progress_, progress);
  model_ =
      std::make_shared<const SculptModel>(sculpt_model(*of->made(), scene_, forwarding_progress()));
  progress.update("session", 0);
  session_ = std::make_unique<SculptingSession>(
      make_session(*model_->layout, scene_, model_->made, FactorReuse::many, forwarding_progress(),
                   &start_, model_->fair.rest));
  solve_report_ = session_->solve_to_equilibrium();
}

Progress SharedSession::forwarding_progress() {
  Progress progress;
  progress.report = [this](std::string_view stage, double fraction) {
    if (active_progress_ && active_progress_->report) active_progress_->report(stage, fraction);
  };
  progress.cancelled = [this] {
    return active_progress_ && active_progress_->cancelled && active_progress_->cancelled();
  };
  return progress;
}

SolveReport SharedSession::solve_to_equilibrium(const Progress& progress) {
  return with_session(true, progress, [&](SculptingSession& session) {
    return solve_report_ = session.solve_to_equilibrium();
  });
}

SolveReport SharedSession::solve_preview(int max_iterations, double tolerance,
                                         const Progress& progress) {
  return with_session(true, progress, [&](SculptingSession& session) {
    return solve_report_ = session.solve_preview(max_iterations, tolerance);
  });
}

std::shared_ptr<const Frame> SharedSession::current_frame() {
  if (!stale_ && shown_) return shown_;
  shown_.reset();
  std::shared_ptr<Frame> free;
  for (const auto& frame : frames_)
    if (frame.use_count() == 1) free = frame;
  std::atomic_thread_fence(std::memory_order_acquire);  // its last reader is done
  if (!free) {
    free = std::make_shared<Frame>();
    constexpr size_t most_kept = 4;
    if (frames_.size() < most_kept) frames_.push_back(free);
  }
  session_->draw(*free);
  shown_ = free;
  stale_ = false;
  return shown_;
}

std::shared_ptr<const Frame> SharedSession::frame(const Progress& progress) {
  return with_session(false, progress, [&](SculptingSession&) { return current_frame(); });
}

std::shared_ptr<const Model> SharedSession::model(const Progress& progress) {
  return with_session(false, progress, [&](SculptingSession& session) {
    SolvedShape shape = shape_of(session, scene_, start_.unloaded, solve_report_);
    Scene scene = scene_;
    for (const ScalarParameter& p : scene_.named_values())
      if (p.rule_terms.empty() && p.keyframes.empty() && session.parameters().has(p.name))
        scene.set(p.name, session.parameters().value(p.name), "");
    auto made = std::make_shared<const BuiltModel>(model_->made);
    return std::make_shared<const Model>(std::move(scene), lines_, std::move(made),
                                         std::move(shape));
  });
}

SharedSession::Stress SharedSession::stress(const Progress& progress) {
  if (!scene_.stress)
    throw InputError(scene_.name +
                     ": found no [stress], expected thickness, material and supports");
  return with_session(false, progress, [&](SculptingSession& session) {
    const auto shown = current_frame();
    if (!stress_) stress_.emplace(scene_);
    Stress result;
    result.largest = stress_->at(session.layout(), session.dofs());
    result.field =
        std::make_shared<StressEvaluator::Field>(stress_->field(shown->pattern->locations));
    return result;
  });
}

}  // namespace batten::python
