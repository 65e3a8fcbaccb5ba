// SPDX-License-Identifier: MPL-2.0
#include "batten/core/solvers/supernodal_solve.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <functional>
#include <numeric>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/core/simd.h"
#include "batten/core/solvers/supernodal_kernels.h"

namespace batten {
namespace {

template <class Row>
constexpr int lanes_of = sizeof(Row) / sizeof(double);

template <class Row>
void load_rows(const double* x, long stride, int columns, const int* order, Row* row, Row* end) {
  dispatch_constant<lanes_of<Row>>(columns, [&](auto n) {
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
  dispatch_constant<lanes_of<Row>>(columns, [&](auto n) {
    for (const int* to = order; row < end; ++row, ++to)
      for (int k = 0; k < n(); ++k) x[*to + k * stride] = (*row)[k];
  });
}

}  // namespace

SupernodalSolve::SupernodalSolve(const SupernodalPattern& L, const int* order)
    : n_(L.columns[L.count]),
      order_(order, order + n_),
      columns_(L.columns, L.columns + L.count + 1),
      row_starts_(L.row_starts, L.row_starts + L.count + 1),
      value_starts_(L.value_starts, L.value_starts + L.count + 1),
      packed_starts_(L.count),
      parents_(L.count, -1) {
  static std::atomic<long> analyses{0};
  analysis_ = ++analyses;
  std::vector<int> supernode_of(n_);
  for (int s = 0; s < L.count; ++s)
    std::fill(supernode_of.begin() + columns_[s], supernode_of.begin() + columns_[s + 1], s);
  for (int s = 0; s < L.count; ++s) {
    poll_every<4096>(s);
    const int first_below = row_starts_[s] + columns_[s + 1] - columns_[s];
    if (first_below < row_starts_[s + 1]) parents_[s] = supernode_of[L.rows[first_below]];
    entries_ += block_entries(s);
  }
  partition_into_chunks();
  find_boundaries(L.rows);
  allocate_workspace(4);
  pending_ = std::make_unique<std::atomic<int>[]>(chunks_.size());
}

void SupernodalSolve::partition_into_chunks() {
  std::vector<long> entries, sizes;
  for (int s = 0; s < isize(parents_); ++s) entries.push_back(block_entries(s));
  for (const TreeBlock& piece : partition_elimination_tree(parents_, columns_, entries)) {
    Chunk& chunk = chunks_.emplace_back();
    chunk.first_supernode = piece.first;
    chunk.first_column = columns_[piece.first];
    chunk.end_supernode = piece.end;
    chunk.end_column = columns_[piece.end];
    sizes.push_back(piece.entries);
  }
  link_chunks(sizes);
}

// Finds parents and children of chunks, and the schedule for several threads.
void SupernodalSolve::link_chunks(const std::vector<long>& sizes) {
  const auto chunks = isize(chunks_);
  std::vector<int> chunk_of(parents_.size()), level(chunks, 0);
  for (int c = 0; c < chunks; ++c)
    std::fill(chunk_of.begin() + chunks_[c].first_supernode,
              chunk_of.begin() + chunks_[c].end_supernode, c);
  for (int c = 0; c < chunks; ++c) {
    const int p = parents_[chunks_[c].end_supernode - 1];
    chunks_[c].parent = p < 0 ? -1 : chunk_of[p];
    if (p >= 0) level[chunk_of[p]] = std::max(level[chunk_of[p]], level[c] + 1);
  }
  std::vector<std::vector<int>> children(chunks);
  for (int c = 0; c < chunks; ++c)
    if (chunks_[c].parent >= 0) children[chunks_[c].parent].push_back(c);
  for (int c = 0; c < chunks; ++c) {
    chunks_[c].first_child = isize(children_);
    children_.insert(children_.end(), children[c].begin(), children[c].end());
    chunks_[c].end_child = isize(children_);
  }
  // Entries that must be read sequentially, whatever the number of threads.
  std::vector<long> path(chunks, 0);
  long longest = 0;
  for (int c = 0; c < chunks; ++c) {
    path[c] += sizes[c];
    longest = std::max(longest, path[c]);
    if (const int p = chunks_[c].parent; p >= 0) path[p] = std::max(path[p], path[c]);
  }
  // Passing a chunk to another thread costs about as much as reading this many entries.
  constexpr long kMinEntriesPerChunk = 10000;
  splits_ = 3 * longest < 2 * entries_ && entries_ >= kMinEntriesPerChunk * chunks;
  // Level by level, so that no thread waits long. Any order from children to parents would be
  // valid.
  schedule_.resize(chunks);
  std::iota(schedule_.begin(), schedule_.end(), 0);
  std::stable_sort(schedule_.begin(), schedule_.end(),
                   [&](int a, int b) { return level[a] < level[b]; });
}

void SupernodalSolve::find_boundaries(const int* rows) {
  targets_.resize(row_starts_.back());
  std::vector<int> place(n_, -1), boundary, all;
  for (Chunk& chunk : chunks_) {
    throw_if_cancelled();
    boundary.clear();
    const int first = row_starts_[chunk.first_supernode], end = row_starts_[chunk.end_supernode];
    for (int i = first; i < end; ++i)
      if (rows[i] >= chunk.end_column && place[rows[i]] < 0) {
        place[rows[i]] = 0;
        boundary.push_back(rows[i]);
      }
    std::sort(boundary.begin(), boundary.end());
    chunk.first_boundary = isize(all);
    for (const int row : boundary) {
      place[row] = n_ + isize(all);
      all.push_back(row);
    }
    chunk.end_boundary = isize(all);
    for (int i = first; i < end; ++i)
      targets_[i] = rows[i] < chunk.end_column ? rows[i] : place[rows[i]];
    for (const int row : boundary) place[row] = -1;
  }
  // A boundary row of a child is either a column of the parent or in the parent's own boundary.
  boundary_targets_.resize(all.size());
  for (const Chunk& chunk : chunks_) {
    throw_if_cancelled();
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
  const auto pack_chunk = [&](int c) {
    const Chunk& chunk = chunks_[c];
    std::vector<double> block;
    constexpr long kPollEntries = 1'000'000;  // 10 ms
    long unpolled = 0;
    // In-place packing: the write position never overtakes the values that are still to be read.
    double* to = values + value_starts_[chunk.first_supernode];
    for (int s = chunk.first_supernode; s < chunk.end_supernode; ++s) {
      const long r = row_starts_[s + 1] - row_starts_[s], w = columns_[s + 1] - columns_[s];
      block.assign(values + value_starts_[s], values + value_starts_[s] + r * w);
      packed_starts_[s] = to - values;
      to = pack_supernode(block.data(), r, w, to);
      unpolled += r * w;
      if (unpolled < kPollEntries) continue;
      throw_if_cancelled();
      unpolled = 0;
    }
  };
  parallel_for(chunk_count(), pack_chunk);
  values_ = values;
}

// Solve for one group of right-hand sides, through all chunks.
template <class Row>
class SupernodalSolve::GroupSolve {
 public:
  GroupSolve(const SupernodalSolve& all, const SolveSubset* subset, double* x, long stride,
             int columns)
      : all_(all), subset_(subset), x_(x), stride_(stride), columns_(columns) {
    // Vectors must be aligned to their size.
    const auto address = reinterpret_cast<std::uintptr_t>(all.work_.get());
    work_ = reinterpret_cast<Row*>((address + sizeof(Row) - 1) / sizeof(Row) * sizeof(Row));
    packed_ = {all.columns_.data(), all.row_starts_.data(), all.packed_starts_.data(),
               all.targets_.data(), all.values_};
  }

  void sweep_serial() const {
    const int count = all_.chunk_count();
    for (int c = 0; c < count; ++c) forward(c);
    for (int c = count - 1; c >= 0; --c) backward(c);
  }

  // Both sweeps use one task list: the schedule, followed by the schedule in reverse order. A
  // thread that takes a task waits for its predecessors, which were taken before it.
  void sweep_parallel(int threads) const {
    const int count = all_.chunk_count();
    for (int c = 0; c < count; ++c)
      all_.pending_[c].store(all_.chunks_[c].end_child - all_.chunks_[c].first_child,
                             std::memory_order_relaxed);
    std::atomic<int> next{0};
    const auto process_tasks = [&](int) {
      for (int i = next++; i < 2 * count; i = next++)
        if (i < count)
          forward_when_ready(all_.schedule_[i]);
        else
          backward_when_ready(all_.schedule_[2 * count - 1 - i]);
    };
    parallel_for(threads, std::ref(process_tasks));
  }

 private:
  static constexpr int kForwardDone = -1, kBackwardDone = -2;  // states of a chunk, below 0

  // After a cancellation, chunks do nothing: they cannot throw, because others wait for them.
  void forward(int c) const {
    if (is_cancelled()) return;
    const Chunk& chunk = all_.chunks_[c];
    Row* const work = work_;
    if (subset_ && !subset_->chunk_forward[c]) {
      if (subset_->chunk_backward[c])
        std::fill(work + chunk.first_column, work + chunk.end_column, Row{});
      return;
    }
    const int n = all_.n_;
    load_rows(x_, stride_, columns_, all_.order_.data() + chunk.first_column,
              work + chunk.first_column, work + chunk.end_column);
    std::fill(work + n + chunk.first_boundary, work + n + chunk.end_boundary, Row{});
    const int* const targets = all_.boundary_targets_.data();
    for (int i = chunk.first_child; i < chunk.end_child; ++i) {
      const Chunk& child = all_.chunks_[all_.children_[i]];
      if (subset_ && !subset_->chunk_forward[all_.children_[i]]) continue;
      for (int e = child.first_boundary; e < child.end_boundary; ++e)
        work[targets[e]] += work[n + e];
    }
    sweep_forward(packed_, chunk.first_supernode, chunk.end_supernode,
                  subset_ ? subset_->forward.data() : nullptr, work);
  }

  void backward(int c) const {
    const Chunk& chunk = all_.chunks_[c];
    if ((subset_ && !subset_->chunk_backward[c]) || is_cancelled()) return;
    Row* const work = work_;
    const int n = all_.n_;
    const int* const targets = all_.boundary_targets_.data();
    for (int e = chunk.first_boundary; e < chunk.end_boundary; ++e) work[n + e] = work[targets[e]];
    sweep_backward(packed_, chunk.first_supernode, chunk.end_supernode,
                   subset_ ? subset_->backward.data() : nullptr, work);
    store_rows(work + chunk.first_column, work + chunk.end_column,
               all_.order_.data() + chunk.first_column, columns_, x_, stride_);
  }

  // Runs after all children of the chunk.
  void forward_when_ready(int c) const {
    wait_for(c, 0);
    forward(c);
    all_.pending_[c].store(kForwardDone, std::memory_order_release);
    if (const int parent = all_.chunks_[c].parent; parent >= 0)
      all_.pending_[parent].fetch_sub(1, std::memory_order_acq_rel);
  }

  // Runs after the parent's backward sweep, or, for a root, after its own forward sweep.
  void backward_when_ready(int c) const {
    if (const int parent = all_.chunks_[c].parent; parent >= 0)
      wait_for(parent, kBackwardDone);
    else
      wait_for(c, kForwardDone);
    backward(c);
    all_.pending_[c].store(kBackwardDone, std::memory_order_release);
  }

  void wait_for(int c, int state) const {
    for (SpinWait spin; all_.pending_[c].load(std::memory_order_acquire) != state;)
      spin.wait_and_poll();
  }

  const SupernodalSolve& all_;
  const SolveSubset* subset_;
  double* x_;
  long stride_;
  int columns_;
  Row* work_;
  PackedSupernodes packed_;
};

template <class Row>
void SupernodalSolve::solve_group(const SolveSubset* subset, double* x, long stride,
                                  int columns) const {
  const GroupSolve<Row> group(*this, subset, x, stride, columns);
  const int threads = threads_for(subset ? subset->entries / 2 : entries_);
  if (threads == 1)
    group.sweep_serial();
  else
    group.sweep_parallel(threads);
}

void SupernodalSolve::solve_subset(const SolveSubset* subset, Eigen::Ref<MatX> x) const {
  for (long c = 0; c < x.cols();) {
    const int columns = static_cast<int>(std::min(x.cols() - c, x.cols() - c > 4 ? 8L : 4L));
    double* first = x.data() + c * x.outerStride();
    if (columns > 4) {
      allocate_workspace(8);
      solve_group<Row8>(subset, first, x.outerStride(), columns);
    } else {
      solve_group<Row4>(subset, first, x.outerStride(), columns);
    }
    throw_if_cancelled();
    c += columns;
  }
}

void SupernodalSolve::solve(Eigen::Ref<MatX> x) const { solve_subset(nullptr, x); }

void SupernodalSolve::solve(const SolveSubset& subset, Eigen::Ref<MatX> x) const {
  if (subset.analysis != analysis_)
    throw InputError("solve subset: it belongs to another symbolic analysis");
  solve_subset(&subset, x);
}

SolveSubset SupernodalSolve::subset(const std::optional<std::vector<int>>& nonzero,
                                    const std::optional<std::vector<int>>& wanted) const {
  const auto supernodes = isize(parents_);
  const auto with_ancestors = [&](const std::optional<std::vector<int>>& unknowns) {
    std::vector<char> visit(supernodes, !unknowns);
    if (!unknowns) return visit;
    std::vector<char> given(n_, 0);
    for (const int unknown : *unknowns) {
      if (unknown < 0 || unknown >= n_)
        throw InputError("solve subset: found unknown " + std::to_string(unknown) +
                         ", expected 0 to " + std::to_string(n_ - 1));
      given[unknown] = 1;
    }
    for (int s = 0; s < supernodes; ++s) {
      for (int i = columns_[s]; i < columns_[s + 1] && !visit[s]; ++i) visit[s] = given[order_[i]];
      if (visit[s] && parents_[s] >= 0) visit[parents_[s]] = 1;
    }
    return visit;
  };
  SolveSubset result;
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
  // Entries; waking a thread takes up to 50 µs and its caches are cold, so less work is not worth
  // it.
  constexpr long kMinWorkPerThread = 500000;
  if (!splits_ || entries < kMinWorkPerThread) return 1;
  // A thread without a core of its own would only make the others wait.
  return std::min({thread_count(), core_count(), chunk_count()});
}

void SupernodalSolve::allocate_workspace(int lanes) const {
  if (work_lanes_ >= lanes) return;
  work_ = std::make_unique_for_overwrite<double[]>((n_ + boundary_targets_.size() + 1) * lanes);
  work_lanes_ = lanes;
}

namespace {

class TreePartitioner {
 public:
  TreePartitioner(const std::vector<int>& parents, const std::vector<int>& columns,
                  const std::vector<long>& entries)
      : parents_(parents),
        columns_(columns),
        entries_(entries),
        // 24 blocks are enough to keep a few threads busy.
        max_entries_(std::max(std::accumulate(entries.begin(), entries.end(), 0L) / 24, 16384L)),
        first_(parents.size()),
        below_(entries),
        largest_child_(parents.size(), 0) {
    measure();
  }

  std::vector<TreeBlock> partition() {
    const long small_block = max_entries_ / 8;
    for (int s = 0; s < isize(parents_); ++s) {
      if (small(s)) {
        if (!small(parents_[s])) blocks_.push_back({first_[s], s + 1, below_[s], true});
        continue;
      }
      const bool spine = below_[s] - entries_[s] - largest_child_[s] <= small_block;
      TreeBlock block{s, s + 1, entries_[s], false};
      while (fits(block) && blocks_.back().first >= first_[s] &&
             (spine || blocks_.back().entries <= small_block)) {
        block.first = blocks_.back().first;
        block.entries += blocks_.back().entries;
        blocks_.pop_back();
      }
      blocks_.push_back(block);
    }
    merge_siblings();
    return std::move(blocks_);
  }

 private:
  void measure() {
    std::iota(first_.begin(), first_.end(), 0);
    for (int s = 0; s < isize(parents_); ++s)
      if (const int p = parents_[s]; p >= 0) {
        below_[p] += below_[s];
        largest_child_[p] = std::max(largest_child_[p], below_[s]);
        first_[p] = std::min(first_[p], first_[s]);
      }
  }

  bool small(int s) const {
    return s >= 0 && below_[s] <= max_entries_ &&
           columns_[s + 1] - columns_[first_[s]] <= kMaxColumns;
  }

  // Whether the last block can be merged with this one.
  bool fits(const TreeBlock& block) const {
    return !blocks_.empty() && blocks_.back().entries + block.entries <= max_entries_ &&
           columns_[block.end] - columns_[blocks_.back().first] <= kMaxColumns;
  }

  void merge_siblings() {
    std::vector<int> block_of(parents_.size());
    for (size_t i = 0; i < blocks_.size(); ++i)
      std::fill(block_of.begin() + blocks_[i].first, block_of.begin() + blocks_[i].end,
                static_cast<int>(i));
    const auto above = [&](const TreeBlock& block) {
      const int p = parents_[block.end - 1];
      return p < 0 ? -1 : block_of[p];
    };
    std::vector<TreeBlock> all;
    all.swap(blocks_);
    for (const TreeBlock& block : all) {
      if (block.subtree && fits(block) && blocks_.back().subtree &&
          above(blocks_.back()) == above(block)) {
        blocks_.back().end = block.end;
        blocks_.back().entries += block.entries;
      } else {
        blocks_.push_back(block);
      }
    }
  }

  // The work vector of this many columns fits in the L2 cache.
  static constexpr int kMaxColumns = 8192;
  const std::vector<int>& parents_;
  const std::vector<int>& columns_;
  const std::vector<long>& entries_;
  const long max_entries_;
  std::vector<int> first_;   // first supernode of each subtree
  std::vector<long> below_;  // entries of each subtree
  std::vector<long> largest_child_;
  std::vector<TreeBlock> blocks_;
};

}  // namespace

std::vector<TreeBlock> partition_elimination_tree(const std::vector<int>& parents,
                                                  const std::vector<int>& columns,
                                                  const std::vector<long>& entries) {
  return TreePartitioner(parents, columns, entries).partition();
}

}  // namespace batten
