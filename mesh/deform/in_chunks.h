// Loops over the rows of large arrays, on several threads.
#pragma once

#include <algorithm>

#include "batten/core/parallel.h"

namespace batten {

/// Calls work(first, last) for pieces of 0 … count - 1, each a thread's at a time; allocates
/// nothing.
template <class Work>
void in_chunks(long count, const Work& work) {
  constexpr int chunk = 4096;  // rows
  const int parts = static_cast<int>((count + chunk - 1) / chunk);
  if (parts <= 1) {
    work(0L, count);
    return;
  }
  parallel_parts(parts, [&](int p) {
    work(static_cast<long>(p) * chunk, std::min<long>(count, static_cast<long>(p + 1) * chunk));
  });
}

}  // namespace batten
