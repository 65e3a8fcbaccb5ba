#include "batten/core/sparse_cholesky.h"

#include <algorithm>

#include "batten/core/errors.h"

#if BATTEN_HAVE_CHOLMOD
#include <cholmod.h>
// Present when BLAS is OpenBLAS. One BLAS thread keeps the factor's bits independent of the
// machine.
extern "C" __attribute__((weak)) void openblas_set_num_threads(int);
extern "C" __attribute__((weak)) int openblas_get_num_threads(void);
// Present when CHOLMOD was built with OpenMP. It asks for four threads whatever the machine and the
// environment say, and on few cores their waiting costs as much as the work.
extern "C" __attribute__((weak)) void omp_set_max_active_levels(int);
extern "C" __attribute__((weak)) int omp_get_max_active_levels(void);
#else
#include <Eigen/SparseCholesky>
#endif

namespace batten {
namespace {

// A pivot this small against its diagonal entry is rounding: bending problems of 100,000 unknowns
// stay above 1e-10.
constexpr double singular_pivot = 1e-14;

void require_fit(const SparseMatrix& A, const std::vector<int>& order) {
  if (!order.empty() && static_cast<long>(order.size()) != A.rows())
    throw InputError("an order of " + std::to_string(order.size()) + " unknowns for " +
                     std::to_string(A.rows()));
  if (A.rows() != A.cols())
    throw InputError("Cholesky factor of a " + std::to_string(A.rows()) + " by " +
                     std::to_string(A.cols()) + " matrix: it must be square");
}

std::string not_positive(long unknown) {
  return "the matrix is not positive definite at unknown " + std::to_string(unknown) +
         ": some motion costs no energy (are enough points held, and beta > 0?)";
}

}  // namespace

#if BATTEN_HAVE_CHOLMOD

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

struct SparseCholesky::Data {
  // The solve of a const factor needs workspace; it is no part of the factor's value.
  mutable cholmod_common common;
  cholmod_factor* factor = nullptr;
  std::string message;

  Data() {
    cholmod_start(&common);
    common.print = 0;
    common.nmethods = 1;
    common.postorder = 1;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.final_ll = 1;
  }
  std::string failure(const char* stage) const {
    const char* why = common.status == CHOLMOD_OUT_OF_MEMORY ? "out of memory"
                      : common.status == CHOLMOD_TOO_LARGE   ? "the matrix is too large"
                                                             : "the order or the matrix is invalid";
    return std::string("the ") + stage + " factorization failed: " + why;
  }
  ~Data() {
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
};

void SparseCholesky::analyze(const SparseMatrix& A, const std::vector<int>& order) {
  require_fit(A, order);
  cholmod_free_factor(&data_->factor, &data_->common);
  if (A.rows() == 0) return;  // nothing is free: CHOLMOD has no such factor
  cholmod_sparse a = view(A);
  // Small factors are faster with fewer, fuller supernodes: a third at 3,000 unknowns, a tenth at
  // 100,000, where the zeros they store would cost more in every solve than they save.
  constexpr long small = 20000;
  constexpr size_t columns[2][3] = {{4, 16, 48}, {16, 32, 64}};  // the first: CHOLMOD's
  constexpr double zeros[2][3] = {{0.8, 0.1, 0.05}, {0.9, 0.2, 0.1}};
  const int merge = A.rows() < small ? 1 : 0;
  std::copy_n(columns[merge], 3, data_->common.nrelax);
  std::copy_n(zeros[merge], 3, data_->common.zrelax);
  auto* given = order.empty() ? nullptr : const_cast<int*>(order.data());
  data_->common.method[0].ordering = given ? CHOLMOD_GIVEN : CHOLMOD_AMD;
  data_->factor = cholmod_analyze_p(&a, given, nullptr, 0, &data_->common);
  if (!data_->factor) throw NoSolutionError(data_->failure("symbolic"));
}

bool SparseCholesky::factorize(const SparseMatrix& A) {
  if (!data_->factor) analyze(A);
  data_->message.clear();
  if (A.rows() == 0) return true;
  const OneThread guard;
  cholmod_sparse a = view(A);
  if (!cholmod_factorize(&a, data_->factor, &data_->common) || data_->common.status < 0) {
    data_->message = data_->failure("numeric");
    return false;
  }
  if (data_->factor->minor < data_->factor->n) {
    const auto* order = static_cast<const int*>(data_->factor->Perm);
    data_->message =
        not_positive(order ? order[data_->factor->minor] : static_cast<long>(data_->factor->minor));
    return false;
  }
  if (const auto [ratio, unknown] = smallest_pivot(*data_->factor, A); !(ratio > singular_pivot)) {
    data_->message = not_positive(unknown);
    return false;
  }
  return true;
}

MatX SparseCholesky::solve(const Eigen::Ref<const MatX>& b) const {
  if (b.rows() == 0) return b;
  const OneThread guard;
  MatX rhs = b;
  cholmod_dense view_b{};
  view_b.nrow = static_cast<size_t>(rhs.rows());
  view_b.ncol = static_cast<size_t>(rhs.cols());
  view_b.nzmax = static_cast<size_t>(rhs.size());
  view_b.d = static_cast<size_t>(rhs.rows());
  view_b.x = rhs.data();
  view_b.xtype = CHOLMOD_REAL;
  view_b.dtype = CHOLMOD_DOUBLE;
  cholmod_dense* x = cholmod_solve(CHOLMOD_A, data_->factor, &view_b, &data_->common);
  if (!x) throw NoSolutionError("the triangular solve failed");
  rhs = Eigen::Map<MatX>(static_cast<double*>(x->x), rhs.rows(), rhs.cols());
  cholmod_free_dense(&x, &data_->common);
  return rhs;
}

long SparseCholesky::factor_entries() const {
  return data_->factor ? static_cast<long>(data_->factor->xsize) : 0;
}

const char* SparseCholesky::backend() { return "CHOLMOD"; }

#else

struct SparseCholesky::Data {
  Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower, Eigen::AMDOrdering<int> > ldlt;
  bool analysed = false;
  std::string message;
};

void SparseCholesky::analyze(const SparseMatrix& A, const std::vector<int>& order) {
  require_fit(A, order);
  if (A.rows() > 0) data_->ldlt.analyzePattern(A);
  data_->analysed = true;
}

bool SparseCholesky::factorize(const SparseMatrix& A) {
  if (!data_->analysed) analyze(A);
  data_->message.clear();
  if (A.rows() == 0) return true;
  data_->ldlt.factorize(A);
  const auto& D = data_->ldlt.vectorD();
  const VecX diagonal = A.diagonal();
  for (Eigen::Index i = 0; i < D.size(); ++i)
    if (!(D[i] > singular_pivot * diagonal[data_->ldlt.permutationPinv().indices()[i]])) {
      data_->message = not_positive(data_->ldlt.permutationPinv().indices()[i]);
      return false;
    }
  return data_->ldlt.info() == Eigen::Success;
}

MatX SparseCholesky::solve(const Eigen::Ref<const MatX>& b) const {
  if (b.rows() == 0) return b;
  return data_->ldlt.solve(b);
}

long SparseCholesky::factor_entries() const {
  return data_->ldlt.matrixL().nestedExpression().nonZeros() + data_->ldlt.vectorD().size();
}

const char* SparseCholesky::backend() { return "Eigen"; }

#endif

SparseCholesky::SparseCholesky() : data_(std::make_unique<Data>()) {}
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

const std::string& SparseCholesky::message() const { return data_->message; }

}  // namespace batten
