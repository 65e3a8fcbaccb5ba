// SPDX-License-Identifier: MPL-2.0
// The triangular solves of a drag: Batten compared with CHOLMOD, Eigen and the memory bound.
// Three right-hand sides with twenty matrices. Bound: a solve reads every stored entry of the
// factor twice, 8 bytes each, limited by the memory bandwidth, which is that of the triad a = b + s
// c on one thread, measured along with every matrix.
#include <Eigen/SparseCholesky>

#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/tests/support/solver_matrices.h"
#include "bench.h"
#ifdef BATTEN_BENCH_CHOLMOD
#include "batten/tests/support/cholmod_solver.h"
#endif

namespace {

using namespace batten;
using namespace batten::bench;
using namespace batten_test;

double wall_seconds() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// Bytes per second of a = b + s c in arrays far larger than any cache: the best of several passes.
double triad_bandwidth() {
  constexpr size_t n = 8 << 20;
  static std::vector<double> a(n, 1), b(n, 2), c(n, 3);
  double best = 1e300;
  for (int pass = 0; pass < 7; ++pass)
    best = std::min(best, cpu_seconds_of([&] {
                      for (size_t i = 0; i < n; ++i) a[i] = b[i] + 0.5 * c[i];
                    }));
  return a[n / 2] == 3.5 ? 24.0 * n / best : 0;
}

struct Times {
  double analyze = 0, factor = 0, solve = 0;
};
struct Result {
  long n = 0, entries = 0;
  Times ours, eigen;
  std::optional<Times> cholmod;
  double on_all_cores = 0;
  double backward_error = 0;         // |Ax - b| / (|A| |x|)
  std::optional<double> difference;  // from CHOLMOD's solution with the same factor
  // `bandwidth`: the best of the whole run.
  double fraction(double bandwidth) const {
    return 16.0 * static_cast<double>(entries) / bandwidth / ours.solve;
  }
  std::optional<double> ratio() const {
    return cholmod ? std::optional(cholmod->solve / ours.solve) : std::nullopt;
  }
};

// Short work is repeated for the resolution of the clock.
double time_a_call(const std::function<void()>& work, int repeats) {
  return cpu_seconds_of([&] {
           for (int i = 0; i < repeats; ++i) work();
         }) /
         repeats;
}

double relative(const MatX& difference, const MatX& x) {
  return difference.cwiseAbs().maxCoeff() / x.cwiseAbs().maxCoeff();
}

Result measure(const BendingMatrix& problem, double& bandwidth) {
  const SparseMatrix& A = problem.K;
  Result r;
  r.n = A.rows();
  const MatX b = random_columns(r.n, 3);
  SparseCholesky ours;
  r.ours.analyze = cpu_seconds_of([&] { ours.analyze(A, problem.order); });
  // Twice: the first time includes page faults of fresh memory.
  for (int i = 0; i < 2; ++i) r.ours.factor = cpu_seconds_of([&] { ours.factorize(A); });
  r.entries = ours.factor_entries();
  const bool big = r.entries > 3000000;
  const int rounds = big ? 11 : 21, repeats = r.entries < 100000 ? 50 : 1;
  // One solve before the timing, so that a factor that fits in a cache is there for all sides.
  const auto warm = [&](const std::function<void()>& work) {
    work();
    return time_a_call(work, repeats);
  };

  MatX x = b;
  std::vector<double> our_times, their_times[2], both;
#ifdef BATTEN_BENCH_CHOLMOD
  std::optional<CholmodSolver> cholmod[2];
  const int variants = r.n < CholmodSolver::small ? 2 : 1;
  r.cholmod.emplace();
  for (int v = variants - 1; v >= 0; --v) {
    cholmod[v].emplace(A, problem.order, v == 1);
    r.cholmod->analyze = cpu_seconds_of([&] { cholmod[v]->analyze(); });
    for (int i = 0; i < 2; ++i)
      r.cholmod->factor = cpu_seconds_of([&] { cholmod[v]->factorize(); });
  }
#endif
  bandwidth = std::max(bandwidth, triad_bandwidth());
  for (int round = 0; round < rounds; ++round) {
    our_times.push_back(warm([&] { ours.solve_in_place(x); }));
    set_thread_count(0);
    ours.solve_in_place(x);
    const double start = wall_seconds();
    for (int i = 0; i < repeats; ++i) ours.solve_in_place(x);
    both.push_back((wall_seconds() - start) / repeats);
    set_thread_count(1);
    x = b;
#ifdef BATTEN_BENCH_CHOLMOD
    for (int v = 0; v < variants; ++v)
      their_times[v].push_back(warm([&] { cholmod[v]->solve(b); }));
#endif
  }
  bandwidth = std::max(bandwidth, triad_bandwidth());
  r.ours.solve = median(our_times);
  r.on_all_cores = median(both);
  ours.solve_in_place(x);
  r.backward_error = backward_error(A, x, b);
#ifdef BATTEN_BENCH_CHOLMOD
  r.cholmod->solve = median(their_times[0]);
  if (variants == 2) r.cholmod->solve = std::min(r.cholmod->solve, median(their_times[1]));
  const auto factor = make_supernodal_factor();
  factor->analyze(A, problem.order, FactorReuse::once);
  factor->factorize(A);
  cholmod[variants - 1]->set_factor_values(factor->values());
  cholmod[variants - 1]->solve(b);
  r.difference = relative(x - cholmod[variants - 1]->solution(), x);
#endif

  Eigen::SimplicialLDLT<SparseMatrix> eigen;
  r.eigen.analyze = cpu_seconds_of([&] { eigen.analyzePattern(A); });
  r.eigen.factor = cpu_seconds_of([&] { eigen.factorize(A); });
  MatX y;
  std::vector<double> eigen_times;
  for (int round = 0; round < (big ? 3 : 7); ++round)
    eigen_times.push_back(warm([&] { y = eigen.solve(b); }));
  r.eigen.solve = median(eigen_times);
  return r;
}

std::string milliseconds(double seconds) { return text("%.3g", 1e3 * seconds); }
std::string of_cholmod(const Result& r, double Times::*stage) {
  return r.cholmod ? milliseconds((*r.cholmod).*stage) : "none";
}

// Cost and fill of the orderings: AMD, METIS, and the mesh's nested dissection.
void compare_orders() {
  Table table;
  table.add({"ms", "ordering", "analyse", "factor", "solve", "entries (M)"});
  const auto row = [&](const std::string& name, const std::string& order, const SparseMatrix& A,
                       const std::function<void(SparseCholesky&)>& analyze) {
    SparseCholesky cholesky;
    const double analysis = cpu_seconds_of([&] { analyze(cholesky); });
    cholesky.factorize(A);
    std::vector<double> factor, solve;
    const MatX b = random_columns(A.rows(), 3);
    MatX x = b;
    for (int round = 0; round < 5; ++round) {
      factor.push_back(cpu_seconds_of([&] { cholesky.factorize(A); }));
      x = b;
      for (int i = 0; i < 3; ++i)
        solve.push_back(cpu_seconds_of([&] { cholesky.solve_in_place(x); }));
    }
    table.add({name, order, milliseconds(analysis), milliseconds(median(factor)),
               milliseconds(median(solve)),
               text("%.2f", 1e-6 * static_cast<double>(cholesky.factor_entries()))});
  };
  const auto compare = [&](const std::string& name, const SparseMatrix& A,
                           const std::vector<int>& order) {
    row(name, "AMD", A, [&](SparseCholesky& c) { c.analyze(A); });
    row(name, "METIS tried", A, [&](SparseCholesky& c) { c.analyze(A, FactorReuse::many); });
    if (!order.empty()) row(name, "dissection", A, [&](SparseCholesky& c) { c.analyze(A, order); });
  };
  for (const int n : {3300, 14600, 103000}) compare(text("sheet %d", n), holed_sheet(n).normal, {});
  for (const int n : {32, 64, 128}) {
    const BendingMatrix bending = clamped_bending(n);
    compare(text("bending %d²", n), bending.K, bending.order);
  }
  table.print();
}

// A drag that moves the boundary of one hole; a viewer that shows a quarter of the sheet.
void compare_parts() {
  Table table;
  table.add({"ms, three columns", "all", "b: a boundary", "x: a quarter", "both",
             "part of the factor read"});
  for (const int n : {14600, 103000}) {
    const HoledSheet sheet = holed_sheet(n);
    SparseCholesky cholesky;
    cholesky.analyze(sheet.normal);
    cholesky.factorize(sheet.normal);
    std::vector<int> rim, quarter;
    for (int i = 0; i < sheet.shape.rows(); ++i) {
      if (sheet.rim[i] && sheet.shape(i, 0) < 1 && sheet.shape(i, 1) < 1) rim.push_back(i);
      if (sheet.shape(i, 0) < 2.5 && sheet.shape(i, 1) < 2) quarter.push_back(i);
    }
    MatX b = MatX::Zero(sheet.normal.rows(), 3);
    for (const int i : rim) b.row(i).setOnes();
    constexpr auto all = std::nullopt;
    const SolveSubset parts[] = {cholesky.subset(all, all), cholesky.subset(rim, all),
                                 cholesky.subset(all, quarter), cholesky.subset(rim, quarter)};
    MatX full = b;
    cholesky.solve_in_place(full);
    std::vector<std::string> cells = {text("sheet %d", n)};
    std::string read;
    for (const SolveSubset& part : parts) {
      std::vector<double> times;
      MatX x;
      for (int round = 0; round < 15; ++round) {
        x = b;
        times.push_back(cpu_seconds_of([&] { cholesky.solve_in_place(part, x); }));
      }
      if (!(x(quarter, Eigen::all) == full(quarter, Eigen::all)))
        std::printf("ERROR: partial solve differs\n");
      cells.push_back(milliseconds(median(times)));
      read += text("%s%.0f %%", read.empty() ? "" : ", ",
                   50.0 * static_cast<double>(part.entries) /
                       static_cast<double>(cholesky.factor_entries()));
    }
    cells.push_back(read);
    table.add(cells);
  }
  table.print();
}

// Distance from the exact solution: the normal equations, refined with their own residual, and
// corrected with the least-squares residual.
void compare_corrections() {
  Table table;
  table.add({"error of x", "solved", "own residual", "least-squares residual", "ms"});
  for (const int n : {3300, 14600, 103000}) {
    const HoledSheet sheet = holed_sheet(n);
    SparseCholesky cholesky;
    cholesky.analyze(sheet.normal);
    cholesky.factorize(sheet.normal);
    const MatX truth = sheet.shape, b = sheet.rows * truth;
    const MatX right = sheet.rows.transpose() * b;
    const MatX x = cholesky.solve(right);
    const MatX refined =
        x + cholesky.solve(right - sheet.normal.selfadjointView<Eigen::Lower>() * x);
    MatX corrected = x;
    const double time =
        cpu_seconds_of([&] { refine_least_squares(cholesky, sheet.rows, b, corrected); });
    table.add({text("sheet %d", n), text("%.1e", relative(x - truth, truth)),
               text("%.1e", relative(refined - truth, truth)),
               text("%.1e", relative(corrected - truth, truth)), milliseconds(time)});
  }
  table.print();
}

}  // namespace

