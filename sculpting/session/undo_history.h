// SPDX-License-Identifier: MPL-2.0
// States of a sculpting session, and the undo history that stores them.
#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <unordered_map>
#include <vector>

#include "batten/sculpting/session/session_engine.h"

namespace batten::detail {

/// Everything that undo restores.
struct SessionState {
  std::shared_ptr<SessionSystem> system;
  Parameters parameters;
  ShapeState shape;
  bool in_motion = false;
  Motion motion;
  std::vector<double> shape_values;  ///< parameter values for which the shape was computed
  // The last converged solve.
  Points converged_x;
  std::shared_ptr<const RestConfiguration> converged_rest;
  std::vector<double> converged_values;
  /// Parameters that have not acted on the shape yet: their converged value is 0.
  std::vector<char> fresh;
};

/// States before and after the current one.
///
/// Equal arrays of a state and of its neighbours are stored once. If the memory exceeds the limit,
/// the history first drops what can be computed again (recomputable_part()), from the states that
/// are farthest from the current one, and then the oldest states.
class UndoHistory {
 public:
  static constexpr size_t kMaxSteps = 1000;

  /// Adds the state before an edit and removes all undone states. `now`: the state after the edit.
  /// `limit`: memory in bytes; 0: nothing is stored, otherwise at least one state.
  void push(SessionState before, const SessionState& now, size_t limit);
  bool can_undo() const { return !undo_.empty(); }
  bool can_redo() const { return !redo_.empty(); }
  /// Removes and returns the state before or after `now`, which becomes an undone or a previous
  /// state. Cost: a copy of the dofs, and what was dropped of the state, except its factors. May
  /// exceed the limit by one state.
  SessionState undo(SessionState now, size_t limit) {
    return move(undo_, redo_, std::move(now), limit);
  }
  SessionState redo(SessionState now, size_t limit) {
    return move(redo_, undo_, std::move(now), limit);
  }
  void clear();
  /// Memory of all states, bytes, without what the current state holds itself.
  size_t bytes(const SessionState& now) const;

 private:
  struct StoredState {
    SessionState state;              // without the following arrays
    SharedPoints x, v, converged_x;  // v: null if it is zero
  };
  using States = std::deque<StoredState>;
  struct Use {
    size_t count = 0, bytes = 0;
  };

  static StoredState stored(SessionState state, const States& neighbours);
  static SessionState restored(const StoredState& stored, const SessionSystem& present);
  template <class Visit>
  static void visit_parts(const StoredState& stored, const Visit& visit);
  SessionState move(States& from, States& to, SessionState now, size_t limit);
  void append(States& to, SessionState state);
  void count(const StoredState& stored);
  void discount(const StoredState& stored);
  void drop_recomputable(const SessionState& now, size_t limit);

  States undo_, redo_;
  std::unordered_map<const void*, Use> uses_;  // of every part that a state refers to
  size_t bytes_ = 0;
};

}  // namespace batten::detail
