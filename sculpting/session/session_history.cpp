#include <set>

#include "batten/sculpting/session/session_data.h"

namespace batten {

using live::System;

namespace {

constexpr size_t kMostUndone = 256;

}  // namespace

live::State SculptingSession::Data::saved() const {
  live::State copy = now;
  copy.system = std::make_shared<System>(*now.system);
  return copy;
}

void SculptingSession::Data::remember(live::State before) {
  redone_to.clear();
  undone_to.push_back(std::move(before));
  joins = false;
  while (undone_to.size() > kMostUndone ||
         (undone_to.size() > 1 && bytes() > options.history_bytes))
    undone_to.pop_front();
}

// A step of the history, unless a drag or a motion goes on that has one already.
void SculptingSession::Data::remember_start() {
  if (joins) return;
  remember(saved());
  joins = true;
}

size_t SculptingSession::Data::bytes() const {
  std::set<const void*> seen;
  size_t sum = 0;
  for (const auto* list : {&undone_to, &redone_to})
    for (const live::State& s : *list)
      sum += live::bytes_of(*s.system, seen) +
             8 * static_cast<size_t>(s.shape.x.size() + s.shape.v.size() + s.good_x.size());
  return sum;
}

void SculptingSession::Data::put_back(live::State state) {
  now = std::move(state);
  engine.bind(*now.system);
  name_values();
  joins = false;
  ++version;
}

bool SculptingSession::Data::go(std::deque<live::State>& from, std::deque<live::State>& to) {
  if (from.empty()) return false;
  to.push_back(saved());
  live::State state = std::move(from.back());
  from.pop_back();
  put_back(std::move(state));
  return true;
}

void SculptingSession::Data::note(const Operation& op) {
  if (!recording) return;
  if (record.size() == record.capacity()) record.reserve(record.size() + live::kPage);
  record.push_back(op);
}

}  // namespace batten
