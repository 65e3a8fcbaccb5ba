// SPDX-License-Identifier: MPL-2.0
#include "batten/core/solvers/supernodal_factorization.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/parallel.h"
#include "batten/core/solvers/supernodal_kernels.h"
#include "batten/core/solvers/supernodal_solve.h"

namespace batten {
namespace {

constexpr int kNoColumn = std::numeric_limits<int>::max(), kCancelled = -1;
// Operations between two polls of a thread: 1 ms in large supernodes, 20 ms in small ones.
constexpr long kPollOperations = 20'000'000;
// Operations of one call of a kernel: 5 ms. The rows are a multiple of all tiles.
constexpr long kMaxKernelOperations = 100'000'000;
constexpr int kMaxKernelRows = 480;

}  // namespace

SupernodalFactorization::SupernodalFactorization(const SupernodalPattern& pattern, const int* order,
                                                 const SparseMatrix& A)
    : pattern_(pattern),
      failed_(std::make_unique<std::atomic<int>>(kNoColumn)),
      done_(std::make_unique<std::atomic<long>>(0)) {
  for (int s = 0; s < pattern.count; ++s) {
    max_rows_ = std::max(max_rows_, rows(s));
    max_columns_ = std::max(max_columns_, width(s));
  }
  find_entries(order, A);
  find_updates();
  const std::vector<long> work = flops();
  flops_ = std::accumulate(work.begin(), work.end(), 0L);
  tasks_ = plan_factorization(pattern_, parents(), work);
  pending_ = std::make_unique<std::atomic<int>[]>(tasks_.size());
  values_ = std::make_unique_for_overwrite<double[]>(pattern.value_starts[pattern.count]);
}

// Entries are sorted by supernode, so that each supernode is filled while it is in the cache.
void SupernodalFactorization::find_entries(const int* order, const SparseMatrix& A) {
  const int n = pattern_.columns[pattern_.count];
  std::vector<int> row_of(n), supernode_of(n), local_row(n);
  for (int i = 0; i < n; ++i) row_of[order[i]] = i;
  for (int s = 0; s < pattern_.count; ++s)
    std::fill(supernode_of.begin() + pattern_.columns[s],
              supernode_of.begin() + pattern_.columns[s + 1], s);
  const auto for_entries = [&](const auto& call) {
    int number = 0;
    for (int c = 0; c < n; ++c) {
      poll_every<4096>(c);
      for (SparseMatrix::InnerIterator e(A, c); e; ++e, ++number)
        if (e.row() >= c) {
          const auto [column, row] = std::minmax(row_of[c], row_of[e.row()]);
          call(supernode_of[column], row, column, number);
        }
    }
  };
  entry_starts_.assign(pattern_.count + 1, 0);
  for_entries([&](int s, int, int, int) { ++entry_starts_[s + 1]; });
  std::partial_sum(entry_starts_.begin(), entry_starts_.end(), entry_starts_.begin());
  entries_.resize(entry_starts_.back());
  std::vector<std::pair<int, int>> rows_and_columns(entries_.size());
  std::vector<int> next(entry_starts_.begin(), entry_starts_.end() - 1);
  for_entries([&](int s, int row, int column, int number) {
    rows_and_columns[next[s]] = {row, column};
    entries_[next[s]++] = number;
  });
  targets_.resize(entries_.size());
  for (int s = 0; s < pattern_.count; ++s) {
    poll_every<1024>(s);
    for (int i = pattern_.row_starts[s]; i < pattern_.row_starts[s + 1]; ++i)
      local_row[pattern_.rows[i]] = i - pattern_.row_starts[s];
    for (int e = entry_starts_[s]; e < entry_starts_[s + 1]; ++e)
      targets_[e] = local_row[rows_and_columns[e].first] +
                    (rows_and_columns[e].second - pattern_.columns[s]) * rows(s);
  }
}

// Splits the rows below each supernode where they pass from the columns of one supernode to those
// of another.
void SupernodalFactorization::find_updates() {
  const int n = pattern_.columns[pattern_.count];
  std::vector<int> supernode_of(n);
  for (int s = 0; s < pattern_.count; ++s)
    std::fill(supernode_of.begin() + pattern_.columns[s],
              supernode_of.begin() + pattern_.columns[s + 1], s);
  const auto for_updates = [&](const auto& call) {
    for (int d = 0; d < pattern_.count; ++d) {
      poll_every<4096>(d);
      const int* row = pattern_.rows + pattern_.row_starts[d];
      for (int first = width(d), end; first < rows(d); first = end) {
        const int s = supernode_of[row[first]];
        for (end = first; end < rows(d) && row[end] < pattern_.columns[s + 1];) ++end;
        call(s, Update{d, first, end});
      }
    }
  };
  update_starts_.assign(pattern_.count + 1, 0);
  for_updates([&](int s, const Update&) { ++update_starts_[s + 1]; });
  std::partial_sum(update_starts_.begin(), update_starts_.end(), update_starts_.begin());
  updates_.resize(update_starts_.back());
  std::vector<int> next(update_starts_.begin(), update_starts_.end() - 1);
  for_updates([&](int s, const Update& update) { updates_[next[s]++] = update; });
}

std::vector<int> SupernodalFactorization::parents() const {
  std::vector<int> result(pattern_.count, -1);
  throw_if_cancelled();
  for (int s = 0; s < pattern_.count; ++s)
    for (int u = update_starts_[s]; u < update_starts_[s + 1]; ++u)
      if (updates_[u].first == width(updates_[u].from)) result[updates_[u].from] = s;
  return result;
}

std::vector<long> SupernodalFactorization::flops() const {
  std::vector<long> result;
  for (int s = 0; s < pattern_.count; ++s) {
    poll_every<4096>(s);
    const long w = width(s);
    long sum = w * w * rows(s);
    for (int u = update_starts_[s]; u < update_starts_[s + 1]; ++u) {
      const auto& [from, first, end] = updates_[u];
      sum += 2L * width(from) * (end - first) * (rows(from) - first);
    }
    result.push_back(sum);
  }
  return result;
}

int SupernodalFactorization::factorize(const SparseMatrix& A) {
  if (!A.isCompressed()) {  // entries are addressed by their index in the compressed storage
    SparseMatrix compressed = A;
    compressed.makeCompressed();
    return factorize(compressed);
  }
  // Operations; with less work, the computation is over before another thread has woken.
  constexpr long kMinWorkPerThread = 10000000;
  const int threads = flops_ < kMinWorkPerThread ? 1 : std::min(thread_count(), core_count());
  *failed_ = kNoColumn;
  *done_ = 0;
  allocate_workspace(threads);
  if (threads > 1)
    factor_in_parallel(A.valuePtr(), threads);
  else
    for (int s = 0; s < pattern_.count; ++s) factor_supernode(s, A.valuePtr(), work_[0]);
  throw_if_cancelled();
  return *failed_ == kNoColumn ? -1 : failed_->load();
}

void SupernodalFactorization::allocate_workspace(int threads) {
  while (isize(work_) < threads) {
    Workspace& work = work_.emplace_back();
    work.local_row.resize(pattern_.columns[pattern_.count]);
    work.local_rows.resize(max_rows_);
    work.scratch.resize(scratch_size(max_columns_));
  }
  for (Workspace& work : work_) work.unpolled = work.percent = 0;
}

void SupernodalFactorization::factor_in_parallel(const double* a, int threads) {
  const int count = isize(tasks_);
  for (int t = 0; t < count; ++t)
    pending_[t].store(tasks_[t].pending_count, std::memory_order_relaxed);
  std::atomic<int> next{0};
  const auto process_tasks = [&](int thread) {
    for (int t = next++; t < count; t = next++) {
      for (SpinWait spin; pending_[t].load(std::memory_order_acquire) > 0;) spin.wait_and_poll();
      execute(tasks_[t], a, work_[thread]);
      for (const int n : tasks_[t].next) pending_[n].fetch_sub(1, std::memory_order_acq_rel);
    }
  };
  parallel_for(threads, std::ref(process_tasks));
}

void SupernodalFactorization::execute(const FactorTask& task, const double* a, Workspace& work) {
  using Step = FactorTask::Step;
  const int s = task.supernode;
  if (is_useless(s)) return;
  switch (task.step) {
    case Step::factor_supernode:
      for (int i = s; i < task.end_supernode; ++i) factor_supernode(i, a, work);
      break;
    case Step::assemble:
      assemble(s, a);
      break;
    case Step::update:
      update(s, task.first_row, task.end_row, work);
      break;
    case Step::triangle:
      triangle(s, task.first_column, task.end_column, work);
      break;
    case Step::rows:
      solve_rows_of(s, task.first_row, task.end_row, task.first_column, task.end_column, work);
      break;
    case Step::done:
      break;
  }
}

void SupernodalFactorization::factor_supernode(int s, const double* a, Workspace& work) {
  if (is_useless(s)) return;
  assemble(s, a);
  poll_after(4L * rows(s) * width(s), work);
  update(s, 0, rows(s), work);
  for (int first = 0; first < width(s); first += kBlockColumns) {
    const int end = std::min(first + kBlockColumns, width(s));
    triangle(s, first, end, work);
    solve_rows_of(s, end, rows(s), first, end, work);
  }
}

// If a pivot fails, the lowest failing column counts, and later supernodes cannot change it.
bool SupernodalFactorization::is_useless(int s) const { return *failed_ < pattern_.columns[s]; }

void SupernodalFactorization::poll_after(long operations, Workspace& work) {
  work.unpolled += operations;
  if (work.unpolled < kPollOperations) return;
  const long done = *done_ += std::exchange(work.unpolled, 0);
  // Other threads wait for this one, so that it must not throw.
  if (is_cancelled()) *failed_ = kCancelled;
  const int percent = static_cast<int>(std::min(99.0, 100.0 * static_cast<double>(done) /
                                                          static_cast<double>(flops_)));
  if (percent > work.percent) report_progress("factorization", 0.01 * percent);
  work.percent = percent;
}

void SupernodalFactorization::assemble(int s, const double* a) {
  double* L = block(s);
  std::fill(L, values_.get() + pattern_.value_starts[s + 1], 0.0);
  for (int e = entry_starts_[s]; e < entry_starts_[s + 1]; ++e) L[targets_[e]] = a[entries_[e]];
}

void SupernodalFactorization::update(int s, int first_row, int end_row, Workspace& work) {
  const int* own = pattern_.rows + pattern_.row_starts[s];
  for (int i = first_row; i < end_row; ++i) work.local_row[own[i]] = i;
  int* const local_rows = work.local_rows.data();
  for (int u = update_starts_[s]; u < update_starts_[s + 1]; ++u) {
    const auto& [from, first, end] = updates_[u];
    const int* row = pattern_.rows + pattern_.row_starts[from];
    const int* const last = row + rows(from);
    const int begin = static_cast<int>(std::lower_bound(row + first, last, own[first_row]) - row);
    const int stop =
        end_row == rows(s)
            ? rows(from)
            : static_cast<int>(std::lower_bound(row + begin, last, own[end_row]) - row);
    if (begin == stop) continue;
    for (int j = first; j < end; ++j) local_rows[j] = row[j] - pattern_.columns[s];
    for (int i = std::max(begin, end); i < stop; ++i) local_rows[i] = work.local_row[row[i]];
    const double* L = block(from);
    // In parts, if the product is large. An entry does not depend on the part that it is in.
    const long all = 2L * width(from) * (stop - begin) * (end - first);
    const int rows_at_once = all > kMaxKernelOperations ? kMaxKernelRows : stop - begin;
    const long columns_at_once =
        all > kMaxKernelOperations
            ? std::max(8L, kMaxKernelOperations / (2L * width(from) * rows_at_once) / 8 * 8)
            : end - first;
    for (int i = begin; i < stop; i += rows_at_once)
      for (int j = first; j < end; j += static_cast<int>(columns_at_once)) {
        if (is_useless(s)) return;
        const int row_count = std::min(rows_at_once, stop - i),
                  column_count = static_cast<int>(std::min<long>(columns_at_once, end - j));
        subtract_product({L + i, L + j, rows(from), width(from), row_count, column_count,
                          local_rows + i, local_rows + j, block(s), rows(s)},
                         work.scratch.data());
        poll_after(2L * width(from) * row_count * column_count, work);
      }
  }
}

void SupernodalFactorization::solve_rows_of(int s, int first_row, int end_row, int first_column,
                                            int end_column, Workspace& work) {
  for (int i = first_row; i < end_row && !is_useless(s); i += kMaxKernelRows) {
    const int end = std::min(i + kMaxKernelRows, end_row);
    solve_rows(block(s), rows(s), i, end, first_column, end_column, work.scratch.data());
    poll_after(2L * (end - i) * (end_column - first_column) * end_column, work);
  }
}

void SupernodalFactorization::triangle(int s, int first_column, int end_column, Workspace& work) {
  const int column =
      factor_triangle(block(s), rows(s), first_column, end_column, work.scratch.data());
  const long columns = end_column - first_column;
  poll_after(2 * columns * columns * end_column, work);
  if (column < 0) return;
  const int failed = pattern_.columns[s] + column;
  for (int known = *failed_; failed < known && !failed_->compare_exchange_weak(known, failed);) {
  }
}

namespace {

using Step = FactorTask::Step;

class Planner {
 public:
  Planner(const SupernodalPattern& pattern, const std::vector<int>& parents,
          const std::vector<long>& flops)
      : pattern_(pattern), parents_(parents), flops_(flops) {
    // Blocks are about 1/24 of the total work. Waiting for a block with fewer operations than this
    // takes little time.
    constexpr long little = 2000000;
    most_flops_ = std::max(std::accumulate(flops.begin(), flops.end(), 0L) / 100, little);
  }

