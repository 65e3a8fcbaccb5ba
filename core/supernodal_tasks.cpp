#include "batten/core/supernodal_tasks.h"

#include <algorithm>
#include <numeric>

#include "batten/core/dense_kernels.h"
#include "batten/core/elimination_tree_partition.h"
#include "batten/core/isize.h"

namespace batten {
namespace {

using Step = FactorTask::Step;

class Planner {
 public:
  Planner(const SupernodalPattern& pattern, const std::vector<int>& parents,
          const std::vector<long>& flops)
      : pattern_(pattern), parents_(parents), flops_(flops) {
    // Pieces are about a 24th of the whole; less than this is soon waited for.
    constexpr long little = 2000000;
    most_flops_ = std::max(std::accumulate(flops.begin(), flops.end(), 0L) / 100, little);
  }

  std::vector<FactorTask> plan() {
    const std::vector<int> columns(pattern_.columns, pattern_.columns + pattern_.count + 1);
    const std::vector<TreeBlock> pieces = partition_elimination_tree(parents_, columns, flops_);
    std::vector<int> piece_of(parents_.size()), level(pieces.size(), 0);
    std::vector<std::vector<int>> done(pieces.size());  // the last tasks of the pieces below
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
      // A subtree may have several roots, which are under the same piece.
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

  // Blocks of columns, each a triangle and then the rows below it, range by range: a range has had
  // its updates, and then one block after the other.
  void split(int s) {
    const int width = pattern_.columns[s + 1] - pattern_.columns[s];
    const int rows = pattern_.row_starts[s + 1] - pattern_.row_starts[s];
    std::vector<int> starts;
    for (int c = 0; c < width; c += kBlockColumns) starts.push_back(c);
    const int blocks = isize(starts);
    for (int r = width; r < rows; r += kBlockColumns) starts.push_back(r);
    const int ranges = isize(starts);
    starts.push_back(rows);

    std::vector<int> last;  // task on each range
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
        // The next triangle is taken early: others are at work on the rows meanwhile.
        if (b + 1 < blocks && r == std::min(b + 2, ranges - 1))
          follow(b + 1, Step::triangle, b + 1);
      }
    const int done = add(Step::done, s, s + 1);
    for (int r = 0; r < ranges; ++r) link(last[r], done);
  }

  // By levels, and within a level the steps of several supernodes side by side.
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
  std::vector<int> begin_;                  // tasks of a piece that need the pieces below
  std::vector<std::pair<int, int>> place_;  // level and number in the piece
};

}  // namespace

std::vector<FactorTask> plan_factorization(const SupernodalPattern& pattern,
                                           const std::vector<int>& parents,
                                           const std::vector<long>& flops) {
  return Planner(pattern, parents, flops).plan();
}

}  // namespace batten
