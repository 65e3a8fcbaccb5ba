#include <cholmod.h>

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/core/memory.h"
#include "batten/core/solvers/supernodal_factor.h"
#include "batten/core/solvers/supernodal_factorization.h"

namespace batten {
namespace {

// First unknown whose pivot is negligible compared with its diagonal entry, or not a number; -1:
// none. The ratio does not depend on the scale of the unknowns. It is about 1e-16 if some motion
// costs no energy and the factorization succeeded only because of rounding.
long singular_unknown(const SupernodalPattern& L, const int* order, const double* values,
                      const SparseMatrix& A) {
  const VecX diagonal = A.diagonal();
  for (int s = 0; s < L.count; ++s) {
    const long rows = L.row_starts[s + 1] - L.row_starts[s];
    for (long c = L.columns[s]; c < L.columns[s + 1]; ++c) {
      const double pivot = values[L.value_starts[s] + (c - L.columns[s]) * (rows + 1)];
      if (!(pivot * pivot > kSingularPivot * diagonal[order[c]])) return order[c];
    }
  }
  return -1;
}

cholmod_sparse view(const SparseMatrix& A) {
  cholmod_sparse v{};
  v.nrow = static_cast<size_t>(A.rows());
  v.ncol = static_cast<size_t>(A.cols());
  v.nzmax = static_cast<size_t>(A.nonZeros());
  v.p = const_cast<int*>(A.outerIndexPtr());
  v.nz = const_cast<int*>(A.innerNonZeroPtr());
  static int no_index = 0;  // CHOLMOD rejects null pointers even if there are no entries
  static double no_value = 0;
  v.i = v.nzmax > 0 ? const_cast<int*>(A.innerIndexPtr()) : &no_index;
  v.x = v.nzmax > 0 ? const_cast<double*>(A.valuePtr()) : &no_value;
  v.stype = -1;
  v.itype = CHOLMOD_INT;
  v.xtype = CHOLMOD_REAL;
  v.dtype = CHOLMOD_DOUBLE;
  v.sorted = 1;
  v.packed = A.isCompressed();
  return v;
}

// CHOLMOD computes the pattern, SupernodalFactorization the values.
class CholmodFactor final : public SupernodalFactor {
 public:
  CholmodFactor() {
    cholmod_start(&common_);
    common_.print = 0;
    common_.postorder = 1;
    common_.supernodal = CHOLMOD_SUPERNODAL;
  }
  ~CholmodFactor() override {
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }
  CholmodFactor(const CholmodFactor&) = delete;
  CholmodFactor& operator=(const CholmodFactor&) = delete;

  void analyze(const SparseMatrix& A, const std::vector<int>& order,
               FactorReuse factor_reuse) override;
  std::string factorize(const SparseMatrix& A) override;
  SupernodalPattern pattern() const override;
  const int* order() const override { return static_cast<const int*>(factor_->Perm); }
  double* values() override { return numbers_.values(); }

 private:
  std::string failure() const {
    const char* why = common_.status == CHOLMOD_OUT_OF_MEMORY ? "out of memory"
                      : common_.status == CHOLMOD_TOO_LARGE
                          ? "the matrix is too large"
                          : "the ordering or the matrix is invalid";
    return std::string("the symbolic factorization failed: ") + why;
  }

  cholmod_common common_;
  cholmod_factor* factor_ = nullptr;  // symbolic only
  SupernodalFactorization numbers_;
};

void CholmodFactor::analyze(const SparseMatrix& A, const std::vector<int>& order,
                            FactorReuse factor_reuse) {
  numbers_ = {};
  cholmod_free_factor(&factor_, &common_);
  cholmod_sparse a = view(A);
  // Small factors are faster with fewer, fuller supernodes: by a third at 3,000 unknowns, by a
  // tenth at 100,000. At 100,000, however, the zeros that they store cost more in every solve than
  // they save.
  constexpr long small = 20000;
  constexpr size_t columns[2][3] = {{4, 16, 48}, {16, 32, 64}};  // first row: CHOLMOD's defaults
  constexpr double zeros[2][3] = {{0.8, 0.1, 0.05}, {0.9, 0.2, 0.1}};
  const int merge = A.rows() < small ? 1 : 0;
  std::copy_n(columns[merge], 3, common_.nrelax);
  std::copy_n(zeros[merge], 3, common_.zrelax);
  auto* given = order.empty() ? nullptr : const_cast<int*>(order.data());
  common_.nmethods = 1;
  common_.method[0].ordering = given ? CHOLMOD_GIVEN : CHOLMOD_AMD;
  constexpr long kMinUnknownsForMetis = 10000;
  if (!given && factor_reuse == FactorReuse::many && A.rows() >= kMinUnknownsForMetis) {
    // CHOLMOD tries both and keeps the factor with fewer entries.
    common_.nmethods = 2;
    common_.method[1].ordering = CHOLMOD_METIS;
  }
  factor_ = cholmod_analyze_p(&a, given, nullptr, 0, &common_);
  if (!factor_) throw NoSolutionError(failure());
  // Check memory before the numeric factorization: otherwise the system might kill the program.
  constexpr size_t large = size_t{1} << 24;
  if (factor_->xsize > large)
    require_memory(8.0 * static_cast<double>(factor_->xsize),
                   "the Cholesky factor of " + std::to_string(A.rows()) + " unknowns");
  numbers_ = SupernodalFactorization(pattern(), this->order(), A);
}

std::string CholmodFactor::factorize(const SparseMatrix& A) {
  const int column = numbers_.factorize(A);
  const long unknown =
      column < 0 ? singular_unknown(pattern(), order(), values(), A) : order()[column];
  return unknown < 0 ? "" : not_positive_definite(unknown);
}

SupernodalPattern CholmodFactor::pattern() const {
  const cholmod_factor& L = *factor_;
  return {static_cast<int>(L.nsuper), static_cast<const int*>(L.super),
          static_cast<const int*>(L.pi), static_cast<const int*>(L.s),
          static_cast<const int*>(L.px)};
}

}  // namespace

std::unique_ptr<SupernodalFactor> make_cholmod_factor() {
  return std::make_unique<CholmodFactor>();
}

std::vector<int> cholmod_elimination_order(const SparseMatrix& graph, FactorReuse factor_reuse) {
  cholmod_common common;
  cholmod_start(&common);
  common.print = 0;
  common.supernodal = CHOLMOD_SIMPLICIAL;  // the cheapest analysis: only the order is used
  constexpr long kMinNodesForDissection = 1000;
  const bool dissect = factor_reuse == FactorReuse::many && graph.rows() >= kMinNodesForDissection;
  common.nmethods = 1;
  common.method[0].ordering = dissect ? CHOLMOD_NESDIS : CHOLMOD_AMD;
  cholmod_sparse a = view(graph);
  cholmod_factor* factor = cholmod_analyze(&a, &common);
  if (!factor && dissect) {  // CHOLMOD was built without METIS
    common.method[0].ordering = CHOLMOD_AMD;
    factor = cholmod_analyze(&a, &common);
  }
  std::vector<int> order;
  if (factor) {
    const auto* first = static_cast<const int*>(factor->Perm);
    order.assign(first, first + graph.rows());
  }
  cholmod_free_factor(&factor, &common);
  cholmod_finish(&common);
  if (order.empty()) throw NoSolutionError("out of memory while ordering the unknowns");
  return order;
}

}  // namespace batten
