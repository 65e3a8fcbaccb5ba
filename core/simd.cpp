#include "batten/core/simd.h"

#include <algorithm>
#include <atomic>

namespace batten {
namespace {

int widest_vector() {
#ifdef BATTEN_WIDE_VECTORS
  __builtin_cpu_init();
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return 128;
  const bool wide = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                    __builtin_cpu_supports("avx512dq");
  return wide ? 512 : 256;
#else
  return 128;
#endif
}

std::atomic<int> max_bits{512};

}  // namespace

int vector_bits() {
  static const int widest = widest_vector();
  return std::min(widest, max_bits.load(std::memory_order_relaxed));
}

void set_max_vector_bits(int bits) { max_bits = bits; }

}  // namespace batten
