// The widest vector unit of the machine, chosen by the loader.
#pragma once

/// Stands before a function, which is then compiled for each generation of vector units, the right
/// one picked when the program starts. Everything it calls must be inlined into it. Nothing where
/// the compiler or the processor has no such choice (sanitizers cannot start with ifuncs).
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(BATTEN_NO_CLONES)
#define BATTEN_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define BATTEN_CLONES
#endif

#define BATTEN_INLINE __attribute__((always_inline)) inline

namespace batten {

/// call(n) with n, 1 … most, as a constant; nothing for 0.
template <int most, class Call>
BATTEN_INLINE void with_constant(int n, const Call& call) {
  if constexpr (most > 0) {
    if (n == most)
      call(std::integral_constant<int, most>());
    else
      with_constant<most - 1>(n, call);
  }
}

}  // namespace batten
