#include <cholmod.h>

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/core/huge_pages.h"
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

class OneThread {
 public:
  OneThread()
      : blas_(openblas_get_num_threads ? openblas_get_num_threads() : 0),
        omp_(omp_get_max_active_levels ? omp_get_max_active_levels() : 0) {
    if (blas_ > 1) openblas_set_num_threads(1);
    if (omp_ > 0) omp_set_max_active_levels(0);
  }
  ~OneThread() {
    if (blas_ > 1) openblas_set_num_threads(blas_);
    if (omp_ > 0) omp_set_max_active_levels(omp_);
  }

 private:
  int blas_, omp_;
};

// Smallest ratio of a pivot to its diagonal entry, and where: independent of the scale of the
// unknowns, about 1e-16 when a motion costs nothing but rounding let the factor through.
std::pair<double, long> smallest_pivot(const cholmod_factor& L, const SparseMatrix& A) {
  const auto* order = static_cast<const int*>(L.Perm);
  const auto* super = static_cast<const int*>(L.super);
  const auto* pi = static_cast<const int*>(L.pi);
  const auto* px = static_cast<const int*>(L.px);
  const auto* x = static_cast<const double*>(L.x);
  const VecX diagonal = A.diagonal();
  std::pair<double, long> smallest{1.0, 0};
  for (size_t s = 0; s < L.nsuper; ++s) {
    const long rows = pi[s + 1] - pi[s];
    for (long c = super[s]; c < super[s + 1]; ++c) {
      const double pivot = x[px[s] + (c - super[s]) * (rows + 1)];
      const double ratio = pivot * pivot / diagonal[order[c]];
      if (!(ratio >= smallest.first)) smallest = {ratio, order[c]};
    }
  }
  return smallest;
}

cholmod_sparse view(const SparseMatrix& A) {
  cholmod_sparse v{};
  v.nrow = static_cast<size_t>(A.rows());
  v.ncol = static_cast<size_t>(A.cols());
  v.nzmax = static_cast<size_t>(A.nonZeros());
  v.p = const_cast<int*>(A.outerIndexPtr());
  v.i = const_cast<int*>(A.innerIndexPtr());
  v.x = const_cast<double*>(A.valuePtr());
  v.stype = -1;
  v.itype = CHOLMOD_INT;
  v.xtype = CHOLMOD_REAL;
  v.dtype = CHOLMOD_DOUBLE;
  v.sorted = 1;
  v.packed = 1;
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

bool SupernodalFactor::analyzed() const { return data_->factor != nullptr; }

std::string SupernodalFactor::factorize(const SparseMatrix& A) {
  const OneThread guard;
  cholmod_factor& L = *data_->factor;
  if (L.xtype == CHOLMOD_PATTERN) {
    constexpr int yes = 1;
    if (cholmod_change_factor(CHOLMOD_REAL, yes, yes, yes, yes, &L, &data_->common))
      advise_huge_pages(L.x, L.xsize * sizeof(double));
  }
  cholmod_sparse a = view(A);
  if (!cholmod_factorize(&a, &L, &data_->common) || data_->common.status < 0)
    return data_->failure("numeric");
  if (L.minor < L.n) {
    const auto* order = static_cast<const int*>(L.Perm);
    return not_positive_definite(order ? order[L.minor] : static_cast<long>(L.minor));
  }
  const auto [ratio, unknown] = smallest_pivot(L, A);
  return ratio > singular_pivot ? "" : not_positive_definite(unknown);
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

}  // namespace batten
