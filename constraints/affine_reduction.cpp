// SPDX-License-Identifier: MPL-2.0
#include "batten/constraints/affine_reduction.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "batten/core/cancellation.h"
#include "batten/core/errors.h"
#include "batten/core/memory.h"
#include "batten/core/parallel.h"

namespace batten {
namespace {

// Relative weight below which an equation takes no part in a conflict.
constexpr double kPart = 1e-9;
// Relative to the largest coefficient: cancellation error.
constexpr double kNoise = 1e-14;
// Relative to the pivot: coefficients decay along a chain of equations.
constexpr double kNegligible = 1e-16;
constexpr double kConflictTolerance = 1e-9;  // relative to the right-hand sides involved
constexpr double kRhsNoise = 1e-12;          // relative to the largest right-hand side of all
constexpr int kPollEquations = 64;           // equations; some milliseconds if they are long

using Terms = std::vector<std::pair<int, double>>;  // sorted by index

// target += s · source; both are sorted.
void add_scaled(Terms& target, double s, const Terms& source) {
  Terms sum;
  sum.reserve(target.size() + source.size());
  auto a = target.begin();
  auto b = source.begin();
  while (a != target.end() || b != source.end()) {
    if (b == source.end() || (a != target.end() && a->first < b->first)) {
      sum.push_back(*a++);
    } else if (a == target.end() || b->first < a->first) {
      sum.emplace_back(b->first, s * b->second);
      ++b;
    } else {
      sum.emplace_back(a->first, a->second + s * b->second);
      ++a;
      ++b;
    }
  }
  target = std::move(sum);
}

// Left-hand side of an equation. `history` is its linear combination of the given equations, which
// also determines its right-hand side.
struct Equation {
  Terms terms;
  Terms history;
  int source = 0, name = 0;
};

// Gauss-Jordan elimination, one equation at a time. Each pivot equation expresses its pivot column
// by columns that are not pivots.
class Elimination {
 public:
  // `given`: all equations that will be added.
  Elimination(int columns, const std::vector<Equation>& given, double dependent)
      : pivot_row_(columns, -1), used_by_(columns), given_(given), dependent_(dependent) {}

  void add(Equation row) {
    const Terms given = row.terms;
    for (const auto& [column, coefficient] : given)
      if (pivot_row_[column] >= 0 && coefficient != 0)
        subtract(row, coefficient, rows_[pivot_row_[column]]);
    double remaining = 0;
    std::erase_if(row.terms, [&](const auto& t) {
      if (pivot_row_[t.first] >= 0 || std::abs(t.second) <= kNoise) return true;
      remaining = std::max(remaining, std::abs(t.second));
      return false;
    });

    if (remaining <= dependent_) {
      redundant_.push_back(std::move(row));
      return;
    }
    const auto pivot = std::max_element(
        row.terms.begin(), row.terms.end(),
        [](const auto& a, const auto& b) { return std::abs(a.second) < std::abs(b.second); });
    const int column = pivot->first;
    scale(row, 1 / pivot->second);
    const int index = isize(rows_);
    for (const int user : std::set<int>(used_by_[column].begin(), used_by_[column].end())) {
      const auto it = std::lower_bound(rows_[user].terms.begin(), rows_[user].terms.end(),
                                       std::pair<int, double>(column, -INFINITY));
      if (it == rows_[user].terms.end() || it->first != column) continue;
      subtract(rows_[user], it->second, row);
      std::erase_if(rows_[user].terms, [&](const auto& t) {
        return t.first == column || std::abs(t.second) <= kNegligible;
      });
      std::erase_if(rows_[user].history, [&](const auto& h) {
        return std::abs(h.second) <= kNegligible * given_[h.first].history[0].second;
      });
      note_use(user, row.terms);
    }
    used_by_[column].clear();
    pivot_row_[column] = index;
    rows_.push_back(std::move(row));
    note_use(index, rows_.back().terms);
  }

  const std::vector<int>& pivot_row() const { return pivot_row_; }
  const std::vector<Equation>& rows() const { return rows_; }
  // Equations whose left-hand side is implied by the others.
  const std::vector<Equation>& redundant() const { return redundant_; }

