// The widest vector unit of the machine, chosen by the loader or asked for.
#pragma once

#include <type_traits>

/// Stands before a function, which is then compiled for each generation of vector units, the right
/// one picked when the program starts. Everything it calls must be inlined into it. Nothing where
/// the compiler or the processor has no such choice (sanitizers cannot start with ifuncs).
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(BATTEN_NO_CLONES)
#define BATTEN_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define BATTEN_CLONES
#endif

#define BATTEN_INLINE __attribute__((always_inline)) inline

/// Stand before a function that vector_bits() chooses: where one shape of the code does not fit the
/// registers of every generation.
#if defined(__x86_64__) && defined(__GNUC__)
#define BATTEN_WIDE_VECTORS
#define BATTEN_256_BITS __attribute__((target("avx2,fma")))
#define BATTEN_512_BITS __attribute__((target("avx512f,avx512vl,avx512dq,fma")))
#endif

namespace batten {

/// 512, 256 or 128: vector registers of this machine, none wider than the limit.
int vector_bits();
/// The limit; 512 at first. For tests.
void set_max_vector_bits(int bits);

/// Of what was made for 128 bits, and where BATTEN_WIDE_VECTORS is defined for 256 and 512 too, the
/// one for vector_bits().
template <class Kernels>
const Kernels& select_kernels(const Kernels& narrow) {
  return narrow;
}
template <class Kernels>
const Kernels& select_kernels(const Kernels& narrow, const Kernels& middle, const Kernels& wide) {
  const int bits = vector_bits();
  return bits >= 512 ? wide : bits >= 256 ? middle : narrow;
}

/// call(n) with n, 1 … most, as a constant; nothing for 0.
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