  std::vector<FactorTask> plan() {
    const std::vector<int> columns(pattern_.columns, pattern_.columns + pattern_.count + 1);
    const std::vector<TreeBlock> pieces = partition_elimination_tree(parents_, columns, flops_);
    std::vector<int> piece_of(parents_.size()), level(pieces.size(), 0);
    std::vector<std::vector<int>> done(pieces.size());  // last tasks of the blocks below each one
    for (int p = 0; p < isize(pieces); ++p)
      std::fill(piece_of.begin() + pieces[p].first, piece_of.begin() + pieces[p].end, p);
    for (int p = 0; p < isize(pieces); ++p) {
      const auto& [first, end, flops, subtree] = pieces[p];
      const int before = isize(tasks_);
      if (end == first + 1 && flops >= most_flops_)
        split(first);
      else
        begin_.push_back(add(Step::factor_supernode, first, end));
      for (const int child : done[p])
        for (const int task : begin_) link(child, task);
      begin_.clear();
      for (int t = before; t < isize(tasks_); ++t) place_.push_back({level[p], t - before});
      // A subtree may have several roots; they have the same parent block.
      if (const int s = parents_[end - 1]; s >= 0) {
        const int parent = piece_of[s];
        done[parent].push_back(isize(tasks_) - 1);
        level[parent] = std::max(level[parent], level[p] + 1);
      }
    }
    return in_order();
  }

