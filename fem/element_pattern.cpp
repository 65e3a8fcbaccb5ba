// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/element_pattern.h"

#include <algorithm>
#include <limits>

#include "batten/core/cancellation.h"
#include "batten/core/errors.h"
#include "batten/core/op_counter.h"
#include "batten/core/parallel.h"

namespace batten {

namespace {

constexpr int kPollElements = 256;  // elements of a shell: 10 ms

std::vector<int> equal_starts(int per_element, int entries) {
  std::vector<int> starts;
  for (int s = 0; s <= entries; s += per_element) starts.push_back(s);
  return starts;
}

// Elements of each dof, as positions in the concatenated list of element dofs.
class ElementsOfDofs {
 public:
  ElementsOfDofs(int dof_count, const std::vector<int>& starts, const std::vector<int>& dofs)
      : starts_(starts),
        dofs_(dofs),
        element_of_(dofs.size()),
        start_(dof_count + 1, 0),
        uses_(dofs.size()) {
    throw_if_cancelled();
    for (int e = 0; e < isize(starts) - 1; ++e)
      std::fill(element_of_.begin() + starts[e], element_of_.begin() + starts[e + 1], e);
    for (int u = 0; u < isize(dofs); ++u) {
      poll_every<1 << 20>(u);
      ++start_[dofs[u] + 1];
    }
    for (int d = 0; d < dof_count; ++d) start_[d + 1] += start_[d];
    std::vector<int> next(start_.begin(), start_.end() - 1);
    for (int u = 0; u < isize(dofs); ++u) {
      poll_every<1 << 19>(u);
      uses_[next[dofs[u]]++] = u;
    }
  }

  bool none(int d) const { return start_[d] == start_[d + 1]; }
  int first(int d) const { return element_of_[uses_[start_[d]]]; }

  bool same(int c, int d) const {
    if (c < 0 || none(d) || start_[d] - start_[c] != start_[d + 1] - start_[d]) return false;
    for (int i = start_[c], j = start_[d]; i < start_[d]; ++i, ++j)
      if (element_of_[uses_[i]] != element_of_[uses_[j]]) return false;
    return true;
  }

  // Calls visit(element, local index of d) for each element of d.
  template <class Visit>
  void for_each(int d, const Visit& visit) const {
    for (int s = start_[d]; s < start_[d + 1]; ++s) {
      const int e = element_of_[uses_[s]];
      visit(e, uses_[s] - starts_[e]);
    }
  }

  // Collects d and the higher dofs that share an element with it, ascending. `place` must be -1 for
  // all dofs on entry and is 0 for the collected ones on return.
  void collect_rows(int d, std::vector<int>& place, std::vector<int>& rows) const {
    rows.assign(1, d);
    place[d] = 0;
    for_each(d, [&](int e, int) {
      for (int i = starts_[e]; i < starts_[e + 1]; ++i)
        if (const int other = dofs_[i]; other > d && place[other] < 0) {
          place[other] = 0;
          rows.push_back(other);
        }
    });
    std::sort(rows.begin(), rows.end());
  }

