#include "batten/mesh/sequence/signal_filter.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/core/rotations.h"
#include "batten/mesh/sequence/keyframe_weights.h"

namespace batten {
namespace {

/// Sampled Gaussian from 1 on, whole sum with its middle 1.
std::vector<double> gaussian(double sigma) {
  if (!(sigma > 0 && sigma <= 1e5))
    throw InputError("filter: sigma is " + format_number(sigma) +
                     ", expected above 0, up to 1e5 frames");
  std::vector<double> g(static_cast<size_t>(std::ceil(7 * sigma)));
  double sum = 0;
  for (size_t j = g.size(); j-- > 0;) {
    const double s = static_cast<double>(j + 1) / sigma;
    sum += g[j] = std::exp(-s * s / 2);
  }
  for (double& value : g) value /= 1 + 2 * sum;
  return g;
}

/// The signal with `more` values beyond each end, as `beyond` makes them from the value at the end
/// and the one as far inside.
template <class Value, class Beyond>
std::vector<Value> extended(const std::vector<Value>& x, int more, const Beyond& beyond) {
  const int last = isize(x) - 1;
  std::vector<Value> all(x.size() + 2 * static_cast<size_t>(more), x.front());
  std::copy(x.begin(), x.end(), all.begin() + more);
  if (last == 0) return all;
  // Outwards on both sides at once: what is farther inside than the signal is long is there
  // already.
  Value* const at = all.data() + more;
  for (int j = 1; j <= more; ++j) {
    at[-j] = beyond(at[0], at[j]);
    at[last + j] = beyond(at[last], at[last - j]);
  }
  return all;
}

}  // namespace

SignalFilter::SignalFilter(double sum, std::vector<double> taps)
    : sum_(sum), taps_(std::move(taps)) {}

SignalFilter SignalFilter::low_pass(double sigma) { return {1, gaussian(sigma)}; }

SignalFilter SignalFilter::high_pass(double sigma) {
  std::vector<double> taps = gaussian(sigma);
  for (double& h : taps) h = -h;
  return {0, taps};
}

SignalFilter SignalFilter::cartoon(double sigma, double amount) {
  std::vector<double> taps = gaussian(sigma);
  for (size_t j = 0; j < taps.size(); ++j) {
    const double s = static_cast<double>(j + 1) / sigma;
    taps[j] *= -amount * (s * s - 1);
  }
  return {1, taps};
}

double SignalFilter::response(double omega) const {
  double result = 0;
  for (size_t j = taps_.size(); j-- > 0;) {
    const double s = std::sin(omega * static_cast<double>(j + 1) / 2);
    result -= 4 * taps_[j] * s * s;
  }
  return sum_ + result;
}

Points SignalFilter::operator()(const Points& signal, Padding padding) const {
  if (signal.rows() == 0) return signal;
  const int more = isize(taps_);
  std::vector<Vec3> rows(signal.rows());
  for (int k = 0; k < isize(rows); ++k) rows[k] = signal.row(k);
  const std::vector<Vec3> x = extended(rows, more, [&](const Vec3& end, const Vec3& inside) {
    return padding == Padding::Even ? inside : Vec3(2 * end - inside);
  });
  Points result(signal.rows(), 3);
  for (int k = 0; k < isize(rows); ++k) {
    const Vec3* const at = x.data() + more + k;
    Vec3 change = Vec3::Zero();
    for (int j = more; j > 0; --j) change += taps_[j - 1] * ((at[j] - at[0]) + (at[-j] - at[0]));
    result.row(k) = sum_ * at[0] + change;
  }
  return result;
}

std::vector<Mat3> SignalFilter::operator()(const std::vector<Mat3>& rotations,
                                           Padding padding) const {
  if (rotations.empty()) return rotations;
  const int more = isize(taps_);
  const std::vector<Mat3> R = extended(rotations, more, [&](const Mat3& end, const Mat3& inside) {
    return padding == Padding::Even ? inside : Mat3(end * inside.transpose() * end);
  });
  std::vector<Mat3> result;
  const Points logs = unwrapped_logs(rotations);
  for (int k = 0; k < isize(rotations); ++k) {
    const Mat3* const at = R.data() + more + k;
    Vec3 change = Vec3::Zero();
    for (const int side : {-1, 1}) {
      Vec3 log = Vec3::Zero();
      for (int j = 1; j <= more; ++j) {
        log = nearest_log(Mat3(at[0].transpose() * at[side * j]), log);
        change += taps_[j - 1] * log;
      }
    }
    const Mat3 own = sum_ == 1 ? at[0] : rotation_matrix(sum_ * logs.row(k).transpose());
    result.push_back(own * rotation_matrix(change));
  }
  return result;
}

}  // namespace batten