 private:
  static void scale(Equation& row, double s) {
    for (auto& t : row.terms) t.second *= s;
    for (auto& t : row.history) t.second *= s;
  }
  static void subtract(Equation& row, double s, const Equation& other) {
    add_scaled(row.terms, -s, other.terms);
    add_scaled(row.history, -s, other.history);
  }
  void note_use(int user, const Terms& terms) {
    for (const auto& t : terms)
      if (pivot_row_[t.first] < 0) used_by_[t.first].push_back(user);
  }
  std::vector<int> pivot_row_;
  // Pivot equations that contain a column; may list former ones.
  std::vector<std::vector<int>> used_by_;
  std::vector<Equation> rows_, redundant_;
  const std::vector<Equation>& given_;
  double dependent_;  // relative to the largest coefficient: smaller is no pivot
};

// Scalar equations of a constraint set with n columns, or 3n if it is coupled. Each equation is
// divided by its largest coefficient; this scaling is stored in `history`.
std::vector<Equation> equations_of(const ConstraintSet& set) {
  const int n = set.dof_count();
  std::vector<Equation> all;
  std::map<int, double> terms;
  const auto add = [&](int name) {
    poll_every<2048>(isize(all));
    Equation e;
    e.terms.assign(terms.begin(), terms.end());
    terms.clear();
    e.name = name;
    e.source = isize(all);
    double largest = 0;
    for (const auto& t : e.terms) largest = std::max(largest, std::abs(t.second));
    if (largest > 0)
      for (auto& t : e.terms) t.second /= largest;
    e.history = {{e.source, largest > 0 ? 1 / largest : 1.0}};
    all.push_back(std::move(e));
  };
  const int copies = set.coupled() ? 3 : 1;
  for (const auto& row : set.constraints())
    for (int c = 0; c < copies; ++c) {
      for (const auto& e : row.entries) terms[c * n + e.dof] += e.coefficient;
      add(row.name);
    }
  for (const auto& row : set.coupled_constraints()) {
    for (const auto& e : row.entries)
      for (int c = 0; c < 3; ++c)
        if (e.coefficient[c] != 0) terms[c * n + e.dof] += e.coefficient[c];
    add(row.name);
  }
  return all;
}

// Right-hand sides of those equations: three columns, or one if the set is coupled.
MatX right_hand_sides(const ConstraintSet& set) {
  const auto rows = static_cast<long>(set.constraints().size());
  const auto coupled_constraints = static_cast<long>(set.coupled_constraints().size());
  if (!set.coupled()) {
    MatX rhs(rows, 3);
    for (long r = 0; r < rows; ++r) rhs.row(r) = set.constraints()[r].value;
    return rhs;
  }
  MatX rhs(3 * rows + coupled_constraints, 1);
  for (long r = 0; r < rows; ++r) rhs.block<3, 1>(3 * r, 0) = set.constraints()[r].value;
  for (long r = 0; r < coupled_constraints; ++r)
    rhs(3 * rows + r, 0) = set.coupled_constraints()[r].value;
  return rhs;
}

// Names of the constraints that take part in a redundant equation, and its scaling.
struct Contradiction {
  std::vector<std::string> names;
  double own_weight = 1;  // converts to the units of the original equation
};

Contradiction contradiction(const Equation& row, const std::vector<std::string>& names,
                            const std::vector<Equation>& given) {
  Contradiction c;
  for (const auto& [index, weight] : row.history) {
    if (index == row.source) c.own_weight = std::abs(weight);
    const std::string& name = names[given[index].name];
    if (std::abs(weight) > kPart * given[index].history[0].second &&
        std::find(c.names.begin(), c.names.end(), name) == c.names.end())
      c.names.push_back(name);
  }
  return c;
}

}  // namespace

AffineReduction::AffineReduction(const ConstraintSet& constraints, RhsMode values, double dependent)
    : coupled_(constraints.coupled()), dof_count_(constraints.dof_count()) {
  const int columns = coupled_ ? 3 * dof_count_ : dof_count_;
  const std::vector<Equation> given = equations_of(constraints);
  // Short equations first: the dofs that they fix disappear from the longer ones.
  std::vector<int> order(given.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return given[a].terms.size() < given[b].terms.size(); });
  Elimination elimination(columns, given, dependent);
  update_progress("constraints", 0);
  for (size_t i = 0; i < order.size(); ++i) {
    if (i % kPollEquations == 0)
      update_progress("constraints", static_cast<double>(i) / static_cast<double>(order.size()));
    elimination.add(given[order[i]]);
  }
  update_progress("constraints", 1);

  const auto& pivot_row = elimination.pivot_row();
  std::vector<int> free_of(columns, -1);
  int free = 0;
  for (int c = 0; c < columns; ++c)
    if (pivot_row[c] < 0) {
      free_of[c] = free++;
      free_dofs_.push_back(c);
    }
  std::vector<Triplet> entries, weights;
  for (int c = 0; c < columns; ++c) {
    poll_every<8192>(c);
    if (pivot_row[c] < 0) {
      entries.emplace_back(c, free_of[c], 1.0);
      continue;
    }
    const Equation& row = elimination.rows()[pivot_row[c]];
    for (const auto& [index, weight] : row.history) weights.emplace_back(c, index, weight);
    for (const auto& [column, coefficient] : row.terms)
      if (column != c) {
        entries.emplace_back(c, free_of[column], -coefficient);
        selection_ = false;
      }
  }
  throw_if_cancelled();
  D_.resize(columns, free);
  D_.setFromTriplets(entries.begin(), entries.end());
  throw_if_cancelled();
  rhs_to_particular_.resize(columns, static_cast<long>(given.size()));
  rhs_to_particular_.setFromTriplets(weights.begin(), weights.end());
  for (const Equation& row : elimination.redundant()) {
    auto [names, own_weight] = contradiction(row, constraints.names(), given);
    redundant_.push_back({row.source, row.history, std::move(names), own_weight});
  }
  d0_ = MatX::Zero(columns, coupled_ ? 1 : 3);
  if (values == RhsMode::Given) set_rhs(right_hand_sides(constraints));
}

