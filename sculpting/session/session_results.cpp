#include "batten/sculpting/session/session_results.h"

namespace batten {

// Each of the three frames belongs to the writer, to the reader, or to the middle. Publishing or
// taking a frame swaps it with the middle one; a bit tells whether the reader has seen that one.

namespace {
constexpr int unread = 4;
}

void FrameExchange::publish() {
  // Release: the written data is visible before the reader gets the frame. Acquire: the reader is
  // done with the frame that comes back.
  write_ = middle_.exchange(write_ | unread, std::memory_order_acq_rel) & ~unread;
}

const Frame* FrameExchange::latest() {
  if (!(middle_.load(std::memory_order_relaxed) & unread)) return nullptr;
  read_ = middle_.exchange(read_, std::memory_order_acq_rel) & ~unread;
  return &frames_[read_];
}

}  // namespace batten
