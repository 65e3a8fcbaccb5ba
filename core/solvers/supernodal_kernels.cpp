// SPDX-License-Identifier: MPL-2.0
#include "batten/core/solvers/supernodal_kernels.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "batten/core/simd.h"

namespace batten {

// Factorization.

namespace {

template <class Vector>
constexpr int lanes_of = sizeof(Vector) / sizeof(double);
// Columns of a tile. With three row vectors per tile, the sums and their operands fill the vector
// registers: 32 registers of 512 bits, otherwise 16.
template <class Vector>
constexpr int columns_of = lanes_of<Vector> == 8 ? 8 : 4;

template <class Vector>
BATTEN_INLINE void load(Vector& v, const double* from) {
  std::memcpy(&v, from, sizeof v);
}
template <class Vector>
BATTEN_INLINE void store(const Vector& v, double* to) {
  std::memcpy(to, &v, sizeof v);
}

// sum_ji -= Σ_k a_ik b_jk, where i runs over H vectors of rows. Explicit prefetching helps because
// hardware prefetchers do not follow accesses from column to column, each on a different page.
template <class Vector, int H, int W>
BATTEN_INLINE void subtract(const double* a, long a_stride, const double* b, long b_stride,
                            long depth, Vector (&sum)[W][H]) {
  for (long k = 0; k < depth; ++k, a += a_stride, b += b_stride) {
    const char* ahead = reinterpret_cast<const char*>(a + 12 * a_stride);
    for (int line = 0; line < static_cast<int>(H * sizeof(Vector) + 63) / 64; ++line)
      __builtin_prefetch(ahead + 64 * line);
    Vector ak[H];
#pragma GCC unroll 8
    for (int h = 0; h < H; ++h) load(ak[h], a + h * lanes_of<Vector>);
#pragma GCC unroll 8
    for (int j = 0; j < W; ++j)
#pragma GCC unroll 8
      for (int h = 0; h < H; ++h) sum[j][h] -= ak[h] * b[j];
  }
}

// Copies `rows` rows of a block to `to`, padded with zeros to the length of a vector.
template <class Vector>
BATTEN_INLINE void gather_rows(const double* from, long stride, int rows, long columns,
                               double* to) {
  constexpr int lanes = lanes_of<Vector>;
  std::fill(to, to + lanes * columns, 0.0);
  for (long k = 0; k < columns; ++k)
    for (int i = 0; i < rows; ++i) to[k * lanes + i] = from[k * stride + i];
}
template <class Vector>
BATTEN_INLINE void scatter_rows(const double* from, double* to, long stride, int rows, long first,
                                long end) {
  for (long k = first; k < end; ++k)
    for (int i = 0; i < rows; ++i) to[k * stride + i] = from[k * lanes_of<Vector> + i];
}

#define BATTEN_CALL [&](auto number) __attribute__((always_inline))

// Calls call(column, width) for tiles that cover all columns.
template <int W, class Call>
BATTEN_INLINE void for_tiles(int first, int end, const Call& call) {
  int column = first;
  for (; column + W <= end; column += W) call(column, std::integral_constant<int, W>());
  dispatch_constant<W - 1>(
      end - column, BATTEN_CALL { call(column, number); });
}

// Calls call(row, height) for strips of three row vectors, then of two or one. Returns the first
// row that does not fill a vector.
template <class Vector, class Call>
BATTEN_INLINE int for_strips(int first, int end, const Call& call) {
  constexpr int lanes = lanes_of<Vector>;
  int row = first;
  for (; row + 3 * lanes <= end; row += 3 * lanes) call(row, std::integral_constant<int, 3>());
  const int vectors = (end - row) / lanes;
  dispatch_constant<2>(
      vectors, BATTEN_CALL { call(row, number); });
  return row + vectors * lanes;
}

template <class Vector, int H, int W>
BATTEN_INLINE void product_tile(const ScatteredProduct& p, const double* a, long a_stride, int row,
                                int column) {
  constexpr int lanes = lanes_of<Vector>;
  Vector sum[W][H] = {};
  subtract(a, a_stride, p.b + column, p.stride, p.depth, sum);
  for (int h = 0; h < H; ++h) {
    const int* place = p.row_positions + row + h * lanes;
    const int rows = std::min(lanes, p.rows - row - h * lanes);
    const bool together = rows == lanes && place[lanes - 1] - place[0] == lanes - 1;
#pragma GCC unroll 8
    for (int j = 0; j < W; ++j) {
      double* c = p.c + p.column_positions[column + j] * p.c_stride;
      if (together) {
        Vector old;
        load(old, c + place[0]);
        store(old + sum[j][h], c + place[0]);
      } else {
        double s[lanes];
        store(sum[j][h], s);
        for (int i = 0; i < rows; ++i) c[place[i]] += s[i];
      }
    }
  }
}

template <class Vector, int H>
BATTEN_INLINE void product_strip(const ScatteredProduct& p, const double* a, long a_stride,
                                 int row) {
  // Columns to the right of all rows of the strip belong to the upper triangle and are skipped.
  const int last = p.row_positions[std::min(row + H * lanes_of<Vector>, p.rows) - 1];
  int end = p.columns;
  while (end > 0 && p.column_positions[end - 1] > last) --end;
  for_tiles<columns_of<Vector>>(
      0, end, [&](int column, auto W) __attribute__((always_inline)) {
        product_tile<Vector, H, W()>(p, a, a_stride, row, column);
      });
}

template <class Vector>
BATTEN_INLINE void product(const ScatteredProduct& p, double* scratch) {
  const int row = for_strips<Vector>(
      0, p.rows, [&](int first, auto H) __attribute__((always_inline)) {
        product_strip<Vector, H()>(p, p.a + first, p.stride, first);
      });
  if (row == p.rows) return;
  gather_rows<Vector>(p.a + row, p.stride, p.rows - row, p.depth, scratch);
  product_strip<Vector, 1>(p, scratch, lanes_of<Vector>, row);
}

// x L_JJᵀ = x - (columns before J) L_J,beforeᵀ, for rows of x and the W columns J that begin at
// `first`.
template <class Vector, int H, int W>
BATTEN_INLINE void solve_tile(const double* block, long stride, int first, const double* inverse,
                              double* x, long x_stride) {
  constexpr int lanes = lanes_of<Vector>;
  Vector sum[W][H];
  double* to = x + first * x_stride;
#pragma GCC unroll 8
  for (int j = 0; j < W; ++j)
#pragma GCC unroll 8
    for (int h = 0; h < H; ++h) load(sum[j][h], to + j * x_stride + h * lanes);
  subtract(x, x_stride, block + first, stride, first, sum);
  const double* L = block + first + first * stride;
#pragma GCC unroll 8
  for (int k = 0; k < W; ++k)
#pragma GCC unroll 8
    for (int h = 0; h < H; ++h) {
      sum[k][h] *= inverse[k];
      store(sum[k][h], to + k * x_stride + h * lanes);
#pragma GCC unroll 8
      for (int j = k + 1; j < W; ++j) sum[j][h] -= sum[k][h] * L[j + k * stride];
    }
}

template <class Vector, int H>
BATTEN_INLINE void solve_strip(const double* block, long stride, int first, int end,
                               const double* inverse, double* x, long x_stride) {
  for_tiles<columns_of<Vector>>(
      first, end, [&](int column, auto W) __attribute__((always_inline)) {
        solve_tile<Vector, H, W()>(block, stride, column, inverse + (column - first), x, x_stride);
      });
}

template <class Vector>
BATTEN_INLINE void solve(double* block, long stride, int first_row, int end_row, int first, int end,
                         double* scratch) {
  double inverse[kBlockColumns];
  for (int k = first; k < end; ++k) inverse[k - first] = 1 / block[k + k * stride];
  const int row = for_strips<Vector>(
      first_row, end_row, [&](int strip, auto H) __attribute__((always_inline)) {
        solve_strip<Vector, H()>(block, stride, first, end, inverse, block + strip, stride);
      });
  if (row == end_row) return;
  gather_rows<Vector>(block + row, stride, end_row - row, end, scratch);
  solve_strip<Vector, 1>(block, stride, first, end, inverse, scratch, lanes_of<Vector>);
  scatter_rows<Vector>(scratch, block + row, stride, end_row - row, first, end);
}

// Cholesky factorization of a tile; each column is one vector. Returns the first column whose pivot
// fails, or `count`.
template <class Vector>
BATTEN_INLINE int factor_tile(Vector (&x)[lanes_of<Vector>], int count) {
  for (int k = 0; k < count; ++k) {
    const double pivot = x[k][k];
    if (!(pivot > 0)) return k;
    const double root = std::sqrt(pivot), inverse = 1 / root;
    x[k] *= inverse;
    x[k][k] = root;
    for (int j = k + 1; j < count; ++j) x[j] -= x[k] * x[k][j];
  }
  return count;
}

// Processes as many columns at a time as a vector has lanes, so that each column of their triangle
// is one vector.
template <class Vector>
BATTEN_INLINE int triangle(double* block, long stride, int first, int end, double* scratch) {
  constexpr int lanes = lanes_of<Vector>;
  for (int column = first; column < end; column += lanes) {
    const int count = std::min(lanes, end - column);
    gather_rows<Vector>(block + column, stride, count, column + count, scratch);
    Vector x[lanes] = {};
    for (int j = 0; j < count; ++j) load(x[j], scratch + (column + j) * lanes);
    Vector sum[lanes][1];
    for (int j = 0; j < lanes; ++j) sum[j][0] = x[j];
    subtract(scratch, lanes, scratch, lanes, column, sum);
    for (int j = 0; j < lanes; ++j) x[j] = sum[j][0];
    const int good = factor_tile(x, count);
    if (good < count) return column + good;
    for (int j = 0; j < count; ++j)
      for (int i = j; i < count; ++i) block[column + i + (column + j) * stride] = x[j][i];
    solve<Vector>(block, stride, column + count, end, column, column + count, scratch);
  }
  return -1;
}

#undef BATTEN_CALL

using Vector2 = double __attribute__((vector_size(16)));
using Vector4 = double __attribute__((vector_size(32)));
using Vector8 = double __attribute__((vector_size(64)));

struct Kernels {
  void (*product)(const ScatteredProduct&, double*);
  int (*triangle)(double*, long, int, int, double*);
  void (*solve)(double*, long, int, int, int, int, double*);
};

#define BATTEN_KERNELS(name, attribute, Vector)                                                    \
  attribute void product_##name(const ScatteredProduct& p, double* scratch) {                      \
    product<Vector>(p, scratch);                                                                   \
  }                                                                                                \
  attribute int triangle_##name(double* block, long stride, int first, int end, double* scratch) { \
    return triangle<Vector>(block, stride, first, end, scratch);                                   \
  }                                                                                                \
  attribute void solve_##name(double* block, long stride, int first_row, int end_row, int first,   \
                              int end, double* scratch) {                                          \
    solve<Vector>(block, stride, first_row, end_row, first, end, scratch);                         \
  }                                                                                                \
  constexpr Kernels name = {product_##name, triangle_##name, solve_##name};

BATTEN_KERNELS(kernels_with_128_bits, , Vector2)
#ifdef BATTEN_WIDE_VECTORS
BATTEN_KERNELS(kernels_with_256_bits, BATTEN_256_BITS, Vector4)
BATTEN_KERNELS(kernels_with_512_bits, BATTEN_512_BITS, Vector8)
#endif
#undef BATTEN_KERNELS

const Kernels& kernels() {
#ifdef BATTEN_WIDE_VECTORS
  return select_kernels(kernels_with_128_bits, kernels_with_256_bits, kernels_with_512_bits);
#else
  return select_kernels(kernels_with_128_bits);
#endif
}

}  // namespace

