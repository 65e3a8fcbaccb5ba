#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>
#include <cmath>
#include <limits>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/solvers/supernodal_factor.h"
#include "batten/core/solvers/symbolic_analysis.h"

namespace batten {
namespace {

using Permutation = Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int>;

// Parent of each column in the elimination tree of a lower triangle, or -1. Reference: [Liu1986].
std::vector<int> elimination_tree(const SparseMatrix& lower) {
  const auto n = static_cast<int>(lower.rows());
  const SparseMatrix upper = lower.transpose();  // its columns are the rows of `lower`
  std::vector<int> parent(n, -1), ancestor(n, -1);
  for (int row = 0; row < n; ++row)
    for (SparseMatrix::InnerIterator e(upper, row); e && e.row() < row; ++e)
      for (int node = static_cast<int>(e.row()); node >= 0 && node != row;) {
        const int next = std::exchange(ancestor[node], row);
        if (next < 0) parent[node] = row;
        node = next;
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

}  // namespace

struct SupernodalFactor::Data {
  Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower, Eigen::NaturalOrdering<int>> ldlt;
  std::vector<int> order;  // unknown of each row of L
  std::vector<int> columns, row_starts, rows, value_starts;
  std::vector<double> values;

  SparseMatrix permuted(const SparseMatrix& A) const {
    Permutation place(A.rows());
    for (int i = 0; i < A.rows(); ++i) place.indices()[order[i]] = i;
    SparseMatrix result(A.rows(), A.cols());
    result.selfadjointView<Eigen::Lower>() = A.selfadjointView<Eigen::Lower>().twistedBy(place);
    return result;
  }
  void find_supernodes();
  void fill_blocks();
};

SupernodalFactor::SupernodalFactor() : data_(std::make_unique<Data>()) {}
SupernodalFactor::~SupernodalFactor() = default;

void SupernodalFactor::analyze(const SparseMatrix& A, const std::vector<int>& order, FactorReuse) {
  Data& d = *data_;
  d.columns.clear();
  d.order = order;
  if (order.empty()) {
    SparseMatrix full = A.selfadjointView<Eigen::Lower>();
    Permutation amd;
    Eigen::AMDOrdering<int>()(full, amd);
    d.order.assign(amd.indices().data(), amd.indices().data() + amd.size());
  }
  const std::vector<int> post = postorder(elimination_tree(d.permuted(A)));
  std::vector<int> given = std::exchange(d.order, {});
  for (const int node : post) d.order.push_back(given[node]);
  d.ldlt.analyzePattern(d.permuted(A));
}

// Merges neighbouring columns of L into supernodes: the rows of the first must be the next column
// and its rows.
void SupernodalFactor::Data::find_supernodes() {
  const SparseMatrix& L = ldlt.matrixL().nestedExpression();
  const int* start = L.outerIndexPtr();
  const int* row = L.innerIndexPtr();
  std::vector<int> first_columns = {0};
  row_starts = value_starts = {0};
  rows.clear();
  long size = 0;
  const auto n = static_cast<int>(L.rows());
  for (int j = 1; j <= n; ++j) {
    const int before = start[j] - start[j - 1];
    if (j < n && before > 0 && row[start[j - 1]] == j && before == start[j + 1] - start[j] + 1)
      continue;
    const int first = first_columns.back();
    rows.push_back(first);
    rows.insert(rows.end(), row + start[first], row + start[first + 1]);
    size += static_cast<long>(j - first) * (1 + start[first + 1] - start[first]);
    if (size > std::numeric_limits<int>::max())
      throw NoSolutionError("the symbolic factorization failed: the matrix is too large");
    first_columns.push_back(j);
    row_starts.push_back(isize(rows));
    value_starts.push_back(static_cast<int>(size));
  }
  columns = std::move(first_columns);  // assigned at the end: either complete or still empty
}

void SupernodalFactor::Data::fill_blocks() {
  const SparseMatrix& L = ldlt.matrixL().nestedExpression();
  const VecX D = ldlt.vectorD();
  values.resize(value_starts.back());
  for (size_t s = 0; s + 1 < columns.size(); ++s) {
    const int height = row_starts[s + 1] - row_starts[s];
    for (int j = columns[s]; j < columns[s + 1]; ++j) {
      const int k = j - columns[s];
      double* to = values.data() + value_starts[s] + static_cast<long>(k) * height + k;
      const double scale = std::sqrt(D[j]);
      *to++ = scale;
      for (SparseMatrix::InnerIterator e(L, j); e; ++e) *to++ = e.value() * scale;
    }
  }
}

std::string SupernodalFactor::factorize(const SparseMatrix& A) {
  Data& d = *data_;
  d.ldlt.factorize(d.permuted(A));
  const VecX D = d.ldlt.vectorD(), diagonal = A.diagonal();
  for (int i = 0; i < D.size(); ++i)
    if (!(D[i] > kSingularPivot * diagonal[d.order[i]])) return not_positive_definite(d.order[i]);
  if (d.ldlt.info() != Eigen::Success) return "the numeric factorization failed";
  if (d.columns.empty()) d.find_supernodes();
  d.fill_blocks();
  return "";
}

SupernodalPattern SupernodalFactor::pattern() const {
  const Data& d = *data_;
  return {isize(d.columns) - 1, d.columns.data(), d.row_starts.data(), d.rows.data(),
          d.value_starts.data()};
}

const int* SupernodalFactor::order() const { return data_->order.data(); }

double* SupernodalFactor::values() { return data_->values.data(); }

const char* SupernodalFactor::backend() { return "Eigen"; }

std::vector<int> elimination_order(const SparseMatrix& graph, FactorReuse) {
  if (graph.rows() == 0) return {};
  SparseMatrix full = graph.selfadjointView<Eigen::Lower>();
  Permutation amd;
  Eigen::AMDOrdering<int>()(full, amd);
  return {amd.indices().data(), amd.indices().data() + amd.size()};
}

}  // namespace batten
