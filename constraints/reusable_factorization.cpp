// SPDX-License-Identifier: MPL-2.0
#include "batten/constraints/reusable_factorization.h"

#include <algorithm>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/solvers/linear_solver_backend.h"

namespace batten {
namespace {

// Nodes of the graph: vertices with at least one free dof of their own.
struct Nodes {
  std::vector<int> of_vertex;   // -1: none of its dofs is free
  std::vector<int> of_unknown;  // -1: belongs to an edge
  int count = 0;
};

Nodes nodes_of(const std::vector<int>& free_dofs, const DofVertices& vertices) {
  Nodes nodes;
  for (const auto& ends : vertices)
    nodes.of_vertex.resize(
        std::max(nodes.of_vertex.size(), static_cast<size_t>(std::max(ends[0], ends[1])) + 1), -1);
  for (const int dof : free_dofs) {
    const auto [a, b] = vertices[dof];
    int& node = nodes.of_vertex[a];
    if (a == b && node < 0) node = nodes.count++;
    nodes.of_unknown.push_back(a == b ? node : -1);
  }
  return nodes;
}

// Graph of the nodes that `reduced` couples, as a lower triangle. The unknowns of a node are
// consecutive.
SparseMatrix graph_of(const SparseMatrix& reduced, const Nodes& nodes) {
  std::vector<int> last(static_cast<size_t>(nodes.count), -1), starts, rows;
  for (int j = 0; j < reduced.cols(); ++j) {
    poll_every<8192>(j);
    const int own = nodes.of_unknown[j];
    if (own < 0) continue;
    if (own == isize(starts)) {
      starts.push_back(isize(rows));
      rows.push_back(own);
      last[own] = own;
    }
    for (SparseMatrix::InnerIterator it(reduced, j); it; ++it) {
      const int other = nodes.of_unknown[it.row()];
      if (other < 0 || last[other] == own) continue;
      last[other] = own;
      rows.push_back(other);
    }
  }
  starts.push_back(isize(rows));
  SparseMatrix graph(nodes.count, nodes.count);
  graph.resizeNonZeros(static_cast<long>(rows.size()));
  std::copy(starts.begin(), starts.end(), graph.outerIndexPtr());
  for (size_t s = 0; s + 1 < starts.size(); ++s) {
    poll_every<16384>(static_cast<long>(s));
    std::sort(rows.begin() + starts[s], rows.begin() + starts[s + 1]);
  }
  std::copy(rows.begin(), rows.end(), graph.innerIndexPtr());
  std::fill_n(graph.valuePtr(), rows.size(), 1.0);
  return graph;
}

}  // namespace

std::vector<int> vertex_ordering(const AffineReduction& reduction, const SparseMatrix& reduced,
                                 const DofVertices& vertices, FactorReuse factor_reuse) {
  const std::vector<int>& free_dofs = reduction.free_dofs();
  if (reduction.coupled() || static_cast<long>(vertices.size()) != reduction.D().rows())
    throw InputError("found the vertices of " + std::to_string(vertices.size()) +
                     " dofs, expected " + std::to_string(reduction.D().rows()) +
                     ", and constraints that do not couple x, y and z");
  update_progress("ordering", 0);
  const Nodes nodes = nodes_of(free_dofs, vertices);
  const std::vector<int> order = elimination_order(graph_of(reduced, nodes), factor_reuse);
  throw_if_cancelled();
  std::vector<int> position(order.size());
  for (size_t i = 0; i < order.size(); ++i) position[order[i]] = static_cast<int>(i) + 1;
  // Edges between vertices without free dofs come first, at position 0.
  const auto position_of = [&](int dof) {
    const auto [a, b] = vertices[dof];
    const int node = nodes.of_vertex[a], other = nodes.of_vertex[b];
    if (node < 0) return other < 0 ? 0 : position[other];
    if (other < 0) return position[node];
    return std::min(position[node], position[other]);
  };
  std::vector<int> starts(order.size() + 2, 0), unknowns(free_dofs.size());
  for (const int dof : free_dofs) ++starts[static_cast<size_t>(position_of(dof)) + 1];
  for (size_t i = 1; i < starts.size(); ++i) starts[i] += starts[i - 1];
  for (size_t f = 0; f < free_dofs.size(); ++f)
    unknowns[starts[position_of(free_dofs[f])]++] = static_cast<int>(f);
  return unknowns;
}

void ReusableFactorization::check(const SparseMatrix& S) const {
  if (reduction_->coupled())
    throw InputError("reusable factorization: constraint equations must not couple x, y and z");
  if (S.rows() != D().rows() || S.cols() != S.rows())
    throw InputError("found a matrix of " + std::to_string(S.rows()) + " × " +
                     std::to_string(S.cols()) + ", expected " + std::to_string(D().rows()) +
                     " rows and columns");
}

ReusableFactorization::ReusableFactorization(std::shared_ptr<const AffineReduction> reduction,
                                             SparseMatrix S, const DofVertices& vertices,
                                             FactorReuse factor_reuse)
    : reduction_(std::move(reduction)) {
  check(S);
  prepare_expansion();
  const SparseMatrix reduced = reduction_->reduce(S);
  order_ = std::make_shared<const std::vector<int>>(
      vertices.empty() ? std::vector<int>()
                       : vertex_ordering(*reduction_, reduced, vertices, factor_reuse));
  factorize(S, reduced, true);
  S_ = std::move(S);
}

ReusableFactorization::ReusableFactorization(const ReusableFactorization& like, SparseMatrix S)
    : reduction_(like.reduction_), order_(like.order_) {
  check(S);
  prepare_expansion();
  factorize(S, reduction_->reduce(S), true);
  S_ = std::move(S);
}

void ReusableFactorization::factorize(const SparseMatrix& S, const SparseMatrix& reduced,
                                      bool analyzes) {
  if (analyzes) factor_.analyze(reduced, *order_);
  // H = Dᵀ (S R).
  const SparseMatrix& R = reduction_->rhs_to_particular();
  SparseMatrix H(free_count(), R.cols());
  if (R.nonZeros() > 0) {
    const SparseMatrix SR = columns_of_constrained(S) * R;
    throw_if_cancelled();
    H = SparseMatrix(D().transpose()) * SR;
  }
  if (!factor_.factorize(reduced)) throw NoSolutionError(factor_.message());
  H_ = std::move(H);
}

// Restricts S to the columns of constrained dofs: they are few, and R is zero in all other rows.
SparseMatrix ReusableFactorization::columns_of_constrained(const SparseMatrix& S) const {
  std::vector<char> constrained(static_cast<size_t>(S.cols()), 0);
  for (const ConstrainedDof& row : constrained_dofs_) constrained[row.dof] = 1;
  std::vector<Triplet> entries;
  for (int j = 0; j < S.cols(); ++j) {
    poll_every<8192>(j);
    for (SparseMatrix::InnerIterator it(S, j); it; ++it) {
      if (it.row() < j) continue;
      const int i = static_cast<int>(it.row());
      if (constrained[j]) entries.emplace_back(i, j, it.value());
      if (i != j && constrained[i]) entries.emplace_back(j, i, it.value());
    }
  }
  SparseMatrix columns(S.rows(), S.cols());
  columns.setFromTriplets(entries.begin(), entries.end());
  return columns;
}

void ReusableFactorization::set_matrix(SparseMatrix S) {
  if (S.nonZeros() != S_.nonZeros() || S.rows() != S_.rows())
    throw InputError("reusable factorization: the new matrix has a different sparsity pattern");
  try {
    factorize(S, reduction_->reduce(S), false);
  } catch (const CancelledError&) {  // the previous factor would take as long
    throw;
  } catch (...) {
    factorize(S_, reduction_->reduce(S_), false);
    throw;
  }
  S_ = std::move(S);
}

void ReusableFactorization::start_load(const MatX& d, MatX& to) const {
  to.setZero();
  if (H_.nonZeros() > 0) to.noalias() -= H_ * d;
}

void ReusableFactorization::prepare_expansion() {
  throw_if_cancelled();
  const Eigen::SparseMatrix<double, Eigen::RowMajor> rows = D();
  std::vector<char> free(static_cast<size_t>(rows.rows()), 0);
  for (const int dof : reduction_->free_dofs()) free[dof] = 1;
  for (int dof = 0; dof < rows.rows(); ++dof) {
    poll_every<65536>(dof);
    if (free[dof]) continue;
    const int begin = isize(terms_);
    for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator it(rows, dof); it; ++it)
      terms_.emplace_back(static_cast<int>(it.col()), it.value());
    constrained_dofs_.push_back({dof, begin, isize(terms_)});
  }
}

void ReusableFactorization::expand(const MatX& y, const Points& e, Points& z) const {
  const auto& free = reduction_->free_dofs();
  for (int c = 0; c < 3; ++c) {
    const double* from = y.col(c).data();
    double* to = z.col(c).data();
    for (size_t f = 0; f < free.size(); ++f) to[free[f]] = from[f];
    for (const ConstrainedDof& row : constrained_dofs_) {
      double sum = e(row.dof, c);
      for (int k = row.begin; k < row.end; ++k) sum += terms_[k].second * from[terms_[k].first];
      to[row.dof] = sum;
    }
  }
}

size_t ReusableFactorization::bytes() const {
  return factor_.bytes() + 12 * static_cast<size_t>(S_.nonZeros() + H_.nonZeros()) +
         sizeof(int) * order_->size() + sizeof(terms_[0]) * terms_.size() +
         sizeof(ConstrainedDof) * constrained_dofs_.size();
}

}  // namespace batten
