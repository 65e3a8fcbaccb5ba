#include "batten/core/supernodal_sweeps.h"

#include <algorithm>

#include "batten/core/simd.h"

namespace batten {
namespace {

constexpr int panel = panel_rows;
constexpr int prefetch_bytes = 8192;

// Where the packed lower triangle of w columns ends: panels of `height` × (columns up to them).
BATTEN_INLINE long triangle_size(long w) {
  const long full = w / panel, rest = w % panel;
  return panel * panel * full * (full + 1) / 2 + rest * w;
}

// acc_i += Σ_k L_ik x_k of a panel of H rows.
template <int H, class Row>
BATTEN_INLINE void multiply(const double* L, long columns, const Row* x, Row* acc) {
  for (long k = 0; k < columns; ++k, L += H) {
    __builtin_prefetch(reinterpret_cast<const char*>(L) + prefetch_bytes);
    const Row xk = x[k];
    for (int i = 0; i < H; ++i) acc[i] += L[i] * xk;
  }
}

// x_k -= Σ_i L_ik y_i of a panel of H rows, from its last column to its first.
template <int H, class Row>
BATTEN_INLINE void multiply_transposed(const double* L, long columns, Row* x, const Row* y) {
  L += H * columns;
  for (long k = columns - 1; k >= 0; --k) {
    L -= H;
    __builtin_prefetch(reinterpret_cast<const char*>(L) - prefetch_bytes);
    Row even = x[k], odd{};  // two chains: half the wait for each sum
    for (int i = 0; i < H; ++i) {
      if (i % 2)
        odd += L[i] * y[i];
      else
        even -= L[i] * y[i];
    }
    x[k] = even - odd;
  }
}

// T x = x - acc with the H×H lower triangle T, its diagonal inverted.
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

template <int H, class Row>
BATTEN_INLINE void forward_diagonal(const double* L, long before, Row* x) {
  Row acc[H] = {};
  multiply<H>(L, before, x, acc);
  solve_triangle<H>(L + H * before, x + before, acc);
}

template <int H, class Row>
BATTEN_INLINE void forward_below(const double* L, long width, const Row* x, const int* targets,
                                 Row* work) {
  Row acc[H] = {};
  multiply<H>(L, width, x, acc);
  for (int i = 0; i < H; ++i) work[targets[i]] -= acc[i];
}

template <int H, class Row>
BATTEN_INLINE void backward_below(const double* L, long width, Row* x, const int* targets,
                                  const Row* work) {
  Row y[H];
  for (int i = 0; i < H; ++i) y[i] = work[targets[i]];
  multiply_transposed<H>(L, width, x, y);
}

template <int H, class Row>
BATTEN_INLINE void backward_diagonal(const double* L, long before, Row* x) {
  Row y[H];
  for (int i = 0; i < H; ++i) y[i] = x[before + i];
  solve_triangle_transposed<H>(L + H * before, y);
  for (int i = 0; i < H; ++i) x[before + i] = y[i];
  multiply_transposed<H>(L, before, x, y);
}

#define BATTEN_CALL [&](auto height) __attribute__((always_inline))

// `visit`: the supernodes to visit, or null for all.
template <class Row>
BATTEN_INLINE void forward(const PackedSupernodes& all, int first, int end, const char* visit,
                           Row* work) {
  for (int s = first; s < end; ++s) {
    if (visit && !visit[s]) continue;
    Row* x = work + all.columns[s];
    const int width = all.columns[s + 1] - all.columns[s];
    const double* L = all.values + all.starts[s];
    int q = 0;
    for (; q + panel <= width; L += panel * (q + panel), q += panel)
      forward_diagonal<panel>(L, q, x);
    with_constant<panel - 1>(
        width - q, BATTEN_CALL { forward_diagonal<height()>(L, q, x); });
    L += (width - q) * static_cast<long>(width);

    const int* target = all.targets + all.row_starts[s] + width;
    const int* last = all.targets + all.row_starts[s + 1];
    for (; last - target >= panel; target += panel, L += panel * static_cast<long>(width))
      forward_below<panel>(L, width, x, target, work);
    with_constant<panel - 1>(
        static_cast<int>(last - target),
        BATTEN_CALL { forward_below<height()>(L, width, x, target, work); });
  }
}

template <class Row>
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
    with_constant<panel - 1>(
        below % panel, BATTEN_CALL {
          backward_below<height()>(L, width, x, target + below / panel * panel, work);
        });
    for (int t = below / panel * panel - panel; t >= 0; t -= panel) {
      L -= panel * static_cast<long>(width);
      backward_below<panel>(L, width, x, target + t, work);
    }
    int q = width / panel * panel;
    L -= (width - q) * static_cast<long>(width);
    with_constant<panel - 1>(
        width - q, BATTEN_CALL { backward_diagonal<height()>(L, q, x); });
    while (q > 0) {
      L -= panel * q;
      q -= panel;
      backward_diagonal<panel>(L, q, x);
    }
  }
}

#undef BATTEN_CALL

}  // namespace

BATTEN_CLONES void sweep_forward(const PackedSupernodes& all, int first, int end, const char* visit,
                                 Row4* work) {
  forward(all, first, end, visit, work);
}
BATTEN_CLONES void sweep_forward(const PackedSupernodes& all, int first, int end, const char* visit,
                                 Row8* work) {
  forward(all, first, end, visit, work);
}
BATTEN_CLONES void sweep_backward(const PackedSupernodes& all, int first, int end,
                                  const char* visit, Row4* work) {
  backward(all, first, end, visit, work);
}
BATTEN_CLONES void sweep_backward(const PackedSupernodes& all, int first, int end,
                                  const char* visit, Row8* work) {
  backward(all, first, end, visit, work);
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
