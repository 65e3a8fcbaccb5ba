// Loops over many small things, on several threads.
#pragma once

#include <algorithm>

#include "batten/core/parallel.h"

namespace batten {

/// Calls work(first, last) for pieces of 0 … count - 1, each a thread's at a time; allocates
/// nothing.
template <int chunk = 4096, class Work>
void parallel_chunks(long count, const Work& work) {
  const int parts = static_cast<int>((count + chunk - 1) / chunk);
  if (parts <= 1) {
    work(0L, count);
    return;
  }
  parallel_for(parts, [&](int p) {
    work(static_cast<long>(p) * chunk, std::min<long>(count, static_cast<long>(p + 1) * chunk));
  });
}

/// The same one by one: calls work(i).
template <int chunk, class Work>
void parallel_for_each(int count, const Work& work) {
  parallel_chunks<chunk>(count, [&](long first, long last) {
    for (int i = static_cast<int>(first); i < last; ++i) work(i);
  });
}

}  // namespace batten