int main() {
  one_thread();
  Table table;
  table.add({"ms", "n", "entries (M)", "analyse", "CHOLMOD", "Eigen", "factor", "CHOLMOD", "Eigen",
             "solve", "CHOLMOD", "Eigen", "all cores", "of the bound", "CHOLMOD/solve",
             "difference", "backward error"});
  Checks checks;
  std::optional<double> slowest;
  std::optional<double> worst_difference;
  double worst_error = 0, bandwidth = 0;
  std::vector<std::pair<std::string, Result>> results;
  for (const NamedMatrix& m : twenty_matrices())
    results.emplace_back(m.name, measure(m.make(), bandwidth));
  for (const auto& [name, r] : results) {
    table.add(
        {name, text("%ld", r.n), text("%.2f", 1e-6 * static_cast<double>(r.entries)),
         milliseconds(r.ours.analyze), of_cholmod(r, &Times::analyze),
         milliseconds(r.eigen.analyze), milliseconds(r.ours.factor), of_cholmod(r, &Times::factor),
         milliseconds(r.eigen.factor), milliseconds(r.ours.solve), of_cholmod(r, &Times::solve),
         milliseconds(r.eigen.solve), milliseconds(r.on_all_cores),
         text("%.0f %%", 100 * r.fraction(bandwidth)),
         r.ratio() ? text("%.1f", *r.ratio()) : "none",
         r.difference ? text("%.0e", *r.difference) : "none", text("%.0e", r.backward_error)});
    if (r.ratio()) slowest = std::min(slowest.value_or(1e9), *r.ratio());
    if (r.difference) worst_difference = std::max(worst_difference.value_or(0), *r.difference);
    worst_error = std::max(worst_error, r.backward_error);
    const double target = name == "sheet 14k"                            ? 0.5
                          : name == "sheet 101k" || name == "sheet 303k" ? 0.35
                                                                         : 0;
    if (target > 0)
      checks.at_least("fraction of the memory bound, " + name, r.fraction(bandwidth), target);
    if (name == "sheet 14k")
      checks.at_least("CHOLMOD's time over Batten's, " + name, r.ratio(), 2.5);
  }
  checks.at_least("CHOLMOD's time over Batten's, the worst of twenty", slowest, 1);
  checks.at_most("relative difference from CHOLMOD, the worst of twenty", worst_difference, 1e-12);
  checks.at_most("backward error |Ax - b| / |A||x|, the worst of twenty", worst_error, 1e-14);
  std::printf("Three right-hand sides, one thread; triad %.1f GB/s; factor with %s\n\n",
              1e-9 * bandwidth, SparseCholesky::backend());
  table.print();
  compare_orders();
  compare_parts();
  compare_corrections();
  checks.print("solve");
}
