#include "batten/mesh/regions/anderson_accelerator.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace batten {
namespace {

double dot(const MatX& a, const MatX& b) {
  return Eigen::Map<const VecX>(a.data(), a.size()).dot(Eigen::Map<const VecX>(b.data(), b.size()));
}

}  // namespace

AndersonAccelerator::AndersonAccelerator(long rows)
    : f_(MatX::Zero(rows, 3)),
      g_(f_),
      step_f_(kMemory, f_),
      step_g_(kMemory, f_),
      products_(Eigen::Matrix<double, kMemory, kMemory>::Zero()) {}

bool AndersonAccelerator::accelerate(const MatX& y, const MatX& g, MatX& accelerated) {
  if (history_size_++ == 0) {
    f_ = g - y;
    g_ = g;
    return false;
  }
  const auto newest = static_cast<int>((history_size_ - 2) % kMemory);
  const int count = static_cast<int>(std::min<long>(history_size_ - 1, kMemory));
  step_f_[newest] = g - y - f_;
  step_g_[newest] = g - g_;
  f_ += step_f_[newest];
  g_ = g;
  for (int j = 0; j < count; ++j)
    products_(newest, j) = products_(j, newest) = dot(step_f_[newest], step_f_[j]);
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMemory, 1> theta(count);
  for (int j = 0; j < count; ++j) theta[j] = dot(step_f_[j], f_);
  Small normal = products_.topLeftCorner(count, count);
  // Steps that are nearly one another must not cancel.
  normal.diagonal().array() += 1e-10 * normal.trace();
  const Eigen::LDLT<Small> factor(normal);
  if (factor.info() != Eigen::Success) return false;
  theta = factor.solve(theta).eval();
  if (!theta.allFinite()) return false;
  accelerated = g;
  for (int j = 0; j < count; ++j) accelerated -= theta[j] * step_g_[j];
  return true;
}

}  // namespace batten
