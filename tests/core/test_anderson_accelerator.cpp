// SPDX-License-Identifier: MPL-2.0
#include "batten/core/anderson_accelerator.h"

#include <deque>
#include <random>

#include "batten/tests/support/catch.h"

using namespace batten;

namespace {

Points random_points(long rows, std::mt19937& random) {
  std::uniform_real_distribution<double> number(-1, 1);
  return Points::NullaryExpr(rows, 3, [&] { return number(random); });
}

VecX stacked(const Points& p) { return Eigen::Map<const VecX>(p.data(), p.size()); }

/// Anderson acceleration by its definition: x_next = g - ΔG γ with γ the least-squares solution of
/// ΔF γ = f, over a window of the last six differences.
class LeastSquaresOracle {
 public:
  Points next(const Points& x, const Points& g) {
    const Points f = g - x;
    if (started_) {
      df_.push_back(stacked(f - f_));
      dg_.push_back(stacked(g - g_));
      if (df_.size() > 6) df_.pop_front(), dg_.pop_front();
    }
    f_ = f;
    g_ = g;
    started_ = true;
    if (df_.empty()) return g;
    MatX F(f.size(), static_cast<long>(df_.size())), G = F;
    for (long k = 0; k < F.cols(); ++k) {
      F.col(k) = df_[static_cast<size_t>(k)];
      G.col(k) = dg_[static_cast<size_t>(k)];
    }
    const VecX next = stacked(g) - G * least_squares(F, stacked(f));
    return Eigen::Map<const Points>(next.data(), g.rows(), 3);
  }

 private:
  std::deque<VecX> df_, dg_;
  Points f_, g_;
  bool started_ = false;
};

/// x ← A x + b, a contraction whose eigenvalues are spread between 0 and 0.95, plus a cubic term.
struct FixedPointMap {
  VecX rates;
  Points b;
  double cubic;
  Points operator()(const Points& x) const {
    return rates.asDiagonal() * x + b + cubic * x.cwiseProduct(x).cwiseProduct(x);
  }
};

FixedPointMap map_of(long rows, double cubic) {
  std::mt19937 random(7);
  return {VecX::LinSpaced(rows, 0, 0.95), random_points(rows, random), cubic};
}

}  // namespace

TEST_CASE("the accelerator proposes the least-squares combination of a sliding window",
          "[core][anderson]") {
  // A nonlinear map, so that a window of six differences slides many times: each step drops the
  // oldest difference by a QR downdate.
  const FixedPointMap map = map_of(40, 0.002);
  AndersonAccelerator accelerator(1e-12);
  accelerator.resize(40);
  LeastSquaresOracle oracle;
  Points x = Points::Zero(40, 3);
  for (int k = 0; k < 16; ++k) {
    const Points g = map(x);
    Points next = g;
    accelerator.accelerate(x, g, next);
    const Points expected = oracle.next(x, g);
    INFO("iterate " << k);
    CHECK((next - expected).norm() < 1e-6 * (expected - x).norm() + 1e-12 * expected.norm());
    x = 0.5 * g + 0.5 * next;  // damped, so that the differences stay well conditioned
  }
}

TEST_CASE("an affine map with six rates is solved in seven differences", "[core][anderson]") {
  VecX rates(60);
  for (long i = 0; i < 60; ++i) rates[i] = 0.15 * static_cast<double>(i % 6);
  std::mt19937 random(3);
  const FixedPointMap map{rates, random_points(60, random), 0};
  AndersonAccelerator accelerator(1e-10);
  accelerator.resize(60);
  Points x = random_points(60, random);
  for (int k = 0; k < 7; ++k) {
    const Points g = map(x);
    Points next = g;
    accelerator.accelerate(x, g, next);
    x = next;
  }
  CHECK((map(x) - x).norm() < 1e-9);
}

TEST_CASE("residuals on a sample of rows give the combination of those rows", "[core][anderson]") {
  const FixedPointMap map = map_of(30, 0);
  std::vector<int> sample;
  for (int i = 0; i < 30; i += 2) sample.push_back(i);
  AndersonAccelerator all(1e-10), some(1e-10);
  all.resize(15);
  some.resize(30, sample);
  std::mt19937 random(5);
  Points x = random_points(30, random);
  for (int k = 0; k < 5; ++k) {
    const Points g = map(x);
    const Points x_sampled = x(sample, Eigen::all), g_sampled = g(sample, Eigen::all);
    Points next = g, next_sampled = g_sampled;
    some.accelerate(x, g, next);
    all.accelerate(x_sampled, g_sampled, next_sampled);
    CHECK((next(sample, Eigen::all) - next_sampled).norm() < 1e-10 * next.norm());
    x = 0.7 * g + 0.3 * next;
  }
}

TEST_CASE("a difference that depends on the stored ones replaces the oldest", "[core][anderson]") {
  // Two rates: after two differences each new one depends on them.
  VecX rates(20);
  for (long i = 0; i < 20; ++i) rates[i] = i % 2 ? 0.9 : 0.4;
  std::mt19937 random(11);
  const FixedPointMap map{rates, random_points(20, random), 0};
  AndersonAccelerator accelerator(0.3);
  accelerator.resize(20);
  Points x = Points::Zero(20, 3);
  for (int k = 0; k < 30; ++k) {
    const Points g = map(x);
    Points next = g;
    accelerator.accelerate(x, g, next);
    REQUIRE(next.allFinite());
    x = 0.5 * g + 0.5 * next;
  }
  CHECK((map(x) - x).norm() < 1e-6);
}
