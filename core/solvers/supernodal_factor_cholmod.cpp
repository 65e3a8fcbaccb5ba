// SPDX-License-Identifier: MPL-2.0
#include <cholmod.h>

#include <algorithm>
#include <memory>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
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
    poll_every<4096>(s);
    const long rows = L.row_starts[s + 1] - L.row_starts[s];
    for (long c = L.columns[s]; c < L.columns[s + 1]; ++c) {
      const double pivot = values[L.value_starts[s] + (c - L.columns[s]) * (rows + 1)];
      if (!(pivot * pivot > kSingularPivot * diagonal[order[c]])) return order[c];
    }
  }
  return -1;
}

// The sparsity pattern of a symmetric matrix, of which the lower triangle is stored.
struct Pattern {
  std::vector<int> starts, sizes, rows;  // sizes: only if the storage is not compressed

  Pattern() = default;
  explicit Pattern(const SparseMatrix& A) {
    copy(A.outerIndexPtr(), A.cols() + 1, starts);
    if (!A.isCompressed()) copy(A.innerNonZeroPtr(), A.cols(), sizes);
    copy(A.innerIndexPtr(), A.outerIndexPtr()[A.cols()], rows);
  }
  cholmod_sparse view() {
    cholmod_sparse v{};
    v.nrow = v.ncol = starts.size() - 1;
    v.nzmax = rows.size();
    v.p = starts.data();
    v.nz = sizes.empty() ? nullptr : sizes.data();
    static int no_index = 0;  // CHOLMOD rejects null pointers even if there are no entries
    v.i = v.nzmax > 0 ? rows.data() : &no_index;
    v.stype = -1;
    v.itype = CHOLMOD_INT;
    v.xtype = CHOLMOD_PATTERN;
    v.dtype = CHOLMOD_DOUBLE;
    v.sorted = 1;
    v.packed = sizes.empty();
    return v;
  }

 private:
  static void copy(const int* from, long count, std::vector<int>& to) {
    constexpr long block = 1 << 20;
    to.reserve(count);
    for (long i = 0; i < count; i += block) {
      throw_if_cancelled();
      to.insert(to.end(), from + i, from + std::min(i + block, count));
    }
  }
};

// Analyses with fewer rows take less than 5 ms and are not worth a thread.
constexpr long kMinRowsForThread = 4000;

// A symbolic analysis by CHOLMOD, which cannot poll. It owns all of its data, because it continues
// after a cancellation.
struct CholmodAnalysis {
  Pattern pattern;
  std::vector<int> given;  // elimination order; empty: automatic
  cholmod_common common;
  cholmod_factor* factor = nullptr;  // symbolic only

  CholmodAnalysis(const SparseMatrix& A, std::vector<int> order)
      : pattern(A), given(std::move(order)) {
    cholmod_start(&common);
    common.print = 0;
  }
  ~CholmodAnalysis() {
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  CholmodAnalysis(const CholmodAnalysis&) = delete;
  CholmodAnalysis& operator=(const CholmodAnalysis&) = delete;

  void run() {
    cholmod_sparse a = pattern.view();
    factor = cholmod_analyze_p(&a, given.empty() ? nullptr : given.data(), nullptr, 0, &common);
  }
};

void run(const std::shared_ptr<CholmodAnalysis>& analysis) {
  if (isize(analysis->pattern.starts) < kMinRowsForThread)
    analysis->run();
  else
    call_without_polls([analysis] { analysis->run(); });
}

// CHOLMOD computes the pattern, SupernodalFactorization the values.
class CholmodFactor final : public SupernodalFactor {
 public:
  void analyze(const SparseMatrix& A, const std::vector<int>& order,
               FactorReuse factor_reuse) override;
  std::string factorize(const SparseMatrix& A) override;
  SupernodalPattern pattern() const override;
  const int* order() const override {
    return static_cast<const int*>(analysis_->factor->Perm);
  }
  double* values() override { return numbers_.values(); }