void subtract_product(const ScatteredProduct& product, double* scratch) {
  kernels().product(product, scratch);
}
int factor_triangle(double* block, long stride, int first, int end, double* scratch) {
  return kernels().triangle(block, stride, first, end, scratch);
}
void solve_rows(double* block, long stride, int first_row, int end_row, int first, int end,
                double* scratch) {
  kernels().solve(block, stride, first_row, end_row, first, end, scratch);
}

// Triangular solves.

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

template <class Row>
using Sweep = void (*)(const PackedSupernodes&, int, int, const char*, Row*);
struct Sweeps {
  Sweep<Row4> forward4, backward4;
  Sweep<Row8> forward8, backward8;
};

// Sweeps for one generation of vector units. `attribute`: target for the compiler; For4, For8:
// vector types for rows of 4 and 8.
#define BATTEN_SWEEPS(name, attribute, For4, For8)                                 \
  attribute void forward4_##name(const PackedSupernodes& all, int first, int end,  \
                                 const char* visit, Row4* work) {                  \
    forward<For4>(all, first, end, visit, work);                                   \
  }                                                                                \
  attribute void backward4_##name(const PackedSupernodes& all, int first, int end, \
                                  const char* visit, Row4* work) {                 \
    backward<For4>(all, first, end, visit, work);                                  \
  }                                                                                \
  attribute void forward8_##name(const PackedSupernodes& all, int first, int end,  \
                                 const char* visit, Row8* work) {                  \
    forward<For8>(all, first, end, visit, work);                                   \
  }                                                                                \
  attribute void backward8_##name(const PackedSupernodes& all, int first, int end, \
                                  const char* visit, Row8* work) {                 \
    backward<For8>(all, first, end, visit, work);                                  \
  }                                                                                \
  constexpr Sweeps name = {forward4_##name, backward4_##name, forward8_##name, backward8_##name};

BATTEN_SWEEPS(sweeps_with_128_bits, , Vector2, Vector2)
#ifdef BATTEN_WIDE_VECTORS
BATTEN_SWEEPS(sweeps_with_256_bits, BATTEN_256_BITS, Vector4, Vector4)
BATTEN_SWEEPS(sweeps_with_512_bits, BATTEN_512_BITS, Vector4, Vector8)
#endif
#undef BATTEN_SWEEPS

const Sweeps& sweeps() {
#ifdef BATTEN_WIDE_VECTORS
  return select_kernels(sweeps_with_128_bits, sweeps_with_256_bits, sweeps_with_512_bits);
#else
  return select_kernels(sweeps_with_128_bits);
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
