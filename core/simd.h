// SPDX-License-Identifier: MPL-2.0
// Macros and functions that select the vector instruction set of the machine at run time.
#pragma once

#include <algorithm>
#include <atomic>
#include <type_traits>

/// Attribute of a function that is compiled once for each generation of vector units; the version
/// for this machine is selected when the program starts. All functions that it calls must be
/// inlined into it. Empty if the compiler or processor does not support function multiversioning
/// (sanitizers cannot start with ifuncs).
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(BATTEN_NO_CLONES)
#define BATTEN_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define BATTEN_CLONES
#endif

#define BATTEN_INLINE __attribute__((always_inline)) inline

/// Attributes of functions that are selected by vector_bits(). They serve code that needs a
/// different structure for each register width.
#if defined(__x86_64__) && defined(__GNUC__)
#define BATTEN_WIDE_VECTORS
#define BATTEN_256_BITS __attribute__((target("avx2,fma")))
#define BATTEN_512_BITS __attribute__((target("avx512f,avx512vl,avx512dq,fma")))
#endif

namespace batten {

namespace detail {

inline std::atomic<int> max_vector_bits{512};

// The widest registers that the machine supports, in bits.
inline int supported_vector_bits() {
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

}  // namespace detail

/// Width of the vector registers that are used: 512, 256 or 128 bits. This is the widest that the
/// machine supports, at most the limit of set_max_vector_bits(). Thread-safe; takes a nanosecond.
inline int vector_bits() {
  static const int widest = detail::supported_vector_bits();
  return std::min(widest, detail::max_vector_bits.load(std::memory_order_relaxed));
}
/// Sets the upper limit of vector_bits(), default 512. For tests.
inline void set_max_vector_bits(int bits) { detail::max_vector_bits = bits; }

/// Selects the kernels for vector_bits(). `narrow` is the version for 128 bits; if
/// BATTEN_WIDE_VECTORS is defined, there are also versions for 256 bits (`middle`) and 512 bits
/// (`wide`).
template <class Kernels>
const Kernels& select_kernels(const Kernels& narrow) {
  return narrow;
}
template <class Kernels>
const Kernels& select_kernels(const Kernels& narrow, const Kernels& middle, const Kernels& wide) {
  const int bits = vector_bits();
  return bits >= 512 ? wide : bits >= 256 ? middle : narrow;
}

/// Calls call(n) with n, 1 … most, as a compile-time constant. Does nothing for n = 0.
template <int most, class Call>
BATTEN_INLINE void dispatch_constant(int n, const Call& call) {
  if constexpr (most > 0) {
    if (n == most)
      call(std::integral_constant<int, most>());
    else
      dispatch_constant<most - 1>(n, call);
  }
}

}  // namespace batten
