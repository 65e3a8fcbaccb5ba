#include "batten/core/supernodal_chunks.h"

#include <algorithm>
#include <numeric>

#include "batten/core/index.h"

namespace batten {
namespace {

class Cutter {
 public:
  Cutter(const std::vector<int>& parents, const std::vector<int>& columns,
         const std::vector<long>& entries)
      : parents_(parents),
        columns_(columns),
        entries_(entries),
        // So many pieces keep a few threads busy.
        most_entries_(std::max(std::accumulate(entries.begin(), entries.end(), 0L) / 24, 16384L)),
        first_(parents.size()),
        below_(entries),
        largest_child_(parents.size(), 0) {
    measure();
  }

  std::vector<SupernodePiece> cut() {
    const long little = most_entries_ / 8;
    for (int s = 0; s < count_of(parents_); ++s) {
      if (small(s)) {
        if (!small(parents_[s])) pieces_.push_back({first_[s], s + 1, below_[s], true});
        continue;
      }
      const bool spine = below_[s] - entries_[s] - largest_child_[s] <= little;
      SupernodePiece piece{s, s + 1, entries_[s], false};
      while (fits(piece) && pieces_.back().first >= first_[s] &&
             (spine || pieces_.back().entries <= little)) {
        piece.first = pieces_.back().first;
        piece.entries += pieces_.back().entries;
        pieces_.pop_back();
      }
      pieces_.push_back(piece);
    }
    join();
    return std::move(pieces_);
  }

 private:
  void measure() {
    std::iota(first_.begin(), first_.end(), 0);
    for (int s = 0; s < count_of(parents_); ++s)
      if (const int p = parents_[s]; p >= 0) {
        below_[p] += below_[s];
        largest_child_[p] = std::max(largest_child_[p], below_[s]);
        first_[p] = std::min(first_[p], first_[s]);
      }
  }

  bool small(int s) const {
    return s >= 0 && below_[s] <= most_entries_ &&
           columns_[s + 1] - columns_[first_[s]] <= most_columns;
  }

  // Whether the last piece can take this one in.
  bool fits(const SupernodePiece& piece) const {
    return !pieces_.empty() && pieces_.back().entries + piece.entries <= most_entries_ &&
           columns_[piece.end] - columns_[pieces_.back().first] <= most_columns;
  }

  void join() {
    std::vector<int> piece_of(parents_.size());
    for (size_t i = 0; i < pieces_.size(); ++i)
      std::fill(piece_of.begin() + pieces_[i].first, piece_of.begin() + pieces_[i].end,
                static_cast<int>(i));
    const auto above = [&](const SupernodePiece& piece) {
      const int p = parents_[piece.end - 1];
      return p < 0 ? -1 : piece_of[p];
    };
    std::vector<SupernodePiece> all;
    all.swap(pieces_);
    for (const SupernodePiece& piece : all) {
      if (piece.subtree && fits(piece) && pieces_.back().subtree &&
          above(pieces_.back()) == above(piece)) {
        pieces_.back().end = piece.end;
        pieces_.back().entries += piece.entries;
      } else {
        pieces_.push_back(piece);
      }
    }
  }

  // The rows of so many columns stay in a second-level cache.
  static constexpr int most_columns = 8192;
  const std::vector<int>& parents_;
  const std::vector<int>& columns_;
  const std::vector<long>& entries_;
  const long most_entries_;
  std::vector<int> first_;   // supernode of each subtree
  std::vector<long> below_;  // entries of each subtree
  std::vector<long> largest_child_;
  std::vector<SupernodePiece> pieces_;
};

}  // namespace

std::vector<SupernodePiece> cut_into_pieces(const std::vector<int>& parents,
                                            const std::vector<int>& columns,
                                            const std::vector<long>& entries) {
  return Cutter(parents, columns, entries).cut();
}

}  // namespace batten
