#include "batten/apps/python/live_session.h"

#include <atomic>

#include "batten/core/errors.h"

namespace batten::python {

LiveSession::LiveSession(std::shared_ptr<const ShapedModel> of, const Progress& progress)
    : scene_(of->scene()), lines_(of->lines()) {
  require_surface(*of);
  const Asked asked(asked_, progress);
  model_ = std::make_shared<const SculptModel>(sculpt_model(*of->made(), scene_, handed_on()));
  progress.at("session", 0);
  session_ = std::make_unique<SculptingSession>(make_session(*model_->layout, scene_, model_->made,
                                                             Expected::many_factors, handed_on(),
                                                             &start_, model_->fair.rest));
  answer_ = session_->settle();
}

Progress LiveSession::handed_on() {
  Progress progress;
  progress.report = [this](std::string_view stage, double fraction) {
    if (asked_ && asked_->report) asked_->report(stage, fraction);
  };
  progress.cancelled = [this] { return asked_ && asked_->cancelled && asked_->cancelled(); };
  return progress;
}

Answer LiveSession::settle(const Progress& progress) {
  return with(true, progress,
              [&](SculptingSession& session) { return answer_ = session.settle(); });
}

Answer LiveSession::answer(int most_iterations, double tolerance, const Progress& progress) {
  return with(true, progress, [&](SculptingSession& session) {
    return answer_ = session.answer(most_iterations, tolerance);
  });
}

std::shared_ptr<const Frame> LiveSession::drawn() {
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

std::shared_ptr<const Frame> LiveSession::frame(const Progress& progress) {
  return with(false, progress, [&](SculptingSession&) { return drawn(); });
}

std::shared_ptr<const ShapedModel> LiveSession::model(const Progress& progress) {
  return with(false, progress, [&](SculptingSession& session) {
    MadeShape shape = shape_of(session, scene_, start_.unloaded, answer_);
    Scene scene = scene_;
    for (const NamedValue& p : scene_.named_values())
      if (p.follows.empty() && p.over_time.empty() && session.parameters().has(p.name))
        scene.set(p.name, session.parameters().value(p.name), "");
    auto made = std::make_shared<const MadeModel>(model_->made);
    return std::make_shared<const ShapedModel>(std::move(scene), lines_, std::move(made),
                                               std::move(shape));
  });
}

LiveSession::Stress LiveSession::stress(const Progress& progress) {
  if (!scene_.stress)
    throw InputError(scene_.name +
                     ": found no [stress], expected thickness, material and supports");
  return with(false, progress, [&](SculptingSession& session) {
    const auto shown = drawn();
    if (!stress_) stress_.emplace(scene_);
    Stress result;
    result.largest = stress_->at(session.layout(), session.dofs());
    result.field = std::make_shared<MovingStress::Field>(stress_->field(shown->pattern->places));
    return result;
  });
}

}  // namespace batten::python
