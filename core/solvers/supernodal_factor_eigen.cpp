// SPDX-License-Identifier: MPL-2.0
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/solvers/supernodal_factor.h"

namespace batten {
namespace {

using Permutation = Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int>;

// Parent of each column in the elimination tree of a lower triangle, or -1. Reference: [Liu1986].
std::vector<int> elimination_tree(const SparseMatrix& lower) {
  const auto n = static_cast<int>(lower.rows());
  const SparseMatrix upper = lower.transpose();  // its columns are the rows of `lower`
  std::vector<int> parent(n, -1), ancestor(n, -1);
  for (int row = 0; row < n; ++row) {
    poll_every<4096>(row);
    for (SparseMatrix::InnerIterator e(upper, row); e && e.row() < row; ++e)
      for (int node = static_cast<int>(e.row()); node >= 0 && node != row;) {
        const int next = std::exchange(ancestor[node], row);
        if (next < 0) parent[node] = row;
        node = next;
      }
  }
  return parent;
}

// Postorder of a forest: children before their parents, every subtree contiguous.
std::vector<int> postorder(const std::vector<int>& parent) {
  const auto n = isize(parent);
  std::vector<int> first_child(n, -1), next_sibling(n, -1), order, path;
  for (int node = n - 1; node >= 0; --node)
    if (parent[node] >= 0) next_sibling[node] = std::exchange(first_child[parent[node]], node);
  for (int root = 0; root < n; ++root) {
    if (parent[root] >= 0) continue;
    path.push_back(root);
    while (!path.empty()) {
      const int child = first_child[path.back()];
      if (child >= 0) {
        first_child[path.back()] = next_sibling[child];
        path.push_back(child);
      } else {
        order.push_back(path.back());
        path.pop_back();
      }
    }
  }
  return order;
}

// Calls with fewer rows take some milliseconds and are not worth a thread.
constexpr long kMinRowsForThread = 4000;

// Calls a function of Eigen, which cannot poll.
template <class Work>
void call_eigen(long rows, const Work& work) {
  if (rows < kMinRowsForThread)
    work();
  else
    call_without_polls(work);
}

class EigenFactor final : public SupernodalFactor {
 public:
  void analyze(const SparseMatrix& A, const std::vector<int>& order, FactorReuse) override;
  std::string factorize(const SparseMatrix& A) override;
  SupernodalPattern pattern() const override {
    return {isize(columns_) - 1, columns_.data(), row_starts_.data(), rows_.data(),
            value_starts_.data()};
  }
  const int* order() const override { return order_.data(); }
  double* values() override { return values_.data(); }

 private:
  SparseMatrix permuted(const SparseMatrix& A) const {
    Permutation place(A.rows());
    for (int i = 0; i < A.rows(); ++i) place.indices()[order_[i]] = i;
    SparseMatrix result(A.rows(), A.cols());
    result.selfadjointView<Eigen::Lower>() = A.selfadjointView<Eigen::Lower>().twistedBy(place);
    return result;
  }
  void find_supernodes();
  void fill_blocks();