 private:
  int add(Step step, int supernode, int end) {
    tasks_.push_back({step, supernode, end});
    return isize(tasks_) - 1;
  }
  void link(int before, int after) {
    tasks_[before].next.push_back(after);
    ++tasks_[after].pending_count;
  }

  // Splits a large supernode into blocks of columns, each with a triangle and then ranges of rows
  // below it. Each range first receives its updates, and then one block of columns after the other.
  void split(int s) {
    const int width = pattern_.columns[s + 1] - pattern_.columns[s];
    const int rows = pattern_.row_starts[s + 1] - pattern_.row_starts[s];
    std::vector<int> starts;
    for (int c = 0; c < width; c += kBlockColumns) starts.push_back(c);
    const int blocks = isize(starts);
    for (int r = width; r < rows; r += kBlockColumns) starts.push_back(r);
    const int ranges = isize(starts);
    starts.push_back(rows);

    std::vector<int> last;  // last task on each range
    const int assemble = add(Step::assemble, s, s + 1);
    for (int r = 0; r < ranges; ++r) {
      last.push_back(add(Step::update, s, s + 1));
      tasks_.back().first_row = starts[r];
      tasks_.back().end_row = starts[r + 1];
      link(assemble, last[r]);
      begin_.push_back(last[r]);
    }
    const auto follow = [&](int r, Step step, int b) {
      const int task = add(step, s, s + 1);
      tasks_[task].first_row = starts[r];
      tasks_[task].end_row = starts[r + 1];
      tasks_[task].first_column = starts[b];
      tasks_[task].end_column = starts[b + 1];
      link(last[r], task);
      if (r != b) link(last[b], task);
      last[r] = task;
    };
    follow(0, Step::triangle, 0);
    for (int b = 0; b < blocks; ++b)
      for (int r = b + 1; r < ranges; ++r) {
        follow(r, Step::rows, b);
        // Schedule the next triangle early, while other threads work on the rows.
        if (b + 1 < blocks && r == std::min(b + 2, ranges - 1))
          follow(b + 1, Step::triangle, b + 1);
      }
    const int done = add(Step::done, s, s + 1);
    for (int r = 0; r < ranges; ++r) link(last[r], done);
  }

  // Sorts tasks by level; within a level, the steps of several supernodes alternate.
  std::vector<FactorTask> in_order() {
    std::vector<int> order(tasks_.size()), number(tasks_.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return place_[a] < place_[b]; });
    for (int i = 0; i < isize(order); ++i) number[order[i]] = i;
    std::vector<FactorTask> sorted;
    for (const int t : order) {
      sorted.push_back(std::move(tasks_[t]));
      for (int& next : sorted.back().next) next = number[next];
    }
    return sorted;
  }

  const SupernodalPattern& pattern_;
  const std::vector<int>& parents_;
  const std::vector<long>& flops_;
  long most_flops_;
  std::vector<FactorTask> tasks_;
  std::vector<int> begin_;                  // tasks of a block that need the blocks below
  std::vector<std::pair<int, int>> place_;  // level, and index in the block
};

}  // namespace

std::vector<FactorTask> plan_factorization(const SupernodalPattern& pattern,
                                           const std::vector<int>& parents,
                                           const std::vector<long>& flops) {
  return Planner(pattern, parents, flops).plan();
}

}  // namespace batten
