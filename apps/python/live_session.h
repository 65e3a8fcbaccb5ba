// A sculpting session as Python holds it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/apps/commands/shapes/make_session.h"
#include "batten/apps/commands/shapes/make_shape.h"
#include "batten/apps/commands/shapes/stress_shape.h"
#include "batten/apps/python/kernel_call.h"
#include "batten/apps/python/shaped_model.h"

namespace batten::python {

/// A session, what it was made of, and the frames that Python looks at. Threads take turns. All
/// functions but the constructor are called without the interpreter's lock.
class LiveSession {
 public:
  /// Makes the session of a model's scene and settles it. Throws as sculpt_model(), make_session().
  LiveSession(std::shared_ptr<const ShapedModel> model, const Progress& progress);

  LiveSession(const LiveSession&) = delete;  // the session keeps where it is

  /// Calls function(session) in this thread's turn. `changes`: it may move the surface. `progress`: asked
  /// by the session during this call.
  template <class Function>
  auto with(bool changes, const Progress& progress, const Function& function) {
    return turns_([&] {
      const Asked asked(asked_, progress);
      if (changes) stale_ = true;
      return function(*session_);
    });
  }

  Answer settle(const Progress& progress);
  Answer answer(int most_iterations, double tolerance, const Progress& progress);
  /// Points and normals of the present shape. The frame stays as it is while somebody holds it; frames
  /// that nobody holds are used again.
  std::shared_ptr<const Frame> frame(const Progress& progress);
  /// The present shape as a model with the session's values.
  std::shared_ptr<const ShapedModel> model(const Progress& progress);

  struct Stress {
    MovingStress::Largest largest;
    std::shared_ptr<const MovingStress::Field> field;
  };
  /// Of the shell of the scene's [stress], at the points of frame(). Throws InputError without it.
  Stress stress(const Progress& progress);

  const Scene& scene() const { return scene_; }

 private:
  /// Whom the session asks while a call lasts.
  struct Asked {
    Asked(const Progress*& of, const Progress& progress) : asked(of) { asked = &progress; }
    ~Asked() { asked = nullptr; }
    Asked(const Asked&) = delete;
    const Progress*& asked;
  };
  /// What the session keeps: it hands on to the call that is under way.
  Progress handed_on();
  std::shared_ptr<const Frame> drawn();

  Scene scene_;
  std::vector<CharacterLine> lines_;
  std::shared_ptr<const SculptModel> model_;
  const Progress* asked_ = nullptr;
  SessionStart start_;
  std::unique_ptr<SculptingSession> session_;
  Answer answer_;
  Turns turns_;
  std::vector<std::shared_ptr<Frame>> frames_;
  std::shared_ptr<const Frame> shown_;
  bool stale_ = true;  // shown_ is not the present shape
  std::optional<MovingStress> stress_;
};

}  // namespace batten::python
