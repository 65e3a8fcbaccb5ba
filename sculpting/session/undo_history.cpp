// SPDX-License-Identifier: MPL-2.0
#include "batten/sculpting/session/undo_history.h"

#include <cstring>

namespace batten::detail {

namespace {

size_t bytes_of(const Points& points) {
  return sizeof(double) * static_cast<size_t>(points.size());
}

bool same_bits(const Points& a, const Points& b) {
  return a.rows() == b.rows() && std::memcmp(a.data(), b.data(), bytes_of(a)) == 0;
}

/// Memory that a state does not share with others.
size_t own_bytes(const SessionState& state) {
  size_t sum = sizeof(SessionState) + own_bytes(*state.system);
  for (const ScalarParameter& p : state.parameters.all())
    sum += 2 * sizeof(ScalarParameter) + 2 * p.name.capacity() +
           sizeof(ScalarParameter::Keyframe) * p.keyframes.size() +
           2 * sizeof(ScalarParameter::Term) * p.rule_terms.size();
  return sum + sizeof(double) * (state.shape_values.size() + state.converged_values.size()) +
         state.fresh.size();
}

}  // namespace

UndoHistory::StoredState UndoHistory::stored(SessionState state, const States& neighbours) {
  StoredState made;
  const auto shared = [&](Points& points) -> SharedPoints {
    for (const SharedPoints& known : {made.x, neighbours.empty() ? nullptr : neighbours.back().x})
      if (known && same_bits(*known, points)) return known;
    return std::make_shared<const Points>(std::move(points));
  };
  made.x = shared(state.shape.x);
  made.converged_x = shared(state.converged_x);
  if (!state.shape.v.isZero(0)) made.v = shared(state.shape.v);
  state.shape.x.resize(0, 3);
  state.shape.v.resize(0, 3);
  state.converged_x.resize(0, 3);
  made.state = std::move(state);
  return made;
}

SessionState UndoHistory::restored(const StoredState& stored, const SessionSystem& present) {
  SessionState state = stored.state;
  state.shape.x = *stored.x;
  state.shape.v = stored.v ? *stored.v : Points(Points::Zero(stored.x->rows(), 3));
  state.converged_x = *stored.converged_x;
  if (!state.system->parts) state.system = completed(*state.system, state.parameters, present);
  return state;
}

template <class Visit>
void UndoHistory::visit_parts(const StoredState& stored, const Visit& visit) {
  for (const SharedPoints& points : {stored.x, stored.v, stored.converged_x})
    if (points) visit(points.get(), bytes_of(*points));
  visit(stored.state.system.get(), own_bytes(stored.state));
  visit_shared_parts(*stored.state.system, visit);
}

void UndoHistory::count(const StoredState& stored) {
  visit_parts(stored, [&](const void* part, size_t bytes) {
    Use& use = uses_[part];
    if (use.count++ > 0) return;
    use.bytes = bytes;
    bytes_ += bytes;
  });
}

void UndoHistory::discount(const StoredState& stored) {
  visit_parts(stored, [&](const void* part, size_t) {
    const auto use = uses_.find(part);
    if (--use->second.count > 0) return;
    bytes_ -= use->second.bytes;
    uses_.erase(use);
  });
}

size_t UndoHistory::bytes(const SessionState& now) const {
  size_t sum = bytes_;
  std::unordered_map<const void*, char> seen;
  visit_shared_parts(*now.system, [&](const void* part, size_t) {
    if (const auto use = uses_.find(part); use != uses_.end() && seen.emplace(part, 1).second)
      sum -= use->second.bytes;
  });
  return sum;
}

void UndoHistory::append(States& to, SessionState state) {
  to.push_back(stored(std::move(state), to));
  count(to.back());
}

void UndoHistory::push(SessionState before, const SessionState& now, size_t limit) {
  for (const StoredState& undone : redo_) discount(undone);
  redo_.clear();
  if (limit == 0) return;
  append(undo_, std::move(before));
  drop_recomputable(now, limit);
  while (undo_.size() > kMaxSteps || (undo_.size() > 1 && bytes(now) > limit)) {
    discount(undo_.front());
    undo_.pop_front();
  }
}

SessionState UndoHistory::move(States& from, States& to, SessionState now, size_t limit) {
  SessionState state = restored(from.back(), *now.system);
  append(to, std::move(now));
  discount(from.back());
  from.pop_back();
  drop_recomputable(state, limit);
  return state;
}

void UndoHistory::clear() {
  undo_.clear();
  redo_.clear();
  uses_.clear();
  bytes_ = 0;
}

void UndoHistory::drop_recomputable(const SessionState& now, size_t limit) {
  size_t undo = 0, redo = 0;
  while (undo < undo_.size() || redo < redo_.size()) {
    // The front of each list is farthest from the current state.
    StoredState& farthest =
        undo_.size() - undo >= redo_.size() - redo ? undo_[undo++] : redo_[redo++];
    if (!farthest.state.system->parts) continue;
    if (bytes(now) <= limit) return;
    discount(farthest);
    farthest.state.system = without_recomputable(*farthest.state.system);
    count(farthest);
  }
}

}  // namespace batten::detail
