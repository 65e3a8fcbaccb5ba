// SPDX-License-Identifier: MPL-2.0
// Transfer of frames from the thread that solves to the one that draws.
#include "batten/sculpting/session/session_results.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "batten/tests/support/catch.h"

using namespace batten;

namespace {

void fill(Frame& frame, long number, size_t size) {
  frame.points.assign(size, static_cast<float>(number));
  frame.normals.assign(size, static_cast<float>(-number));
  frame.number = number;
}

bool whole(const Frame& frame) {
  const auto value = static_cast<float>(frame.number);
  const auto all = [](const std::vector<float>& numbers, float of) {
    return std::all_of(numbers.begin(), numbers.end(), [&](float x) { return x == of; });
  };
  return all(frame.points, value) && all(frame.normals, -value) &&
         frame.points.size() == frame.normals.size();
}

}  // namespace

TEST_CASE("frames: the reader gets the newest one, once", "[sculpting][session]") {
  FrameExchange exchange;
  CHECK(exchange.latest() == nullptr);
  for (long number = 1; number <= 3; ++number) {
    fill(exchange.writing(), number, 4);
    exchange.publish();
  }
  const Frame* frame = exchange.latest();
  REQUIRE(frame != nullptr);
  CHECK(frame->number == 3);
  CHECK(exchange.latest() == nullptr);
  CHECK(frame->number == 3);  // remains valid
  // The reader's frame does not change while the writer continues.
  for (long number = 4; number <= 20; ++number) {
    REQUIRE(&exchange.writing() != frame);
    fill(exchange.writing(), number, 4);
    exchange.publish();
    CHECK(frame->number == 3);
    CHECK(whole(*frame));
  }
  frame = exchange.latest();
  REQUIRE(frame != nullptr);
  CHECK(frame->number == 20);
}

TEST_CASE("frames: buffers go around, three of them", "[sculpting][session]") {
  FrameExchange exchange;
  std::vector<const float*> seen;
  for (long number = 1; number <= 60; ++number) {
    Frame& frame = exchange.writing();
    if (number <= 30)
      fill(frame, number, 1000);
    else
      std::fill(frame.points.begin(), frame.points.end(), static_cast<float>(number));
    if (number > 30) CHECK(std::count(seen.begin(), seen.end(), frame.points.data()) == 1);
    if (number <= 30 && std::count(seen.begin(), seen.end(), frame.points.data()) == 0)
      seen.push_back(frame.points.data());
    exchange.publish();
    if (number % 4 == 0) exchange.latest();
  }
  CHECK(seen.size() == 3);
}

TEST_CASE("frames: writer and reader on threads of their own see whole frames in ascending order",
          "[sculpting][session]") {
  FrameExchange exchange;
  constexpr size_t size = 3000;
  std::atomic<bool> done{false};
  long last_written = 0;
  std::thread writer([&] {
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(300);
    while (std::chrono::steady_clock::now() < end) {
      fill(exchange.writing(), ++last_written, size);
      exchange.publish();
    }
    done = true;
  });
  long last = 0, seen = 0, torn = 0, backwards = 0;
  for (bool finished = false; !finished;) {
    finished = done;  // one more read after the last frame
    while (const Frame* frame = exchange.latest()) {
      ++seen;
      if (frame->number <= last) ++backwards;
      if (!whole(*frame)) ++torn;
      last = frame->number;
    }
  }
  writer.join();
  CHECK(seen > 0);
  CHECK(torn == 0);
  CHECK(backwards == 0);
  CHECK(last == last_written);
}
