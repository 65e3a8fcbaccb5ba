#include "batten/core/supernodal_factorization.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include "batten/core/dense_kernels.h"
#include "batten/core/isize.h"
#include "batten/core/parallel.h"
#include "batten/core/spin_wait.h"

namespace batten {
namespace {

constexpr int kNoColumn = std::numeric_limits<int>::max();

}  // namespace

SupernodalFactorization::SupernodalFactorization(const SupernodalPattern& pattern, const int* order,
                                                 const SparseMatrix& A)
    : pattern_(pattern), failed_(std::make_unique<std::atomic<int>>(kNoColumn)) {
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

// Sorted by supernode, so that each is filled while it is in the cache.
void SupernodalFactorization::find_entries(const int* order, const SparseMatrix& A) {
  const int n = pattern_.columns[pattern_.count];
  std::vector<int> row_of(n), supernode_of(n), local_row(n);
  for (int i = 0; i < n; ++i) row_of[order[i]] = i;
  for (int s = 0; s < pattern_.count; ++s)
    std::fill(supernode_of.begin() + pattern_.columns[s],
              supernode_of.begin() + pattern_.columns[s + 1], s);
  const auto for_entries = [&](const auto& call) {
    int number = 0;
    for (int c = 0; c < n; ++c)
      for (SparseMatrix::InnerIterator e(A, c); e; ++e, ++number)
        if (e.row() >= c) {
          const auto [column, row] = std::minmax(row_of[c], row_of[e.row()]);
          call(supernode_of[column], row, column, number);
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
    for (int i = pattern_.row_starts[s]; i < pattern_.row_starts[s + 1]; ++i)
      local_row[pattern_.rows[i]] = i - pattern_.row_starts[s];
    for (int e = entry_starts_[s]; e < entry_starts_[s + 1]; ++e)
      targets_[e] = local_row[rows_and_columns[e].first] +
                    (rows_and_columns[e].second - pattern_.columns[s]) * rows(s);
  }
}

// Each supernode's rows below, cut where they go from the columns of one supernode to another's.
void SupernodalFactorization::find_updates() {
  const int n = pattern_.columns[pattern_.count];
  std::vector<int> supernode_of(n);
  for (int s = 0; s < pattern_.count; ++s)
    std::fill(supernode_of.begin() + pattern_.columns[s],
              supernode_of.begin() + pattern_.columns[s + 1], s);
  const auto for_updates = [&](const auto& call) {
    for (int d = 0; d < pattern_.count; ++d) {
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
  for (int s = 0; s < pattern_.count; ++s)
    for (int u = update_starts_[s]; u < update_starts_[s + 1]; ++u)
      if (updates_[u].first == width(updates_[u].from)) result[updates_[u].from] = s;
  return result;
}

std::vector<long> SupernodalFactorization::flops() const {
  std::vector<long> result;
  for (int s = 0; s < pattern_.count; ++s) {
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
  if (!A.isCompressed()) {  // the entries are counted
    SparseMatrix compressed = A;
    compressed.makeCompressed();
    return factorize(compressed);
  }
  // Less is done before another thread has woken.
  constexpr long kMinWorkPerThread = 10000000;
  const int threads = flops_ < kMinWorkPerThread ? 1 : std::min(thread_count(), core_count());
  *failed_ = kNoColumn;
  allocate_workspace(threads);
  if (threads > 1)
    factor_in_parallel(A.valuePtr(), threads);
  else
    for (int s = 0; s < pattern_.count; ++s) factor_supernode(s, A.valuePtr(), work_[0]);
  return *failed_ == kNoColumn ? -1 : failed_->load();
}

void SupernodalFactorization::allocate_workspace(int threads) {
  while (isize(work_) < threads) {
    Workspace& work = work_.emplace_back();
    work.local_row.resize(pattern_.columns[pattern_.count]);
    work.local_rows.resize(max_rows_);
    work.scratch.resize(scratch_size(max_columns_));
  }
}

void SupernodalFactorization::factor_in_parallel(const double* a, int threads) {
  const int count = isize(tasks_);
  for (int t = 0; t < count; ++t)
    pending_[t].store(tasks_[t].pending_count, std::memory_order_relaxed);
  std::atomic<int> next{0};
  const auto process_tasks = [&](int thread) {
    for (int t = next++; t < count; t = next++) {
      for (SpinWait spin; pending_[t].load(std::memory_order_acquire) > 0;) spin.wait();
      execute(tasks_[t], a, work_[thread]);
      for (const int n : tasks_[t].next) pending_[n].fetch_sub(1, std::memory_order_acq_rel);
    }
  };
  parallel_for(threads, std::ref(process_tasks));
}

void SupernodalFactorization::execute(const FactorTask& task, const double* a, Workspace& work) {
  using Step = FactorTask::Step;
  const int s = task.supernode;
  if (*failed_ < pattern_.columns[s]) return;
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
      solve_rows(block(s), rows(s), task.first_row, task.end_row, task.first_column,
                 task.end_column, work.scratch.data());
      break;
    case Step::done:
      break;
  }
}

void SupernodalFactorization::factor_supernode(int s, const double* a, Workspace& work) {
  // What fails does so at the lowest column of all, which nothing above it can change.
  if (*failed_ < pattern_.columns[s]) return;
  assemble(s, a);
  update(s, 0, rows(s), work);
  for (int first = 0; first < width(s); first += kBlockColumns) {
    const int end = std::min(first + kBlockColumns, width(s));
    triangle(s, first, end, work);
    solve_rows(block(s), rows(s), end, rows(s), first, end, work.scratch.data());
  }
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
    subtract_product({L + begin, L + first, rows(from), width(from), stop - begin, end - first,
                      local_rows + begin, local_rows + first, block(s), rows(s)},
                     work.scratch.data());
  }
}

void SupernodalFactorization::triangle(int s, int first_column, int end_column, Workspace& work) {
  const int column =
      factor_triangle(block(s), rows(s), first_column, end_column, work.scratch.data());
  if (column < 0) return;
  const int failed = pattern_.columns[s] + column;
  for (int known = *failed_; failed < known && !failed_->compare_exchange_weak(known, failed);) {
  }
}

}  // namespace batten