 private:
  const std::vector<int>&starts_, &dofs_;
  std::vector<int> element_of_;    // for each position in the list
  std::vector<int> start_, uses_;  // for each dof
};

}  // namespace

ElementPattern::ElementPattern(int dof_count, int per_element, std::vector<int> dofs)
    : ElementPattern(dof_count, equal_starts(per_element, isize(dofs)), dofs) {}

ElementPattern::ElementPattern(int dof_count, std::vector<int> starts, std::vector<int> dofs)
    : starts_(std::move(starts)), dofs_(std::move(dofs)) {
  first_pair_.assign(1, 0);
  for (int e = 0; e < element_count(); ++e) {
    const long n = size_of(e);
    largest_ = std::max(largest_, size_of(e));
    first_pair_.push_back(first_pair_.back() + n * (n + 1) / 2);
  }
  throw_if_cancelled();
  const ElementsOfDofs elements(dof_count, starts_, dofs_);
  first_element_.assign(dof_count, std::numeric_limits<int>::max());
  for (int d = 0; d < dof_count; ++d)
    if (!elements.none(d)) {
      first_element_[d] = elements.first(d);
      first_elements_ = std::max(first_elements_, elements.first(d) + 1);
    }

  position_.resize(static_cast<size_t>(first_pair_.back()));
  column_.assign(1, 0);
  std::vector<int> place(dof_count, -1), rows;
  for (int d = 0; d < dof_count; ++d) {
    poll_every<512>(d);
    if (elements.same(d - 1, d))
      rows.erase(rows.begin());  // the previous column without its diagonal entry
    else
      elements.collect_rows(d, place, rows);
    append_column(rows, place);
    elements.for_each(d, [&](int e, int b) { locate_entries(e, b, place); });
    for (const int r : rows) place[r] = -1;
  }
}

void ElementPattern::append_column(const std::vector<int>& rows, std::vector<int>& place) {
  const int base = isize(row_);
  if (static_cast<long>(row_.size()) + static_cast<long>(rows.size()) >
      std::numeric_limits<int>::max())
    throw InputError("the assembled matrix has more than 2^31 entries");
  for (size_t r = 0; r < rows.size(); ++r) place[rows[r]] = base + static_cast<int>(r);
  row_.insert(row_.end(), rows.begin(), rows.end());
  column_.push_back(isize(row_));
}

void ElementPattern::locate_entries(int e, int b, const std::vector<int>& place) {
  const int* element = &dofs_[starts_[e]];
  int* position = &position_[first_pair_[e]];
  for (int a = 0; a < size_of(e); ++a)
    if (element[a] >= element[b]) {
      const int high = std::max(a, b), low = std::min(a, b);
      position[high * (high + 1) / 2 + low] = place[element[a]];
    }
}

SparseMatrix ElementPattern::zero() const {
  const long n = static_cast<long>(column_.size()) - 1;
  SparseMatrix matrix(n, n);
  matrix.resizeNonZeros(static_cast<long>(row_.size()));
  std::copy(column_.begin(), column_.end(), matrix.outerIndexPtr());
  constexpr size_t block = 1 << 20;  // entries; 5 ms
  for (size_t first = 0; first < row_.size(); first += block) {
    throw_if_cancelled();
    const size_t count = std::min(block, row_.size() - first);
    std::copy_n(row_.data() + first, count, matrix.innerIndexPtr() + first);
    std::fill_n(matrix.valuePtr() + first, count, 0.0);
  }
  return matrix;
}

int ElementPattern::owner(int dof, int parts) const {
  return static_cast<int>(static_cast<long>(first_element_[dof]) * parts / first_elements_);
}

std::vector<ElementPattern::Part> ElementPattern::split(int parts) const {
  std::vector<Part> result(parts);
  std::vector<int> owners;
  for (int e = 0; e < element_count(); ++e) {
    poll_every<4096>(e);
    owners.clear();
    for (int i = starts_[e]; i < starts_[e + 1]; ++i) owners.push_back(owner(dofs_[i], parts));
    std::sort(owners.begin(), owners.end());
    owners.erase(std::unique(owners.begin(), owners.end()), owners.end());
    for (const int p : owners) {
      result[p].elements.push_back(e);
      result[p].shared.push_back(owners.size() > 1);
    }
  }
  return result;
}

void ElementPattern::assemble(const std::function<void(int, double*)>& element,
                              SparseMatrix& matrix) const {
  if (matrix.rows() + 1 != static_cast<long>(column_.size()) ||
      matrix.nonZeros() != static_cast<long>(row_.size()))
    throw InputError(
        "the matrix to assemble into does not have the sparsity pattern of these elements");
  count(OpCounter::AssembledElement, element_count());
  double* values = matrix.valuePtr();
  update_progress("assembly", 0);
  std::fill_n(values, row_.size(), 0.0);
  constexpr int kMinWorkPerThread = 500;
  const int parts = std::clamp(element_count() / kMinWorkPerThread, 1, thread_count());

  const auto scatter_all = [&](int e, const double* K) {
    const int* position = &position_[first_pair_[e]];
    const int n = size_of(e);
    for (int a = 0; a < n; ++a)
      for (int b = 0; b <= a; ++b) values[*position++] += K[n * a + b];
  };
  if (parts == 1) {
    std::vector<double> K(static_cast<size_t>(largest_) * largest_);
    for (int e = 0; e < element_count(); ++e) {
      if (e % kPollElements == 0) update_progress("assembly", 1.0 * e / element_count());
      element(e, K.data());
      scatter_all(e, K.data());
    }
    update_progress("assembly", 1);
    return;
  }
  const std::vector<Part> split_parts = split(parts);
  parallel_for(parts, [&](int part) {
    std::vector<double> K(static_cast<size_t>(largest_) * largest_);
    const Part& mine = split_parts[part];
    const auto report = [&](size_t done) {
      update_progress(
          "assembly",
          (part + static_cast<double>(done) / static_cast<double>(mine.elements.size())) / parts);
    };
    for (size_t i = 0; i < mine.elements.size(); ++i) {
      if (i % kPollElements == 0) report(i);
      const int e = mine.elements[i];
      element(e, K.data());
      if (!mine.shared[i]) {
        scatter_all(e, K.data());
        continue;
      }
      // An entry belongs to the owner of its column, the lower one of its two dofs.
      const int* position = &position_[first_pair_[e]];
      const int* dof = &dofs_[starts_[e]];
      const int n = size_of(e);
      for (int a = 0; a < n; ++a)
        for (int b = 0; b <= a; ++b, ++position) {
          const int column = std::min(dof[a], dof[b]);
          if (owner(column, parts) == part) values[*position] += K[n * a + b];
        }
    }
  });
  update_progress("assembly", 1);
}

}  // namespace batten
