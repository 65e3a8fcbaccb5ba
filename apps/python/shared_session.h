// A sculpting session as Python holds it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/apps/commands/shapes/make_session.h"
#include "batten/apps/commands/shapes/solved_shape.h"
#include "batten/apps/commands/shapes/stress_analysis.h"
#include "batten/apps/python/kernel_call.h"
#include "batten/apps/python/model.h"

namespace batten::python {

/// A session, what it was made of, and the frames that Python looks at. Threads take turns. All
/// functions but the constructor are called without the interpreter's lock.
class SharedSession {
 public:
  /// Makes the session of a model's scene and settles it. Throws as sculpt_model(), make_session().
  SharedSession(std::shared_ptr<const Model> model, const Progress& progress);

  SharedSession(const SharedSession&) = delete;  // the session keeps where it is

  /// Calls function(session) in this thread's turn. `changes`: it may move the surface. `progress`: asked
  /// by the session during this call.
  template <class Function>
  auto with_session(bool changes, const Progress& progress, const Function& function) {
    return serialize_([&] {
      const ProgressScope scope(active_progress_, progress);
      if (changes) stale_ = true;
      return function(*session_);
    });
  }

  SolveReport solve_to_equilibrium(const Progress& progress);
  SolveReport solve_preview(int max_iterations, double tolerance, const Progress& progress);
  /// Points and normals of the present shape. The frame stays as it is while somebody holds it; frames
  /// that nobody holds are used again.
  std::shared_ptr<const Frame> frame(const Progress& progress);
  /// The present shape as a model with the session's values.
  std::shared_ptr<const Model> model(const Progress& progress);

  struct Stress {
    StressEvaluator::MaxValues largest;
    std::shared_ptr<const StressEvaluator::Field> field;
  };
  /// Of the shell of the scene's [stress], at the points of frame(). Throws InputError without it.
  Stress stress(const Progress& progress);

  const Scene& scene() const { return scene_; }

 private:
  /// Whom the session asks while a call lasts.
  struct ProgressScope {
    ProgressScope(const Progress*& of, const Progress& progress) : scope(of) { scope = &progress; }
    ~ProgressScope() { scope = nullptr; }
    ProgressScope(const ProgressScope&) = delete;
    const Progress*& scope;
  };
  /// What the session keeps: it hands on to the call that is under way.
  Progress forwarding_progress();
  std::shared_ptr<const Frame> current_frame();

  Scene scene_;
  std::vector<CharacterLine> lines_;
  std::shared_ptr<const SculptModel> model_;
  const Progress* active_progress_ = nullptr;
  SessionReference start_;
  std::unique_ptr<SculptingSession> session_;
  SolveReport solve_report_;
  CallSerializer serialize_;
  std::vector<std::shared_ptr<Frame>> frames_;
  std::shared_ptr<const Frame> shown_;
  bool stale_ = true;  // shown_ is not the present shape
  std::optional<StressEvaluator> stress_;
};

}  // namespace batten::python
