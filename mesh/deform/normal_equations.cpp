#include "batten/mesh/deform/normal_equations.h"

#include <algorithm>

#include "batten/core/isize.h"
#include "batten/core/parallel.h"

namespace batten {

RowMatrix reduced_matrix(const RowMatrix& A, const AffineReduction& reduction) {
  const RowMatrix D = reduction.D();
  RowMatrix B(A.rows(), D.cols());
  B.reserve(A.nonZeros());
  std::vector<std::pair<int, double>> terms;
  for (long r = 0; r < A.rows(); ++r) {
    terms.clear();
    for (RowMatrix::InnerIterator a(A, r); a; ++a)
      for (RowMatrix::InnerIterator d(D, a.col()); d; ++d)
        terms.emplace_back(d.col(), a.value() * d.value());
    std::stable_sort(terms.begin(), terms.end(),
                     [](const auto& x, const auto& y) { return x.first < y.first; });
    B.startVec(r);
    for (size_t i = 0; i < terms.size();) {
      const int column = terms[i].first;
      double sum = 0;
      for (; i < terms.size() && terms[i].first == column; ++i) sum += terms[i].second;
      B.insertBack(r, column) = sum;
    }
  }
  B.finalize();
  return B;
}

SparseMatrix normal_matrix(const SparseMatrix& B, const RowMatrix& rows) {
  const long n = B.cols();
  const long block = std::max<long>(2048, n / 8 + 1), blocks = (n + block - 1) / block;
  std::vector<std::vector<int>> index(blocks);
  std::vector<std::vector<double>> value(blocks);
  std::vector<int> length(n, 0);
  parallel_for(static_cast<int>(blocks), [&](int part) {
    std::vector<double> sum(n, 0);
    std::vector<int> mark(n, -1), list;
    const long first = part * block, last = std::min(n, first + block);
    for (long c = first; c < last; ++c) {
      list.clear();
      for (SparseMatrix::InnerIterator b(B, c); b; ++b) {
        const int* columns = rows.innerIndexPtr();
        const double* values = rows.valuePtr();
        const int end = rows.outerIndexPtr()[b.row() + 1];
        int k = end;
        while (k > rows.outerIndexPtr()[b.row()] && columns[k - 1] >= c) --k;
        for (; k < end; ++k) {
          const int r = columns[k];
          if (mark[r] != c) {
            mark[r] = static_cast<int>(c);
            sum[r] = 0;
            list.push_back(r);
          }
          sum[r] += b.value() * values[k];
        }
      }
      std::sort(list.begin(), list.end());
      length[c] = isize(list);
      for (const int r : list) {
        index[part].push_back(r);
        value[part].push_back(sum[r]);
      }
    }
  });
  SparseMatrix N(n, n);
  long entries = 0;
  for (const auto& part : index) entries += static_cast<long>(part.size());
  N.resizeNonZeros(entries);
  long at = 0;
  for (long p = 0; p < blocks; ++p) {
    std::copy(index[p].begin(), index[p].end(), N.innerIndexPtr() + at);
    std::copy(value[p].begin(), value[p].end(), N.valuePtr() + at);
    at += static_cast<long>(index[p].size());
  }
  N.outerIndexPtr()[0] = 0;
  for (long c = 0; c < n; ++c) N.outerIndexPtr()[c + 1] = N.outerIndexPtr()[c] + length[c];
  return N;
}

}  // namespace batten
