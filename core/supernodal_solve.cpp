#include "batten/core/supernodal_solve.h"

#include <algorithm>
#include <cassert>
#include <functional>
#include <numeric>
#include <thread>

#include "batten/core/errors.h"
#include "batten/core/huge_pages.h"
#include "batten/core/parallel.h"
#include "batten/core/simd.h"

namespace batten {
namespace {

constexpr int panel = 8;  // rows of a panel: as many vectors as every machine has registers for
constexpr int prefetch_bytes = 8192;

// One row of the work vector.
using Row4 = double __attribute__((vector_size(32)));
using Row8 = double __attribute__((vector_size(64)));

template <class Row>
constexpr int lanes_of = sizeof(Row) / sizeof(double);

struct Blocks {
  const int* columns;
  const int* row_starts;
  const long* starts;
  const int* targets;
  const double* values;
};

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

// call(n) with n, 1 … most, as a constant; nothing for 0.
template <int most, class Call>
BATTEN_INLINE void with_constant(int n, const Call& call) {
  if constexpr (most > 0) {
    if (n == most)
      call(std::integral_constant<int, most>());
    else
      with_constant<most - 1>(n, call);
  }
}

#define BATTEN_CALL [&](auto height) __attribute__((always_inline))

// `visit`: the supernodes to visit, or null for all.
template <class Row>
BATTEN_INLINE void forward(const Blocks& b, int first, int end, const char* visit, Row* work) {
  for (int s = first; s < end; ++s) {
    if (visit && !visit[s]) continue;
    Row* x = work + b.columns[s];
    const int width = b.columns[s + 1] - b.columns[s];
    const double* L = b.values + b.starts[s];
    int q = 0;
    for (; q + panel <= width; L += panel * (q + panel), q += panel)
      forward_diagonal<panel>(L, q, x);
    with_constant<panel - 1>(
        width - q, BATTEN_CALL { forward_diagonal<height()>(L, q, x); });
    L += (width - q) * static_cast<long>(width);

    const int* target = b.targets + b.row_starts[s] + width;
    const int* last = b.targets + b.row_starts[s + 1];
    for (; last - target >= panel; target += panel, L += panel * static_cast<long>(width))
      forward_below<panel>(L, width, x, target, work);
    with_constant<panel - 1>(
        static_cast<int>(last - target),
        BATTEN_CALL { forward_below<height()>(L, width, x, target, work); });
  }
}

template <class Row>
BATTEN_INLINE void backward(const Blocks& b, int first, int end, const char* visit, Row* work) {
  for (int s = end - 1; s >= first; --s) {
    if (visit && !visit[s]) continue;
    Row* x = work + b.columns[s];
    const int width = b.columns[s + 1] - b.columns[s];
    const int* target = b.targets + b.row_starts[s] + width;
    const int below = static_cast<int>(b.targets + b.row_starts[s + 1] - target);
    const double* L = b.values + b.starts[s] + triangle_size(width) +
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

BATTEN_CLONES void sweep_forward(const Blocks& b, int first, int end, const char* visit,
                                 Row4* work) {
  forward(b, first, end, visit, work);
}
BATTEN_CLONES void sweep_forward(const Blocks& b, int first, int end, const char* visit,
                                 Row8* work) {
  forward(b, first, end, visit, work);
}
BATTEN_CLONES void sweep_backward(const Blocks& b, int first, int end, const char* visit,
                                  Row4* work) {
  backward(b, first, end, visit, work);
}
BATTEN_CLONES void sweep_backward(const Blocks& b, int first, int end, const char* visit,
                                  Row8* work) {
  backward(b, first, end, visit, work);
}

// The block of r rows and w columns as panels, with inverted diagonal; what is above it in a
// panel is never used. Returns the end.
double* pack_block(const double* block, long r, long w, double* to) {
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

template <class Row>
void load_rows(const double* x, long stride, int columns, const int* order, Row* row, Row* end) {
  with_constant<lanes_of<Row>>(columns, [&](auto n) {
    for (const int* from = order; row < end; ++row, ++from) {
      Row together{};
      for (int k = 0; k < n(); ++k) together[k] = x[*from + k * stride];
      *row = together;
    }
  });
}

template <class Row>
void store_rows(const Row* row, const Row* end, const int* order, int columns, double* x,
                long stride) {
  with_constant<lanes_of<Row>>(columns, [&](auto n) {
    for (const int* to = order; row < end; ++row, ++to)
      for (int k = 0; k < n(); ++k) x[*to + k * stride] = (*row)[k];
  });
}

void wait_a_moment(int& patience) {
  if (--patience > 0) {
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
  } else {
    std::this_thread::yield();
  }
}

}  // namespace

void SupernodalSolve::analyze(const SupernodalPattern& L, const int* order) {
  static std::atomic<long> analyses{0};
  analysis_ = ++analyses;
  n_ = L.columns[L.count];
  columns_.assign(L.columns, L.columns + L.count + 1);
  row_starts_.assign(L.row_starts, L.row_starts + L.count + 1);
  value_starts_.assign(L.value_starts, L.value_starts + L.count + 1);
  order_.assign(order, order + n_);
  packed_starts_.assign(L.count, 0);
  values_ = nullptr;
  entries_ = 0;
  parents_.assign(L.count, -1);
  std::vector<int> supernode_of(n_);
  for (int s = 0; s < L.count; ++s)
    std::fill(supernode_of.begin() + columns_[s], supernode_of.begin() + columns_[s + 1], s);
  for (int s = 0; s < L.count; ++s) {
    const long w = columns_[s + 1] - columns_[s], r = row_starts_[s + 1] - row_starts_[s];
    if (r > w) parents_[s] = supernode_of[L.rows[row_starts_[s] + w]];
    entries_ += block_entries(s);
  }
  cut_into_chunks();
  find_boundaries(L.rows);
  work_lanes_ = 0;
  make_room(4);
  pending_ = std::make_unique<std::atomic<int>[]>(chunks_.size());
}

// Subtrees that are small enough become one chunk. A supernode above them is a chunk of its own,
// which takes in the small chunks right before it, and along a spine (one large child, small ones
// beside it) also the chunk of that child. Then neighbouring subtrees under the same chunk are
// joined.
void SupernodalSolve::cut_into_chunks() {
  const auto count = static_cast<int>(parents_.size());
  // So many parts keep a few threads busy; the rows of so many columns stay in a second-level
  // cache. Nothing here may depend on the number of threads.
  const long most_entries = std::max(entries_ / 24, 16384L);
  const long little = most_entries / 8;
  constexpr int most_columns = 8192;
  std::vector<long> own(count), below(count, 0), largest_child(count, 0);
  std::vector<int> first(count);
  std::iota(first.begin(), first.end(), 0);
  for (int s = 0; s < count; ++s) {
    own[s] = block_entries(s);
    below[s] += own[s];
    if (const int p = parents_[s]; p >= 0) {
      below[p] += below[s];
      largest_child[p] = std::max(largest_child[p], below[s]);
      first[p] = std::min(first[p], first[s]);
    }
  }
  const auto small = [&](int s) {
    return s >= 0 && below[s] <= most_entries &&
           columns_[s + 1] - columns_[first[s]] <= most_columns;
  };
  struct Piece {
    int first, end;  // supernodes
    long entries;
    bool subtree;  // nothing is below it
  };
  std::vector<Piece> pieces;
  const auto fits = [&](long entries, int end) {
    return !pieces.empty() && pieces.back().entries + entries <= most_entries &&
           columns_[end] - columns_[pieces.back().first] <= most_columns;
  };
  for (int s = 0; s < count; ++s) {
    if (small(s)) {
      if (!small(parents_[s])) pieces.push_back({first[s], s + 1, below[s], true});
      continue;
    }
    const bool spine = below[s] - own[s] - largest_child[s] <= little;
    Piece piece{s, s + 1, own[s], false};
    while (fits(piece.entries, piece.end) && pieces.back().first >= first[s] &&
           (spine || pieces.back().entries <= little)) {
      piece.first = pieces.back().first;
      piece.entries += pieces.back().entries;
      pieces.pop_back();
    }
    pieces.push_back(piece);
  }

  std::vector<int> piece_of(count);
  for (size_t i = 0; i < pieces.size(); ++i)
    std::fill(piece_of.begin() + pieces[i].first, piece_of.begin() + pieces[i].end,
              static_cast<int>(i));
  const auto above = [&](const Piece& piece) {
    const int p = parents_[piece.end - 1];
    return p < 0 ? -1 : piece_of[p];
  };
  std::vector<Piece> all;
  all.swap(pieces);
  for (const Piece& piece : all) {
    if (piece.subtree && fits(piece.entries, piece.end) && pieces.back().subtree &&
        above(pieces.back()) == above(piece)) {
      pieces.back().end = piece.end;
      pieces.back().entries += piece.entries;
    } else {
      pieces.push_back(piece);
    }
  }
  chunks_.clear();
  std::vector<long> sizes;
  for (const Piece& piece : pieces) {
    chunks_.push_back({});
    chunks_.back().first_supernode = piece.first;
    chunks_.back().first_column = columns_[piece.first];
    chunks_.back().end_supernode = piece.end;
    chunks_.back().end_column = columns_[piece.end];
    sizes.push_back(piece.entries);
  }
  relate_chunks(sizes);
}

// Parents, children, the order for several threads.
void SupernodalSolve::relate_chunks(const std::vector<long>& sizes) {
  const auto chunks = static_cast<int>(chunks_.size());
  std::vector<int> chunk_of(parents_.size()), level(chunks, 0);
  for (int c = 0; c < chunks; ++c)
    std::fill(chunk_of.begin() + chunks_[c].first_supernode,
              chunk_of.begin() + chunks_[c].end_supernode, c);
  for (int c = 0; c < chunks; ++c) {
    const int p = parents_[chunks_[c].end_supernode - 1];
    chunks_[c].parent = p < 0 ? -1 : chunk_of[p];
    if (p >= 0) level[chunk_of[p]] = std::max(level[chunk_of[p]], level[c] + 1);
  }
  children_.clear();
  std::vector<std::vector<int>> children(chunks);
  for (int c = 0; c < chunks; ++c)
    if (chunks_[c].parent >= 0) children[chunks_[c].parent].push_back(c);
  for (int c = 0; c < chunks; ++c) {
    chunks_[c].first_child = static_cast<int>(children_.size());
    children_.insert(children_.end(), children[c].begin(), children[c].end());
    chunks_[c].end_child = static_cast<int>(children_.size());
  }
  std::vector<long> path(chunks, 0);  // entries that are read one after the other, whoever helps
  long longest = 0;
  for (int c = 0; c < chunks; ++c) {
    path[c] += sizes[c];
    longest = std::max(longest, path[c]);
    if (const int p = chunks_[c].parent; p >= 0) path[p] = std::max(path[p], path[c]);
  }
  // Handing a chunk over costs about as much as reading this many entries.
  constexpr long worth_a_chunk = 10000;
  splits_ = 3 * longest < 2 * entries_ && entries_ >= worth_a_chunk * chunks;
  // Level by level, so that nobody has to wait long; any order from children to parents would do.
  schedule_.resize(chunks);
  std::iota(schedule_.begin(), schedule_.end(), 0);
  std::stable_sort(schedule_.begin(), schedule_.end(),
                   [&](int a, int b) { return level[a] < level[b]; });
}

void SupernodalSolve::find_boundaries(const int* rows) {
  targets_.resize(row_starts_.empty() ? 0 : row_starts_.back());
  std::vector<int> place(n_, -1), boundary, all;
  for (Chunk& chunk : chunks_) {
    boundary.clear();
    const int first = row_starts_[chunk.first_supernode], end = row_starts_[chunk.end_supernode];
    for (int i = first; i < end; ++i)
      if (rows[i] >= chunk.end_column && place[rows[i]] < 0) {
        place[rows[i]] = 0;
        boundary.push_back(rows[i]);
      }
    std::sort(boundary.begin(), boundary.end());
    chunk.first_boundary = static_cast<int>(all.size());
    for (const int row : boundary) {
      place[row] = n_ + static_cast<int>(all.size());
      all.push_back(row);
    }
    chunk.end_boundary = static_cast<int>(all.size());
    for (int i = first; i < end; ++i)
      targets_[i] = rows[i] < chunk.end_column ? rows[i] : place[rows[i]];
    for (const int row : boundary) place[row] = -1;
  }
  // A row that a chunk passes on is the parent's own or is passed on again.
  boundary_targets_.resize(all.size());
  for (const Chunk& chunk : chunks_) {
    for (int e = chunk.first_boundary; e < chunk.end_boundary; ++e) place[all[e]] = n_ + e;
    for (int c = chunk.first_child; c < chunk.end_child; ++c) {
      const Chunk& child = chunks_[children_[c]];
      for (int e = child.first_boundary; e < child.end_boundary; ++e) {
        boundary_targets_[e] = all[e] < chunk.end_column ? all[e] : place[all[e]];
        assert(boundary_targets_[e] >= 0);
      }
    }
    for (int e = chunk.first_boundary; e < chunk.end_boundary; ++e) place[all[e]] = -1;
  }
}

void SupernodalSolve::pack(double* values) {
  double* to = values;  // never ahead of what is still to be read
  std::vector<double> block;
  for (size_t s = 0; s < parents_.size(); ++s) {
    const long r = row_starts_[s + 1] - row_starts_[s], w = columns_[s + 1] - columns_[s];
    block.assign(values + value_starts_[s], values + value_starts_[s] + r * w);
    packed_starts_[s] = to - values;
    to = pack_block(block.data(), r, w, to);
  }
  values_ = values;
}

template <class Row>
void SupernodalSolve::solve_group(const SolvePart* part, double* x, long stride,
                                  int columns) const {
  // Vectors start at multiples of their size.
  const auto address = reinterpret_cast<std::uintptr_t>(work_.get());
  Row* work = reinterpret_cast<Row*>((address + sizeof(Row) - 1) / sizeof(Row) * sizeof(Row));
  const Blocks blocks{columns_.data(), row_starts_.data(), packed_starts_.data(), targets_.data(),
                      values_};
  const auto forward_chunk = [&](int c) {
    const Chunk& chunk = chunks_[c];
    if (part && !part->chunk_forward[c]) {
      if (part->chunk_backward[c])
        std::fill(work + chunk.first_column, work + chunk.end_column, Row{});
      return;
    }
    load_rows(x, stride, columns, order_.data() + chunk.first_column, work + chunk.first_column,
              work + chunk.end_column);
    std::fill(work + n_ + chunk.first_boundary, work + n_ + chunk.end_boundary, Row{});
    for (int i = chunk.first_child; i < chunk.end_child; ++i) {
      const Chunk& child = chunks_[children_[i]];
      if (part && !part->chunk_forward[children_[i]]) continue;
      for (int e = child.first_boundary; e < child.end_boundary; ++e)
        work[boundary_targets_[e]] += work[n_ + e];
    }
    sweep_forward(blocks, chunk.first_supernode, chunk.end_supernode,
                  part ? part->forward.data() : nullptr, work);
  };
  const auto backward_chunk = [&](int c) {
    const Chunk& chunk = chunks_[c];
    if (part && !part->chunk_backward[c]) return;
    for (int e = chunk.first_boundary; e < chunk.end_boundary; ++e)
      work[n_ + e] = work[boundary_targets_[e]];
    sweep_backward(blocks, chunk.first_supernode, chunk.end_supernode,
                   part ? part->backward.data() : nullptr, work);
    store_rows(work + chunk.first_column, work + chunk.end_column,
               order_.data() + chunk.first_column, columns, x, stride);
  };

  const auto count = static_cast<int>(chunks_.size());
  const int threads = threads_for(part ? part->entries / 2 : entries_);
  if (threads == 1) {
    for (int c = 0; c < count; ++c) forward_chunk(c);
    for (int c = count - 1; c >= 0; --c) backward_chunk(c);
    return;
  }
  // One list for both sweeps: the schedule and then the schedule from its end. Whoever takes an
  // item waits for what it depends on, which was taken before it.
  constexpr int forward_done = -1, backward_done = -2;
  for (int c = 0; c < count; ++c)
    pending_[c].store(chunks_[c].end_child - chunks_[c].first_child, std::memory_order_relaxed);
  std::atomic<int> next{0};
  const auto wait_for = [&](int c, int state) {
    int patience = 2000;
    while (pending_[c].load(std::memory_order_acquire) != state) wait_a_moment(patience);
  };
  const auto work_off = [&](int) {
    for (int i = next++; i < 2 * count; i = next++) {
      if (i < count) {
        const int c = schedule_[i];
        wait_for(c, 0);
        forward_chunk(c);
        pending_[c].store(forward_done, std::memory_order_release);
        if (chunks_[c].parent >= 0)
          pending_[chunks_[c].parent].fetch_sub(1, std::memory_order_acq_rel);
      } else {
        const int c = schedule_[2 * count - 1 - i];
        const int parent = chunks_[c].parent;
        if (parent >= 0)
          wait_for(parent, backward_done);
        else
          wait_for(c, forward_done);
        backward_chunk(c);
        pending_[c].store(backward_done, std::memory_order_release);
      }
    }
  };
  parallel_parts(threads, std::ref(work_off));
}

void SupernodalSolve::solve_part(const SolvePart* part, Eigen::Ref<MatX> x) const {
  for (long c = 0; c < x.cols();) {
    const int columns = static_cast<int>(std::min(x.cols() - c, x.cols() - c > 4 ? 8L : 4L));
    double* first = x.data() + c * x.outerStride();
    if (columns > 4) {
      make_room(8);
      solve_group<Row8>(part, first, x.outerStride(), columns);
    } else {
      solve_group<Row4>(part, first, x.outerStride(), columns);
    }
    c += columns;
  }
}

void SupernodalSolve::solve(Eigen::Ref<MatX> x) const { solve_part(nullptr, x); }

void SupernodalSolve::solve(const SolvePart& part, Eigen::Ref<MatX> x) const {
  if (part.analysis != analysis_)
    throw InputError("part of a solve: it was made for another analysis");
  solve_part(&part, x);
}

SolvePart SupernodalSolve::part(const std::optional<std::vector<int>>& nonzero,
                                const std::optional<std::vector<int>>& wanted) const {
  const auto supernodes = static_cast<int>(parents_.size());
  const auto with_ancestors = [&](const std::optional<std::vector<int>>& unknowns) {
    std::vector<char> visit(supernodes, !unknowns);
    if (!unknowns) return visit;
    std::vector<char> given(n_, 0);
    for (const int unknown : *unknowns) {
      if (unknown < 0 || unknown >= n_)
        throw InputError("part of a solve: there is no unknown " + std::to_string(unknown) +
                         ", the matrix has " + std::to_string(n_));
      given[unknown] = 1;
    }
    for (int s = 0; s < supernodes; ++s) {
      for (int i = columns_[s]; i < columns_[s + 1] && !visit[s]; ++i) visit[s] = given[order_[i]];
      if (visit[s] && parents_[s] >= 0) visit[parents_[s]] = 1;
    }
    return visit;
  };
  SolvePart result;
  result.forward = with_ancestors(nonzero);
  result.backward = with_ancestors(wanted);
  result.analysis = analysis_;
  const auto of_chunks = [&](const std::vector<char>& visit) {
    std::vector<char> chunks(chunks_.size(), 0);
    for (size_t c = 0; c < chunks_.size(); ++c)
      for (int s = chunks_[c].first_supernode; s < chunks_[c].end_supernode; ++s)
        if (visit[s]) {
          chunks[c] = 1;
          result.entries += block_entries(s);
        }
    return chunks;
  };
  result.chunk_forward = of_chunks(result.forward);
  result.chunk_backward = of_chunks(result.backward);
  return result;
}

long SupernodalSolve::block_entries(int s) const {
  const long w = columns_[s + 1] - columns_[s], r = row_starts_[s + 1] - row_starts_[s];
  return w * (w + 1) / 2 + (r - w) * w;
}

int SupernodalSolve::threads_for(long entries) const {
  // Waking a thread takes up to 50 µs, and its caches are cold: less is not worth it.
  constexpr long worth_a_thread = 500000;
  if (!splits_ || entries < worth_a_thread) return 1;
  // A thread without a core would only make the others wait.
  return std::min({thread_count(), core_count(), chunk_count()});
}

void SupernodalSolve::make_room(int lanes) const {
  if (work_lanes_ >= lanes) return;
  const size_t size = (n_ + boundary_targets_.size() + 1) * lanes;
  work_ = std::make_unique_for_overwrite<double[]>(size);
  work_lanes_ = lanes;
  advise_huge_pages(work_.get(), size * sizeof(double));
}

}  // namespace batten
