// SPDX-License-Identifier: MPL-2.0
// Contents of a Session, for the front ends of Batten.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/analysis/models/shell_evaluator.h"
#include "batten/core/call_serializer.h"
#include "batten/core/cancellation.h"
#include "batten/scenes/model_data.h"
#include "batten/scenes/session.h"
#include "batten/scenes/stress_data.h"
#include "batten/sculpting/session/sculpting_session.h"

namespace batten::detail {

/// The name of an item of a session.
std::string name_of(const SculptingSession::ActingItem& item);

/// A sculpting session with the model that it started from, and the frames that callers view.
struct SessionContents {
  SessionContents(const Model& model, const Progress& progress);
  SessionContents(const SessionContents&) = delete;  // the session refers to members by address

  /// Calls function(session) while no other thread is in a call. `changes`: the call may move the
  /// surface. `progress`: callbacks for this call; without functions, those of the current
  /// ProgressScope (core/cancellation.h). Throws Error if this thread is in a call already, as from a progress callback.
  template <class Function>
  auto with_session(bool changes, const Progress& progress, const Function& function) {
    return serialize([&] {
      const ProgressState* outer = current_progress().state;
      const bool given = progress.report || progress.cancelled;
      const ActiveProgress active(active_progress, given || !outer ? &progress : &outer->progress);
      if (changes) stale = true;
      return function(*session);
    });
  }
  template <class Function>
  auto with_session(bool changes, const Function& function) {
    return with_session(changes, Progress{}, function);
  }

  std::shared_ptr<const Frame> current_frame();
  /// The model in the current shape. Call it in with_session().
  Model current_model();

  /// Session::stress() for settings as text. Call it in with_session().
  SessionStress current_stress(const StressTable& table);

  std::shared_ptr<const ModelData> base;  ///< the model that the session was created from
  std::shared_ptr<const SculptModel> model;
  SessionReference reference;
  SolveReport solve_report;
  std::unique_ptr<SculptingSession> session;
  /// Items of the scene of `base`, by name.
  std::map<std::string, std::shared_ptr<const void>> scene_items;
  /// Identity and values of the constraints and offsets of that scene, which determine where its
  /// loads act.
  std::vector<std::pair<std::shared_ptr<const void>, std::vector<double>>> scene_reference;

 private:
  struct ActiveProgress {
    ActiveProgress(const Progress*& of, const Progress* progress) : slot(of) { slot = progress; }
    ~ActiveProgress() { slot = nullptr; }
    ActiveProgress(const ActiveProgress&) = delete;
    const Progress*& slot;
  };
  /// Callbacks that the session keeps; they forward to those of the current call.
  Progress forwarding_progress();
  /// The text of the scene; `constrained`: constrained_shape().
  std::string current_scene(const Points& constrained);
  /// Dofs of the shape under the constraints and offsets without loads, if a load acts at a point;
  /// otherwise of any shape.
  Points constrained_shape();

  CallSerializer serialize;
  const Progress* active_progress = nullptr;
  std::vector<std::shared_ptr<Frame>> frames;
  std::shared_ptr<const Frame> shown;
  bool stale = true;  // `shown` does not show the current shape
  // The shell of current_stress() and its settings.
  Scene stress_scene;
  StressTable stress_settings;
  std::optional<ShellEvaluator> stress;
};

}  // namespace batten::detail
