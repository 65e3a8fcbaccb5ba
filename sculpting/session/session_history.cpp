#include <set>

#include "batten/sculpting/session/session_data.h"

namespace batten {

using detail::SessionSystem;

namespace {

constexpr size_t kMaxUndoSteps = 256;

}  // namespace

detail::SessionState SessionData::snapshot() const {
  detail::SessionState copy = now;
  copy.system = std::make_shared<SessionSystem>(*now.system);
  return copy;
}

void SessionData::push_history(detail::SessionState before) {
  redo_stack.clear();
  undo_stack.push_back(std::move(before));
  coalesces = false;
  while (undo_stack.size() > kMaxUndoSteps ||
         (undo_stack.size() > 1 && bytes() > options.history_bytes))
    undo_stack.pop_front();
}

// A step of the history, unless a drag or a motion goes on that has one already.
void SessionData::push_history_once() {
  if (coalesces) return;
  push_history(snapshot());
  coalesces = true;
}

size_t SessionData::bytes() const {
  std::set<const void*> seen;
  size_t sum = 0;
  for (const auto* list : {&undo_stack, &redo_stack})
    for (const detail::SessionState& s : *list)
      sum += detail::bytes_of(*s.system, seen) +
             8 * static_cast<size_t>(s.shape.x.size() + s.shape.v.size() + s.converged_x.size());
  return sum;
}

void SessionData::restore_state(detail::SessionState state) {
  now = std::move(state);
  engine.bind(*now.system);
  update_value_names();
  coalesces = false;
  ++version;
}

bool SessionData::move_in_history(std::deque<detail::SessionState>& from,
                                             std::deque<detail::SessionState>& to) {
  if (from.empty()) return false;
  to.push_back(snapshot());
  detail::SessionState state = std::move(from.back());
  from.pop_back();
  restore_state(std::move(state));
  return true;
}

void SessionData::record_operation(const Operation& op) {
  if (!recording) return;
  if (record.size() == record.capacity()) record.reserve(record.size() + detail::kRecordPage);
  record.push_back(op);
}

}  // namespace batten
