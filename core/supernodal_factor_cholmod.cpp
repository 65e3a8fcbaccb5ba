#include <cholmod.h>

#include <algorithm>
#include <mutex>

#include "batten/core/elimination_order.h"
#include "batten/core/errors.h"
#include "batten/core/supernodal_factor.h"

// Present when BLAS is OpenBLAS. One BLAS thread keeps the factor's bits independent of the
// machine.
extern "C" __attribute__((weak)) void openblas_set_num_threads(int);
extern "C" __attribute__((weak)) int openblas_get_num_threads(void);
// Present when CHOLMOD was built with OpenMP. It asks for four threads whatever the machine and the
// environment say, and on few cores their waiting costs as much as the work.
extern "C" __attribute__((weak)) void omp_set_max_active_levels(int);
extern "C" __attribute__((weak)) int omp_get_max_active_levels(void);

namespace batten {
namespace {

// Held by every factorization under way. BLAS's setting belongs to the whole process: the first
// sets it, the last sets it back. OpenMP's may belong to the thread: everyone sets it.
class OneThread {
 public:
  OneThread() {
    const std::lock_guard lock(state().mutex);
    if (state().users++ == 0) {
      state().blas = openblas_get_num_threads ? openblas_get_num_threads() : 0;
      state().omp = omp_get_max_active_levels ? omp_get_max_active_levels() : 0;
      if (state().blas > 1) openblas_set_num_threads(1);
    }
    if (state().omp > 0) omp_set_max_active_levels(0);
  }
  ~OneThread() {
    const std::lock_guard lock(state().mutex);
    if (--state().users == 0 && state().blas > 1) openblas_set_num_threads(state().blas);
    if (state().omp > 0) omp_set_max_active_levels(state().omp);
  }
  OneThread(const OneThread&) = delete;

 private:
  struct State {
    std::mutex mutex;
    int users = 0, blas = 0, omp = 0;
  };
  static State& state() {
    static State& state = *new State;
    return state;
  }
};

// The first unknown whose pivot is nothing beside its diagonal entry, or not a number; -1: none.
// The ratio is independent of the scale of the unknowns, and about 1e-16 when a motion costs
// nothing but rounding let the factor through.
long singular_unknown(const cholmod_factor& L, const SparseMatrix& A) {
  const auto* order = static_cast<const int*>(L.Perm);
  const auto* super = static_cast<const int*>(L.super);
  const auto* pi = static_cast<const int*>(L.pi);
  const auto* px = static_cast<const int*>(L.px);
  const auto* x = static_cast<const double*>(L.x);
  const VecX diagonal = A.diagonal();
  for (size_t s = 0; s < L.nsuper; ++s) {
    const long rows = pi[s + 1] - pi[s];
    for (long c = super[s]; c < super[s + 1]; ++c) {
      const double pivot = x[px[s] + (c - super[s]) * (rows + 1)];
      if (!(pivot * pivot > singular_pivot * diagonal[order[c]])) return order[c];
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
  static int no_index = 0;  // CHOLMOD takes no null, not even for no entries
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
  cholmod_factor* factor = nullptr;

  Data() {
    cholmod_start(&common);
    common.print = 0;
    common.postorder = 1;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.final_ll = 1;
  }
  ~Data() {
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  std::string failure(const char* stage) const {
    const char* why = common.status == CHOLMOD_OUT_OF_MEMORY ? "out of memory"
                      : common.status == CHOLMOD_TOO_LARGE   ? "the matrix is too large"
                                                             : "the order or the matrix is invalid";
    return std::string("the ") + stage + " factorization failed: " + why;
  }
};

SupernodalFactor::SupernodalFactor() : data_(std::make_unique<Data>()) {}
SupernodalFactor::~SupernodalFactor() = default;

void SupernodalFactor::analyze(const SparseMatrix& A, const std::vector<int>& order,
                               Expected expected) {
  cholmod_common& common = data_->common;
  cholmod_free_factor(&data_->factor, &common);
  cholmod_sparse a = view(A);
  // Small factors are faster with fewer, fuller supernodes: a third at 3,000 unknowns, a tenth at
  // 100,000, where the zeros they store would cost more in every solve than they save.
  constexpr long small = 20000;
  constexpr size_t columns[2][3] = {{4, 16, 48}, {16, 32, 64}};  // the first: CHOLMOD's
  constexpr double zeros[2][3] = {{0.8, 0.1, 0.05}, {0.9, 0.2, 0.1}};
  const int merge = A.rows() < small ? 1 : 0;
  std::copy_n(columns[merge], 3, common.nrelax);
  std::copy_n(zeros[merge], 3, common.zrelax);
  auto* given = order.empty() ? nullptr : const_cast<int*>(order.data());
  common.nmethods = 1;
  common.method[0].ordering = given ? CHOLMOD_GIVEN : CHOLMOD_AMD;
  constexpr long worth_metis = 10000;
  if (!given && expected == Expected::many_factors && A.rows() >= worth_metis) {
    // Both are tried and the factor with fewer entries is kept.
    common.nmethods = 2;
    common.method[1].ordering = CHOLMOD_METIS;
  }
  data_->factor = cholmod_analyze_p(&a, given, nullptr, 0, &common);
  if (!data_->factor) throw NoSolutionError(data_->failure("symbolic"));
}

std::string SupernodalFactor::factorize(const SparseMatrix& A) {
  const OneThread guard;
  cholmod_factor& L = *data_->factor;
  cholmod_sparse a = view(A);
  if (!cholmod_factorize(&a, &L, &data_->common) || data_->common.status < 0)
    return data_->failure("numeric");
  if (L.minor < L.n) {
    const auto* order = static_cast<const int*>(L.Perm);
    return not_positive_definite(order ? order[L.minor] : static_cast<long>(L.minor));
  }
  const long unknown = singular_unknown(L, A);
  return unknown < 0 ? "" : not_positive_definite(unknown);
}

SupernodalPattern SupernodalFactor::pattern() const {
  const cholmod_factor& L = *data_->factor;
  return {static_cast<int>(L.nsuper), static_cast<const int*>(L.super),
          static_cast<const int*>(L.pi), static_cast<const int*>(L.s),
          static_cast<const int*>(L.px)};
}

const int* SupernodalFactor::order() const { return static_cast<const int*>(data_->factor->Perm); }

double* SupernodalFactor::values() { return static_cast<double*>(data_->factor->x); }

const char* SupernodalFactor::backend() { return "CHOLMOD"; }

std::vector<int> elimination_order(const SparseMatrix& graph, Expected expected) {
  if (graph.rows() == 0) return {};
  cholmod_common common;
  cholmod_start(&common);
  common.print = 0;
  common.supernodal = CHOLMOD_SIMPLICIAL;  // the cheapest analysis: only the order is of use
  constexpr long worth_dissection = 1000;
  const bool dissect = expected == Expected::many_factors && graph.rows() >= worth_dissection;
  common.nmethods = 1;
  common.method[0].ordering = dissect ? CHOLMOD_NESDIS : CHOLMOD_AMD;
  cholmod_sparse a = view(graph);
  cholmod_factor* factor = cholmod_analyze(&a, &common);
  if (!factor && dissect) {  // a CHOLMOD without METIS
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
  if (order.empty()) throw NoSolutionError("an order of the unknowns: out of memory");
  return order;
}

}  // namespace batten
