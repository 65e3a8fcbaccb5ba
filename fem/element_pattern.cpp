#include "batten/fem/element_pattern.h"

#include <algorithm>
#include <limits>

#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/core/work.h"

namespace batten {

ElementPattern::ElementPattern(int dof_count, int per_element, std::vector<int> dofs)
    : per_element_(per_element),
      pairs_(per_element * (per_element + 1) / 2),
      dofs_(std::move(dofs)) {
  const int n = per_element_, elements = element_count();

  // Elements of each dof, as (element·n + local) in one array.
  std::vector<int> start(dof_count + 1, 0), uses(dofs_.size());
  for (const int d : dofs_) ++start[d + 1];
  for (int d = 0; d < dof_count; ++d) start[d + 1] += start[d];
  {
    std::vector<int> next(start.begin(), start.end() - 1);
    for (int u = 0; u < count_of(dofs_); ++u) uses[next[dofs_[u]]++] = u;
  }
  first_element_.assign(dof_count, std::numeric_limits<int>::max());
  for (int d = 0; d < dof_count; ++d)
    if (start[d] < start[d + 1]) first_element_[d] = uses[start[d]] / n;

  const auto same_elements = [&](int c, int d) {
    if (c < 0 || start[d] == start[d + 1] || start[d] - start[c] != start[d + 1] - start[d])
      return false;
    for (int i = start[c], j = start[d]; i < start[d]; ++i, ++j)
      if (uses[i] / n != uses[j] / n) return false;
    return true;
  };
  position_.resize(static_cast<size_t>(elements) * pairs_);
  column_.assign(1, 0);
  std::vector<int> place(dof_count, -1), rows;
  for (int d = 0; d < dof_count; ++d) {
    if (same_elements(d - 1, d)) {
      rows.erase(rows.begin());  // the column before without its diagonal entry
    } else {
      rows.assign(1, d);
      place[d] = 0;
      for (int s = start[d]; s < start[d + 1]; ++s) {
        const int* element = &dofs_[static_cast<size_t>(uses[s] / n) * n];
        for (int a = 0; a < n; ++a)
          if (element[a] > d && place[element[a]] < 0) {
            place[element[a]] = 0;
            rows.push_back(element[a]);
          }
      }
      std::sort(rows.begin(), rows.end());
    }
    const int base = count_of(row_);
    if (static_cast<long>(row_.size()) + static_cast<long>(rows.size()) >
        std::numeric_limits<int>::max())
      throw InputError("the assembled matrix has more than 2^31 entries");
    for (size_t r = 0; r < rows.size(); ++r) place[rows[r]] = base + static_cast<int>(r);
    row_.insert(row_.end(), rows.begin(), rows.end());
    for (int s = start[d]; s < start[d + 1]; ++s) {
      const int e = uses[s] / n, b = uses[s] % n;
      const int* element = &dofs_[static_cast<size_t>(e) * n];
      int* position = &position_[static_cast<size_t>(e) * pairs_];
      for (int a = 0; a < n; ++a)
        if (element[a] >= d) {
          const int high = std::max(a, b), low = std::min(a, b);
          position[high * (high + 1) / 2 + low] = place[element[a]];
        }
    }
    for (const int r : rows) place[r] = -1;
    column_.push_back(count_of(row_));
  }
}

SparseMatrix ElementPattern::zero() const {
  const long n = static_cast<long>(column_.size()) - 1;
  SparseMatrix matrix(n, n);
  matrix.resizeNonZeros(static_cast<long>(row_.size()));
  std::copy(column_.begin(), column_.end(), matrix.outerIndexPtr());
  std::copy(row_.begin(), row_.end(), matrix.innerIndexPtr());
  std::fill_n(matrix.valuePtr(), row_.size(), 0.0);
  return matrix;
}

std::vector<ElementPattern::Part> ElementPattern::split(int parts) const {
  const long elements = element_count();
  std::vector<Part> result(parts);
  std::vector<int> owners;
  for (int e = 0; e < elements; ++e) {
    owners.clear();
    for (int a = 0; a < per_element_; ++a) {
      const int first = first_element_[dofs_[static_cast<size_t>(e) * per_element_ + a]];
      owners.push_back(static_cast<int>(static_cast<long>(first) * parts / elements));
    }
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
    throw InputError("the matrix to assemble into does not have the pattern of these elements");
  count(Work::AssembledElement, element_count());
  double* values = matrix.valuePtr();
  std::fill_n(values, row_.size(), 0.0);
  const int n = per_element_;
  constexpr int worth_a_thread = 500;
  const int parts = std::clamp(element_count() / worth_a_thread, 1, thread_count());

  const auto scatter_all = [&](int e, const double* K) {
    const int* position = &position_[static_cast<size_t>(e) * pairs_];
    for (int a = 0; a < n; ++a)
      for (int b = 0; b <= a; ++b) values[*position++] += K[n * a + b];
  };
  if (parts == 1) {
    std::vector<double> K(static_cast<size_t>(n) * n);
    for (int e = 0; e < element_count(); ++e) {
      element(e, K.data());
      scatter_all(e, K.data());
    }
    return;
  }
  const std::vector<Part> split_parts = split(parts);
  const long elements = element_count();
  parallel_parts(parts, [&](int part) {
    std::vector<double> K(static_cast<size_t>(n) * n);
    const Part& mine = split_parts[part];
    for (size_t i = 0; i < mine.elements.size(); ++i) {
      const int e = mine.elements[i];
      element(e, K.data());
      if (!mine.shared[i]) {
        scatter_all(e, K.data());
        continue;
      }
      // An entry belongs to the owner of its column, the lower of its two dofs.
      const int* position = &position_[static_cast<size_t>(e) * pairs_];
      const int* dof = &dofs_[static_cast<size_t>(e) * n];
      for (int a = 0; a < n; ++a)
        for (int b = 0; b <= a; ++b, ++position) {
          const int column = std::min(dof[a], dof[b]);
          if (static_cast<long>(first_element_[column]) * parts / elements == part)
            values[*position] += K[n * a + b];
        }
    }
  });
}

}  // namespace batten