 private:
  std::shared_ptr<CholmodAnalysis> analysis_;
  SupernodalFactorization numbers_;
};

std::string failure_of(const cholmod_common& common) {
  const char* why = common.status == CHOLMOD_OUT_OF_MEMORY ? "out of memory"
                    : common.status == CHOLMOD_TOO_LARGE   ? "the matrix is too large"
                                                           : "the ordering or the matrix is invalid";
  return std::string("the symbolic factorization failed: ") + why;
}

void CholmodFactor::analyze(const SparseMatrix& A, const std::vector<int>& order,
                            FactorReuse factor_reuse) {
  numbers_ = {};
  analysis_.reset();
  const auto analysis = std::make_shared<CholmodAnalysis>(A, order);
  cholmod_common& common = analysis->common;
  common.postorder = 1;
  common.supernodal = CHOLMOD_SUPERNODAL;
  // Small factors are faster with fewer, fuller supernodes: by a third at 3,000 unknowns, by a
  // tenth at 100,000. At 100,000, however, the zeros that they store cost more in every solve than
  // they save.
  constexpr long small = 20000;
  constexpr size_t columns[2][3] = {{4, 16, 48}, {16, 32, 64}};  // first row: CHOLMOD's defaults
  constexpr double zeros[2][3] = {{0.8, 0.1, 0.05}, {0.9, 0.2, 0.1}};
  const int merge = A.rows() < small ? 1 : 0;
  std::copy_n(columns[merge], 3, common.nrelax);
  std::copy_n(zeros[merge], 3, common.zrelax);
  common.nmethods = 1;
  common.method[0].ordering = order.empty() ? CHOLMOD_AMD : CHOLMOD_GIVEN;
  constexpr long kMinUnknownsForMetis = 10000;
  if (order.empty() && factor_reuse == FactorReuse::many && A.rows() >= kMinUnknownsForMetis) {
    // CHOLMOD tries both and keeps the factor with fewer entries.
    common.nmethods = 2;
    common.method[1].ordering = CHOLMOD_METIS;
  }
  run(analysis);
  if (!analysis->factor) throw NoSolutionError(failure_of(common));
  analysis->pattern = {};  // only needed during the analysis
  // Check memory before the numeric factorization: otherwise the system might kill the program.
  constexpr size_t large = size_t{1} << 24;
  if (analysis->factor->xsize > large)
    require_memory(8.0 * static_cast<double>(analysis->factor->xsize),
                   "the Cholesky factor of " + std::to_string(A.rows()) + " unknowns");
  analysis_ = analysis;
  numbers_ = SupernodalFactorization(pattern(), this->order(), A);
}

std::string CholmodFactor::factorize(const SparseMatrix& A) {
  const int column = numbers_.factorize(A);
  const long unknown =
      column < 0 ? singular_unknown(pattern(), order(), values(), A) : order()[column];
  return unknown < 0 ? "" : not_positive_definite(unknown);
}

SupernodalPattern CholmodFactor::pattern() const {
  const cholmod_factor& L = *analysis_->factor;
  return {static_cast<int>(L.nsuper), static_cast<const int*>(L.super),
          static_cast<const int*>(L.pi), static_cast<const int*>(L.s),
          static_cast<const int*>(L.px)};
}

}  // namespace

std::unique_ptr<SupernodalFactor> make_cholmod_factor() {
  return std::make_unique<CholmodFactor>();
}

std::vector<int> cholmod_elimination_order(const SparseMatrix& graph, FactorReuse factor_reuse) {
  const auto analysis = std::make_shared<CholmodAnalysis>(graph, std::vector<int>());
  cholmod_common& common = analysis->common;
  common.supernodal = CHOLMOD_SIMPLICIAL;  // the cheapest analysis: only the order is used
  constexpr long kMinNodesForDissection = 1000;
  const bool dissect = factor_reuse == FactorReuse::many && graph.rows() >= kMinNodesForDissection;
  common.nmethods = 1;
  common.method[0].ordering = dissect ? CHOLMOD_NESDIS : CHOLMOD_AMD;
  run(analysis);
  if (!analysis->factor && dissect) {  // CHOLMOD was built without METIS
    common.method[0].ordering = CHOLMOD_AMD;
    run(analysis);
  }
  if (!analysis->factor) throw NoSolutionError("out of memory while ordering the unknowns");
  const auto* first = static_cast<const int*>(analysis->factor->Perm);
  return {first, first + graph.rows()};
}

}  // namespace batten
