// Macros and functions that select the vector instruction set of the machine at run time.
#pragma once

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

/// Width of the vector registers that are used: 512, 256 or 128 bits. This is the widest that the
/// machine supports, at most the limit of set_max_vector_bits().
int vector_bits();
/// Sets the upper limit of vector_bits(), default 512. For tests.
void set_max_vector_bits(int bits);

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
