#include "batten/core/solvers/supernodal_sweeps.h"

#include <algorithm>

#include "batten/core/simd.h"

namespace batten {
namespace {

constexpr int panel = kPanelRows;
constexpr int kPrefetchBytes = 8192;

// Size of the packed lower triangle of w columns: panels of `height` × (columns up to their
// diagonal).
BATTEN_INLINE long triangle_size(long w) {
  const long full = w / panel, rest = w % panel;
  return panel * panel * full * (full + 1) / 2 + rest * w;
}

// Number of vectors per row. `Vector` is a whole row, or half or a quarter of one if registers are
// narrow. In that case the panel is read again for each part, while it is in the L1 cache.
template <class Vector, class Row>
constexpr int vectors_of = sizeof(Row) / sizeof(Vector);

// acc_i = Σ_k L_ik x_k for a panel of H rows.
template <int H, class Vector, class Row>
BATTEN_INLINE void multiply(const double* L, long columns, const Row* x, Row* acc) {
  constexpr int vectors = vectors_of<Vector, Row>;
  for (int v = 0; v < vectors; ++v) {
    const Vector* xv = reinterpret_cast<const Vector*>(x) + v;
    Vector sum[H] = {};
    const double* Lk = L;
    for (long k = 0; k < columns; ++k, Lk += H) {
      __builtin_prefetch(reinterpret_cast<const char*>(Lk) + kPrefetchBytes);
      const Vector xk = xv[k * vectors];
      for (int i = 0; i < H; ++i) sum[i] += Lk[i] * xk;
    }
    for (int i = 0; i < H; ++i) reinterpret_cast<Vector*>(acc + i)[v] = sum[i];
  }
}

// x_k -= Σ_i L_ik y_i for a panel of H rows, from its last column to its first.
template <int H, class Vector, class Row>
BATTEN_INLINE void multiply_transposed(const double* L, long columns, Row* x, const Row* y) {
  constexpr int vectors = vectors_of<Vector, Row>;
  for (int v = 0; v < vectors; ++v) {
    Vector* xv = reinterpret_cast<Vector*>(x) + v;
    Vector yv[H];
    for (int i = 0; i < H; ++i) yv[i] = reinterpret_cast<const Vector*>(y + i)[v];
    const double* Lk = L + H * columns;
    for (long k = columns - 1; k >= 0; --k) {
      Lk -= H;
      __builtin_prefetch(reinterpret_cast<const char*>(Lk) - kPrefetchBytes);
      Vector even = xv[k * vectors], odd{};  // two accumulators halve the dependency chain
      for (int i = 0; i < H; ++i) {
        if (i % 2)
          odd += Lk[i] * yv[i];
        else
          even -= Lk[i] * yv[i];
      }
      xv[k * vectors] = even - odd;
    }
  }
}

// Solves T x = x - acc in place with the H×H lower triangle T, whose diagonal is inverted.
template <int H, class Row>
BATTEN_INLINE void solve_triangle(const double* T, Row* x, Row* acc) {
  for (int i = 0; i < H; ++i) {
    const Row xi = (x[i] - acc[i]) * T[i * H + i];
    x[i] = xi;
    for (int j = i + 1; j < H; ++j) acc[j] += T[i * H + j] * xi;
  }
}

template <int H, class Row>
BATTEN_INLINE void solve_triangle_transposed(const double* T, Row* x) {
  for (int i = H - 1; i >= 0; --i) {
    x[i] *= T[i * H + i];
    for (int j = 0; j < i; ++j) x[j] -= T[j * H + i] * x[i];
  }
}

template <int H, class Vector, class Row>
BATTEN_INLINE void forward_diagonal(const double* L, long before, Row* x) {
  Row acc[H];
  multiply<H, Vector>(L, before, x, acc);
  solve_triangle<H>(L + H * before, x + before, acc);
}

template <int H, class Vector, class Row>
BATTEN_INLINE void forward_below(const double* L, long width, const Row* x, const int* targets,
                                 Row* work) {
  Row acc[H];
  multiply<H, Vector>(L, width, x, acc);
  for (int i = 0; i < H; ++i) work[targets[i]] -= acc[i];
}

template <int H, class Vector, class Row>
BATTEN_INLINE void backward_below(const double* L, long width, Row* x, const int* targets,
                                  const Row* work) {
  Row y[H];
  for (int i = 0; i < H; ++i) y[i] = work[targets[i]];
  multiply_transposed<H, Vector>(L, width, x, y);
}

template <int H, class Vector, class Row>
BATTEN_INLINE void backward_diagonal(const double* L, long before, Row* x) {
  Row y[H];
  for (int i = 0; i < H; ++i) y[i] = x[before + i];
  solve_triangle_transposed<H>(L + H * before, y);
  for (int i = 0; i < H; ++i) x[before + i] = y[i];
  multiply_transposed<H, Vector>(L, before, x, y);
}

#define BATTEN_CALL [&](auto height) __attribute__((always_inline))

// `visit`: flag per supernode, or null to visit all.
template <class Vector, class Row>
BATTEN_INLINE void forward(const PackedSupernodes& all, int first, int end, const char* visit,
                           Row* work) {
  for (int s = first; s < end; ++s) {
    if (visit && !visit[s]) continue;
    Row* x = work + all.columns[s];
    const int width = all.columns[s + 1] - all.columns[s];
    const double* L = all.values + all.starts[s];
    int q = 0;
    for (; q + panel <= width; L += panel * (q + panel), q += panel)
      forward_diagonal<panel, Vector>(L, q, x);
    dispatch_constant<panel - 1>(
        width - q, BATTEN_CALL { forward_diagonal<height(), Vector>(L, q, x); });
    L += (width - q) * static_cast<long>(width);

    const int* target = all.targets + all.row_starts[s] + width;
    const int* last = all.targets + all.row_starts[s + 1];
    for (; last - target >= panel; target += panel, L += panel * static_cast<long>(width))
      forward_below<panel, Vector>(L, width, x, target, work);
    dispatch_constant<panel - 1>(
        static_cast<int>(last - target),
        BATTEN_CALL { forward_below<height(), Vector>(L, width, x, target, work); });
  }
}

template <class Vector, class Row>
BATTEN_INLINE void backward(const PackedSupernodes& all, int first, int end, const char* visit,
                            Row* work) {
  for (int s = end - 1; s >= first; --s) {
    if (visit && !visit[s]) continue;
    Row* x = work + all.columns[s];
    const int width = all.columns[s + 1] - all.columns[s];
    const int* target = all.targets + all.row_starts[s] + width;
    const int below = static_cast<int>(all.targets + all.row_starts[s + 1] - target);
    const double* L = all.values + all.starts[s] + triangle_size(width) +
                      static_cast<long>(below / panel * panel) * width;
    dispatch_constant<panel - 1>(
        below % panel, BATTEN_CALL {
          backward_below<height(), Vector>(L, width, x, target + below / panel * panel, work);
        });
    for (int t = below / panel * panel - panel; t >= 0; t -= panel) {
      L -= panel * static_cast<long>(width);
      backward_below<panel, Vector>(L, width, x, target + t, work);
    }
    int q = width / panel * panel;
    L -= (width - q) * static_cast<long>(width);
    dispatch_constant<panel - 1>(
        width - q, BATTEN_CALL { backward_diagonal<height(), Vector>(L, q, x); });
    while (q > 0) {
      L -= panel * q;
      q -= panel;
      backward_diagonal<panel, Vector>(L, q, x);
    }
  }
}

#undef BATTEN_CALL

using Row2 = double __attribute__((vector_size(16)));

template <class Row>
using Sweep = void (*)(const PackedSupernodes&, int, int, const char*, Row*);
struct Sweeps {
  Sweep<Row4> forward4, backward4;
  Sweep<Row8> forward8, backward8;
};

// Sweeps for one generation of vector units. `attribute`: target for the compiler; Vector4,
// Vector8: vector types for rows of 4 and 8.
#define BATTEN_SWEEPS(name, attribute, Vector4, Vector8)                           \
  attribute void forward4_##name(const PackedSupernodes& all, int first, int end,  \
                                 const char* visit, Row4* work) {                  \
    forward<Vector4>(all, first, end, visit, work);                                \
  }                                                                                \
  attribute void backward4_##name(const PackedSupernodes& all, int first, int end, \
                                  const char* visit, Row4* work) {                 \
    backward<Vector4>(all, first, end, visit, work);                               \
  }                                                                                \
  attribute void forward8_##name(const PackedSupernodes& all, int first, int end,  \
                                 const char* visit, Row8* work) {                  \
    forward<Vector8>(all, first, end, visit, work);                                \
  }                                                                                \
  attribute void backward8_##name(const PackedSupernodes& all, int first, int end, \
                                  const char* visit, Row8* work) {                 \
    backward<Vector8>(all, first, end, visit, work);                               \
  }                                                                                \
  constexpr Sweeps name = {forward4_##name, backward4_##name, forward8_##name, backward8_##name};

BATTEN_SWEEPS(with_128_bits, , Row2, Row2)
#ifdef BATTEN_WIDE_VECTORS
BATTEN_SWEEPS(with_256_bits, BATTEN_256_BITS, Row4, Row4)
BATTEN_SWEEPS(with_512_bits, BATTEN_512_BITS, Row4, Row8)
#endif
#undef BATTEN_SWEEPS

const Sweeps& sweeps() {
#ifdef BATTEN_WIDE_VECTORS
  return select_kernels(with_128_bits, with_256_bits, with_512_bits);
#else
  return select_kernels(with_128_bits);
#endif
}

}  // namespace

void sweep_forward(const PackedSupernodes& all, int first, int end, const char* visit, Row4* work) {
  sweeps().forward4(all, first, end, visit, work);
}
void sweep_forward(const PackedSupernodes& all, int first, int end, const char* visit, Row8* work) {
  sweeps().forward8(all, first, end, visit, work);
}
void sweep_backward(const PackedSupernodes& all, int first, int end, const char* visit,
                    Row4* work) {
  sweeps().backward4(all, first, end, visit, work);
}
void sweep_backward(const PackedSupernodes& all, int first, int end, const char* visit,
                    Row8* work) {
  sweeps().backward8(all, first, end, visit, work);
}

double* pack_supernode(const double* block, long r, long w, double* to) {
  for (long first = 0; first < r;) {
    const bool triangle = first < w;
    const long height = std::min<long>(panel, (triangle ? w : r) - first);
    const long columns = triangle ? first + height : w;
    for (long k = 0; k < columns; ++k)
      for (long i = first; i < first + height; ++i)
        *to++ = i == k ? 1 / block[i + k * r] : block[i + k * r];
    first += height;
  }
  return to;
}

}  // namespace batten