std::vector<int> AffineReduction::redundant() const {
  std::vector<int> rows;
  for (const RedundantConstraint& row : redundant_) rows.push_back(row.row);
  std::sort(rows.begin(), rows.end());
  return rows;
}

void AffineReduction::set_values(const ConstraintSet& same_rows) {
  if (same_rows.coupled() != coupled_ || same_rows.dof_count() != dof_count_)
    throw InputError("found the values of other constraints, expected those of the reduction");
  set_rhs(right_hand_sides(same_rows));
}

void AffineReduction::set_rhs(const MatX& rhs) {
  check(rhs);
  d0_.noalias() = rhs_to_particular_ * rhs;
}

void AffineReduction::check(const MatX& rhs) const {
  if (rhs.rows() != rhs_to_particular_.cols())
    throw InputError("found " + std::to_string(rhs.rows()) + " right-hand sides, expected " +
                     std::to_string(rhs_to_particular_.cols()));
  std::vector<ConflictError::Conflict> conflicts;
  const double largest = rhs.size() > 0 ? rhs.cwiseAbs().maxCoeff() : 0;
  for (const RedundantConstraint& row : redundant_) {
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    double scale = 0;
    for (const auto& [index, weight] : row.weights)
      for (long c = 0; c < rhs.cols(); ++c) {
        sum[c] += weight * rhs(index, c);
        scale = std::max(scale, std::abs(weight * rhs(index, c)));
      }
    const double violation = sum.cwiseAbs().maxCoeff();
    if (violation <= std::max(kConflictTolerance * scale, kRhsNoise * largest * row.own_weight))
      continue;
    const double amount = violation / row.own_weight;
    const auto same = std::find_if(conflicts.begin(), conflicts.end(),
                                   [&](const auto& c) { return c.names == row.names; });
    if (same == conflicts.end())
      conflicts.push_back({row.names, amount});
    else
      same->amount = std::max(same->amount, amount);
  }
  if (!conflicts.empty()) throw ConflictError(std::move(conflicts));
}

std::vector<int> AffineReduction::ordering_of_free(const std::vector<int>& dof_order) const {
  std::vector<int> free_of(D_.rows(), -1), order;
  for (size_t f = 0; f < free_dofs_.size(); ++f) free_of[free_dofs_[f]] = static_cast<int>(f);
  for (const int dof : dof_order)
    for (int stacked = dof; stacked < D_.rows(); stacked += dof_count_)
      if (free_of[stacked] >= 0) order.push_back(free_of[stacked]);
  return order;
}

std::vector<int> AffineReduction::choose_ordering(const SparseMatrix& reduced,
                                                  const SparseMatrix& K,
                                                  const std::vector<int>& dof_order) const {
  constexpr double kMaxFillRatio = 1.2;
  const bool one_of_three = coupled_ && K.rows() == dof_count_;
  const double as_meshed =
      kMaxFillRatio * static_cast<double>(K.nonZeros()) * (one_of_three ? 3 : 1);
  return static_cast<double>(reduced.nonZeros()) <= as_meshed ? ordering_of_free(dof_order)
                                                              : std::vector<int>();
}

namespace {

// K x, for K of one coordinate or of all three stacked.
Points times(const SparseMatrix& K, const Points& x) {
  const auto symmetric = K.selfadjointView<Eigen::Lower>();
  if (K.cols() == x.rows()) return symmetric * x;
  const VecX y = symmetric * Eigen::Map<const VecX>(x.data(), x.size());
  return Eigen::Map<const Points>(y.data(), x.rows(), 3);
}

}  // namespace

MatX AffineReduction::reduce_load(const SparseMatrix& K, const Points& F) const {
  const Points fixed = Eigen::Map<const Points>(d0_.data(), dof_count_, 3);
  const Points rest = d0_.isZero(0) ? F : Points(F - times(K, fixed));
  if (!coupled_) return D_.transpose() * rest;
  return D_.transpose() * Eigen::Map<const VecX>(rest.data(), rest.size());
}

Points AffineReduction::expand(const MatX& y) const {
  const MatX x = D_ * y + d0_;
  return Eigen::Map<const Points>(x.data(), dof_count_, 3);
}