  using Factor = Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower, Eigen::NaturalOrdering<int>>;
  std::shared_ptr<Factor> ldlt_;  // null: not analysed, or left to a thread by a cancellation
  std::vector<int> order_;  // unknown of each row of L
  std::vector<int> columns_, row_starts_, rows_, value_starts_;
  std::vector<double> values_;
};

void EigenFactor::analyze(const SparseMatrix& A, const std::vector<int>& order, FactorReuse) {
  columns_.clear();
  ldlt_.reset();
  order_ = order.empty() ? eigen_elimination_order(A, FactorReuse::once) : order;
  const std::vector<int> post = postorder(elimination_tree(permuted(A)));
  std::vector<int> given = std::exchange(order_, {});
  for (const int node : post) order_.push_back(given[node]);
  const auto ldlt = std::make_shared<Factor>();
  const auto matrix = std::make_shared<const SparseMatrix>(permuted(A));
  call_eigen(A.rows(), [ldlt, matrix] { ldlt->analyzePattern(*matrix); });
  ldlt_ = ldlt;
}

// Merges neighbouring columns of L into supernodes: the rows of the first must be the next column
// and its rows.
void EigenFactor::find_supernodes() {
  const SparseMatrix& L = ldlt_->matrixL().nestedExpression();
  const int* start = L.outerIndexPtr();
  const int* row = L.innerIndexPtr();
  std::vector<int> first_columns = {0};
  row_starts_ = value_starts_ = {0};
  rows_.clear();
  long size = 0;
  const auto n = static_cast<int>(L.rows());
  for (int j = 1; j <= n; ++j) {
    const int before = start[j] - start[j - 1];
    if (j < n && before > 0 && row[start[j - 1]] == j && before == start[j + 1] - start[j] + 1)
      continue;
    const int first = first_columns.back();
    rows_.push_back(first);
    rows_.insert(rows_.end(), row + start[first], row + start[first + 1]);
    size += static_cast<long>(j - first) * (1 + start[first + 1] - start[first]);
    if (size > std::numeric_limits<int>::max())
      throw NoSolutionError("the symbolic factorization failed: the matrix is too large");
    first_columns.push_back(j);
    row_starts_.push_back(isize(rows_));
    value_starts_.push_back(static_cast<int>(size));
  }
  columns_ = std::move(first_columns);  // assigned at the end: either complete or still empty
}

void EigenFactor::fill_blocks() {
  const SparseMatrix& L = ldlt_->matrixL().nestedExpression();
  const VecX D = ldlt_->vectorD();
  values_.resize(value_starts_.back());
  for (size_t s = 0; s + 1 < columns_.size(); ++s) {
    const int height = row_starts_[s + 1] - row_starts_[s];
    for (int j = columns_[s]; j < columns_[s + 1]; ++j) {
      const int k = j - columns_[s];
      double* to = values_.data() + value_starts_[s] + static_cast<long>(k) * height + k;
      const double scale = std::sqrt(D[j]);
      *to++ = scale;
      for (SparseMatrix::InnerIterator e(L, j); e; ++e) *to++ = e.value() * scale;
    }
  }
}

std::string EigenFactor::factorize(const SparseMatrix& A) {
  const auto matrix = std::make_shared<const SparseMatrix>(permuted(A));
  // Not in use by a thread that continues after a cancellation.
  auto ldlt = std::exchange(ldlt_, nullptr);
  const bool anew = !ldlt;
  if (anew) ldlt = std::make_shared<Factor>();
  call_eigen(A.rows(), [ldlt, matrix, anew] {
    if (anew) ldlt->analyzePattern(*matrix);
    ldlt->factorize(*matrix);
  });
  ldlt_ = std::move(ldlt);
  const VecX D = ldlt_->vectorD(), diagonal = A.diagonal();
  for (int i = 0; i < D.size(); ++i)
    if (!(D[i] > kSingularPivot * diagonal[order_[i]])) return not_positive_definite(order_[i]);
  if (ldlt_->info() != Eigen::Success) return "the numeric factorization failed";
  if (columns_.empty()) find_supernodes();
  fill_blocks();
  return "";
}

}  // namespace

std::unique_ptr<SupernodalFactor> make_eigen_factor() { return std::make_unique<EigenFactor>(); }

std::vector<int> eigen_elimination_order(const SparseMatrix& graph, FactorReuse) {
  const auto full = std::make_shared<SparseMatrix>(graph.selfadjointView<Eigen::Lower>());
  const auto amd = std::make_shared<Permutation>();
  call_eigen(graph.rows(), [full, amd] { Eigen::AMDOrdering<int>()(*full, *amd); });
  return {amd->indices().data(), amd->indices().data() + amd->size()};
}

}  // namespace batten
