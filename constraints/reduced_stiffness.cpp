// DᵀKD of an AffineReduction.
#include <algorithm>
#include <numeric>

#include "batten/constraints/affine_reduction.h"
#include "batten/core/errors.h"
#include "batten/core/memory.h"
#include "batten/core/parallel.h"

namespace batten {
namespace {

using RowMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor, int>;

// Rows and columns of the free dofs alone.
SparseMatrix submatrix(const SparseMatrix& K, const std::vector<int>& free_dofs) {
  std::vector<int> free_of(K.rows(), -1);
  for (size_t f = 0; f < free_dofs.size(); ++f) free_of[free_dofs[f]] = static_cast<int>(f);
  const auto n = static_cast<long>(free_dofs.size());
  SparseMatrix part(n, n);
  part.reserve(K.nonZeros());
  for (long f = 0; f < n; ++f) {
    part.startVec(f);
    for (SparseMatrix::InnerIterator it(K, free_dofs[f]); it; ++it)
      if (const int row = free_of[it.row()]; row >= f) part.insertBack(row, f) = it.value();
  }
  part.finalize();
  return part;
}

// Some columns of a lower triangle.
struct Columns {
  std::vector<int> sizes, rows;
  std::vector<double> values;
};

// A sparse sum of multiples of rows, of which the part from one index on is wanted.
class ColumnSum {
 public:
  explicit ColumnSum(long size) : values_(size, 0.0), present_(size, 0) {}

  void add(int row, double value) {
    if (!present_[row]) {
      present_[row] = 1;
      rows_.push_back(row);
    }
    values_[row] += value;
  }
  void add(double factor, const RowMatrix& M, int of_row, int from) {
    const int* begin = M.innerIndexPtr() + M.outerIndexPtr()[of_row];
    const int* end = M.innerIndexPtr() + M.outerIndexPtr()[of_row + 1];
    for (const int* at = std::lower_bound(begin, end, from); at != end; ++at)
      add(*at, factor * M.valuePtr()[at - M.innerIndexPtr()]);
  }
  void move_to(Columns& columns) {
    std::sort(rows_.begin(), rows_.end());
    columns.sizes.push_back(isize(rows_));
    for (const int row : rows_) {
      columns.rows.push_back(row);
      columns.values.push_back(values_[row]);
      values_[row] = 0;
      present_[row] = 0;
    }
    rows_.clear();
  }