Points reaction_forces(const SparseMatrix& K, const Points& x, const Points& F) {
  return times(K, x) - F;
}

namespace {

// Constraint matrix of the stacked system [x; y; z]; uncoupled equations appear three times.
SparseMatrix stacked_rows(const std::vector<Equation>& equations, const ConstraintSet& set) {
  const int n = set.dof_count();
  const int copies = set.coupled() ? 1 : 3;
  std::vector<Triplet> entries;
  int row = 0;
  for (const auto& e : equations)
    for (int c = 0; c < copies; ++c, ++row)
      for (const auto& [column, coefficient] : e.terms)
        entries.emplace_back(row, c * n + column, coefficient);
  SparseMatrix C(row, 3 * n);
  C.setFromTriplets(entries.begin(), entries.end());
  return C;
}

}  // namespace

std::vector<NamedReaction> named_reactions(const ConstraintSet& set, const Points& reaction) {
  const std::vector<Equation> equations = equations_of(set);
  const SparseMatrix C = stacked_rows(equations, set);
  SparseMatrix normal = C * SparseMatrix(C.transpose());
  // Redundant constraints make this matrix singular. A shift far below the entries selects the
  // multipliers with the smallest norm.
  constexpr double shift = 1e-11;
  for (int i = 0; i < normal.rows(); ++i) normal.coeffRef(i, i) += shift;
  SparseCholesky cholesky;
  const SparseMatrix lower = normal.triangularView<Eigen::Lower>();
  if (!cholesky.factorize(lower)) throw NoSolutionError(cholesky.message());
  const VecX r = Eigen::Map<const VecX>(reaction.data(), reaction.size());
  VecX lambda = cholesky.solve(C * r);
  for (int i = 0; i < 3; ++i) lambda += cholesky.solve(C * (r - C.transpose() * lambda));

  std::vector<NamedReaction> result;
  for (const auto& name : set.names()) result.push_back({name, Points::Zero(set.dof_count(), 3)});
  const int copies = set.coupled() ? 1 : 3, n = set.dof_count();
  int row = 0;
  for (const auto& e : equations)
    for (int c = 0; c < copies; ++c, ++row)
      for (const auto& [column, coefficient] : e.terms) {
        const int stacked = c * n + column;
        result[e.name].forces(stacked % n, stacked / n) += lambda[row] * coefficient;
      }
  return result;
}

// Reduced matrix DᵀKD.

namespace {

using RowMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor, int>;

// Rows and columns of the free dofs.
SparseMatrix submatrix(const SparseMatrix& K, const std::vector<int>& free_dofs) {
  std::vector<int> free_of(K.rows(), -1);
  for (size_t f = 0; f < free_dofs.size(); ++f) free_of[free_dofs[f]] = static_cast<int>(f);
  const auto n = static_cast<long>(free_dofs.size());
  SparseMatrix part(n, n);
  part.reserve(K.nonZeros());
  for (long f = 0; f < n; ++f) {
    poll_every<8192>(f);
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

// Accumulates a sparse sum of multiples of matrix rows; only entries from a given column on are
// kept.
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

// Checks the memory for n columns while some of them are computed, because the number of entries is
// not known in advance. Counts the columns, the final matrix, and the pattern for the symbolic
// analysis, in bytes per entry.
void require_room(const Columns& made, long column, long n) {
  constexpr double as_column = 12, later = 12 + 8;
  const double entries = static_cast<double>(made.rows.size()) * static_cast<double>(n) /
                         static_cast<double>(made.sizes.size());
  const double left = 1 - static_cast<double>(column) / static_cast<double>(n);
  require_memory(
      entries * (left * as_column + later),
      "the matrix of " + format_number(entries) +
          " entries (long curves couple many unknowns; a larger edge_length reduces it)");
}

// Lower triangle of A + GᵀT + TᵀG, where A is a lower triangle too. Computed column by column, on
// all threads.
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
      poll_every<1024>(j);
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
    throw_if_cancelled();
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
    throw InputError("found a matrix of " + std::to_string(K.rows()) + " unknowns, expected " +
                     std::to_string(dof_count_) + ", the dofs per coordinate");
  if (selection_ && stacked == coupled_) return submatrix(K, free_dofs_);
  // With free dofs f and constrained dofs p = G f: DᵀKD = K_ff + GᵀT + TᵀG, T = K_pf + ½ K_pp G.
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
  // Free dofs keep their order, so K_ff can be written column by column.
  SparseMatrix K_ff(free, free);
  K_ff.reserve(K.nonZeros() * (coupled_ && !stacked ? 3 : 1));
  for (int b = 0; b < columns; ++b) {
    poll_every<4096>(b);
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

MatX AffineReduction::particular_solution(const MatX& rhs) const {
  return rhs_to_particular_ * rhs;
}

}  // namespace batten
