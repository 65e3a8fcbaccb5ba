#include "batten/core/elimination_tree_partition.h"

#include <algorithm>
#include <numeric>

#include "batten/core/isize.h"

namespace batten {
namespace {

class TreePartitioner {
 public:
  TreePartitioner(const std::vector<int>& parents, const std::vector<int>& columns,
                  const std::vector<long>& entries)
      : parents_(parents),
        columns_(columns),
        entries_(entries),
        // So many pieces keep a few threads busy.
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

  // Whether the last piece can take this one in.
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

  // The rows of so many columns stay in a second-level cache.
  static constexpr int kMaxColumns = 8192;
  const std::vector<int>& parents_;
  const std::vector<int>& columns_;
  const std::vector<long>& entries_;
  const long max_entries_;
  std::vector<int> first_;   // supernode of each subtree
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