 private:
  std::vector<double> values_;
  std::vector<char> present_;
  std::vector<int> rows_;
};

// Asks for the memory of n columns, whose entries nobody has counted, when some of them are made:
// as columns, in the matrix made of them, and in the pattern that a factor is planned with.
void require_room(const Columns& made, long column, long n) {
  constexpr double as_column = 12, later = 12 + 8;
  const double entries = static_cast<double>(made.rows.size()) * static_cast<double>(n) /
                         static_cast<double>(made.sizes.size());
  const double left = 1 - static_cast<double>(column) / static_cast<double>(n);
  require_memory(entries * (left * as_column + later),
                 "a system whose unknowns long lines tie together (" + format_number(entries) +
                     " entries; a larger edge_length makes fewer)");
}

// The lower triangle of A + GᵀT + TᵀG; A is lower too. Column by column, on all threads.
SparseMatrix with_products(const SparseMatrix& A, const RowMatrix& G, const RowMatrix& T) {
  const SparseMatrix G_columns(G), T_columns(T);
  const long n = A.cols();
  constexpr int most_parts = 32;
  const int parts = static_cast<int>(std::min<long>(n, most_parts));
  std::vector<Columns> made(static_cast<size_t>(parts));
  constexpr size_t many = 1 << 20;
  parallel_for(parts, [&](int part) {
    ColumnSum sum(n);
    size_t asked_at = many;
    for (long j = n * part / parts; j < n * (part + 1) / parts; ++j) {
      const int from = static_cast<int>(j);
      for (SparseMatrix::InnerIterator it(A, j); it; ++it)
        sum.add(static_cast<int>(it.row()), it.value());
      for (SparseMatrix::InnerIterator it(G_columns, j); it; ++it)
        sum.add(it.value(), T, static_cast<int>(it.row()), from);
      for (SparseMatrix::InnerIterator it(T_columns, j); it; ++it)
        sum.add(it.value(), G, static_cast<int>(it.row()), from);
      sum.move_to(made[part]);
      if (made[part].rows.size() < asked_at) continue;
      asked_at += many;
      require_room(made[part], j, n);
    }
  });
  SparseMatrix result(n, n);
  long entries = 0;
  for (const Columns& columns : made) entries += static_cast<long>(columns.rows.size());
  result.resizeNonZeros(entries);
  int* start = result.outerIndexPtr();
  *start = 0;
  int* rows = result.innerIndexPtr();
  double* values = result.valuePtr();
  for (const Columns& columns : made) {
    for (const int size : columns.sizes) {
      start[1] = start[0] + size;
      ++start;
    }
    rows = std::copy(columns.rows.begin(), columns.rows.end(), rows);
    values = std::copy(columns.values.begin(), columns.values.end(), values);
  }
  return result;
}

}  // namespace

SparseMatrix AffineReduction::reduce(const SparseMatrix& K) const {
  const bool stacked = coupled_ && K.rows() == 3L * dof_count_;
  if (K.rows() != dof_count_ && !stacked)
    throw InputError("a matrix of " + std::to_string(K.rows()) + " unknowns under constraints on " +
                     std::to_string(dof_count_) + " dofs a coordinate");
  if (selection_ && stacked == coupled_) return submatrix(K, free_dofs_);
  // With the dofs apart, free ones f and others p = G f:
  // DᵀKD = K_ff + GᵀT + TᵀG, T = K_pf + ½ K_pp G.
  const int columns = static_cast<int>(D_.rows()), free = free_count();
  std::vector<int> free_of(columns, -1), other_of(columns, -1);
  for (int f = 0; f < free; ++f) free_of[free_dofs_[f]] = f;
  int others = 0;
  for (int c = 0; c < columns; ++c)
    if (free_of[c] < 0) other_of[c] = others++;
  std::vector<Triplet> g, of, oo;
  for (int f = 0; f < free; ++f)
    for (SparseMatrix::InnerIterator it(D_, f); it; ++it)
      if (const int p = other_of[it.row()]; p >= 0) g.emplace_back(p, f, it.value());
  // Free dofs keep their order, so K_ff is written column by column.
  SparseMatrix K_ff(free, free);
  K_ff.reserve(K.nonZeros() * (coupled_ && !stacked ? 3 : 1));
  for (int b = 0; b < columns; ++b) {
    const int j = stacked ? b : b % dof_count_, offset = b - j, fb = free_of[b];
    if (fb >= 0) K_ff.startVec(fb);
    for (SparseMatrix::InnerIterator it(K, j); it; ++it) {
      if (it.row() < j) continue;
      const int a = offset + static_cast<int>(it.row()), fa = free_of[a];
      if (fa >= 0 && fb >= 0) {
        K_ff.insertBack(fa, fb) = it.value();
      } else if (fa < 0 && fb < 0) {
        oo.emplace_back(other_of[a], other_of[b], it.value());
        if (a != b) oo.emplace_back(other_of[b], other_of[a], it.value());
      } else {
        of.emplace_back(fa < 0 ? other_of[a] : other_of[b], std::max(fa, fb), it.value());
      }
    }
  }
  K_ff.finalize();
  RowMatrix G(others, free), K_of(others, free), K_oo(others, others);
  G.setFromTriplets(g.begin(), g.end());
  K_of.setFromTriplets(of.begin(), of.end());
  K_oo.setFromTriplets(oo.begin(), oo.end());
  return with_products(K_ff, G, K_of + RowMatrix(0.5 * K_oo * G));
}

}  // namespace batten
