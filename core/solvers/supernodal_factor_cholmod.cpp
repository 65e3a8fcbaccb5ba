#include <cholmod.h>

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/core/memory.h"
#include "batten/core/solvers/supernodal_factor.h"
#include "batten/core/solvers/supernodal_factorization.h"
#include "batten/core/solvers/symbolic_analysis.h"

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

}  // namespace

struct SupernodalFactor::Data {
  cholmod_common common;
  cholmod_factor* factor = nullptr;  // symbolic only
  SupernodalFactorization numbers;

  Data() {
    cholmod_start(&common);
    common.print = 0;
    common.postorder = 1;
    common.supernodal = CHOLMOD_SUPERNODAL;
  }
  ~Data() {
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  std::string failure() const {
    const char* why = common.status == CHOLMOD_OUT_OF_MEMORY ? "out of memory"
                      : common.status == CHOLMOD_TOO_LARGE
                          ? "the matrix is too large"
                          : "the ordering or the matrix is invalid";
    return std::string("the symbolic factorization failed: ") + why;
  }
};

SupernodalFactor::SupernodalFactor() : data_(std::make_unique<Data>()) {}
SupernodalFactor::~SupernodalFactor() = default;

void SupernodalFactor::analyze(const SparseMatrix& A, const std::vector<int>& order,
                               FactorReuse factor_reuse) {
  cholmod_common& common = data_->common;
  data_->numbers = {};
  cholmod_free_factor(&data_->factor, &common);
  cholmod_sparse a = view(A);
  // Small factors are faster with fewer, fuller supernodes: by a third at 3,000 unknowns, by a
  // tenth at 100,000. At 100,000, however, the zeros that they store cost more in every solve than
  // they save.
  constexpr long small = 20000;
  constexpr size_t columns[2][3] = {{4, 16, 48}, {16, 32, 64}};  // first row: CHOLMOD's defaults
  constexpr double zeros[2][3] = {{0.8, 0.1, 0.05}, {0.9, 0.2, 0.1}};
  const int merge = A.rows() < small ? 1 : 0;
  std::copy_n(columns[merge], 3, common.nrelax);
  std::copy_n(zeros[merge], 3, common.zrelax);
  auto* given = order.empty() ? nullptr : const_cast<int*>(order.data());
  common.nmethods = 1;
  common.method[0].ordering = given ? CHOLMOD_GIVEN : CHOLMOD_AMD;
  constexpr long kMinUnknownsForMetis = 10000;
  if (!given && factor_reuse == FactorReuse::many && A.rows() >= kMinUnknownsForMetis) {
    // CHOLMOD tries both and keeps the factor with fewer entries.
    common.nmethods = 2;
    common.method[1].ordering = CHOLMOD_METIS;
  }
  data_->factor = cholmod_analyze_p(&a, given, nullptr, 0, &common);
  if (!data_->factor) throw NoSolutionError(data_->failure());
  // Check memory before the numeric factorization: otherwise the system might kill the program.
  constexpr size_t large = size_t{1} << 24;
  if (data_->factor->xsize > large)
    require_memory(8.0 * static_cast<double>(data_->factor->xsize),
                   "the Cholesky factor of " + std::to_string(A.rows()) + " unknowns");
  data_->numbers = SupernodalFactorization(pattern(), this->order(), A);
}

std::string SupernodalFactor::factorize(const SparseMatrix& A) {
  const int column = data_->numbers.factorize(A);
  const long unknown =
      column < 0 ? singular_unknown(pattern(), order(), values(), A) : order()[column];
  return unknown < 0 ? "" : not_positive_definite(unknown);
}

SupernodalPattern SupernodalFactor::pattern() const {
  const cholmod_factor& L = *data_->factor;
  return {static_cast<int>(L.nsuper), static_cast<const int*>(L.super),
          static_cast<const int*>(L.pi), static_cast<const int*>(L.s),
          static_cast<const int*>(L.px)};
}

const int* SupernodalFactor::order() const { return static_cast<const int*>(data_->factor->Perm); }

double* SupernodalFactor::values() { return data_->numbers.values(); }

const char* SupernodalFactor::backend() { return "CHOLMOD"; }

std::vector<int> elimination_order(const SparseMatrix& graph, FactorReuse factor_reuse) {
  if (graph.rows() == 0) return {};
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
