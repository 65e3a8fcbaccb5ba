// Waiting for another thread that will be done soon. Internal.
#pragma once

#include <thread>

namespace batten {

/// A short while without sleep, then the core is offered to others at every turn.
class SpinWait {
 public:
  void wait() {
    if (--spins_left_ > 0) {
#if defined(__x86_64__)
      __builtin_ia32_pause();
#endif
    } else {
      std::this_thread::yield();
    }
  }

 private:
  int spins_left_ = 2000;
};

}  // namespace batten
