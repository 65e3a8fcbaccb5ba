#include "batten/sculpting/session/session_results.h"

namespace batten {

// Each of the three frames is with the writer, with the reader, or in the middle. Who hands a frame
// over swaps it with the middle one, and the exchange says whether the other side has seen it.

namespace {
constexpr int unread = 4;
}

void FrameExchange::publish() {
  // Release: what was written is there before the reader gets the frame. Acquire: what the reader
  // did with the frame that comes back is done.
  write_ = middle_.exchange(write_ | unread, std::memory_order_acq_rel) & ~unread;
}

const Frame* FrameExchange::latest() {
  if (!(middle_.load(std::memory_order_relaxed) & unread)) return nullptr;
  read_ = middle_.exchange(read_, std::memory_order_acq_rel) & ~unread;
  return &frames_[read_];
}

}  // namespace batten
