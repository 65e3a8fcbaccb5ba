// B-splines by their poles.
#include <algorithm>
#include <array>

#include "batten/core/errors.h"
#include "batten/core/format.h"
#include "batten/core/isize.h"
#include "batten/fairing/primitive_curves.h"

namespace batten {
namespace {

using Homogeneous = Eigen::Vector4d;

// A polynomial B-spline in homogeneous coordinates and its two derivatives.
class Spline final : public InputCurve {
 public:
  Spline(int degree, std::vector<Homogeneous> poles, std::vector<double> knots, bool rational)
      : degree_(degree), knots_(std::move(knots)), rational_(rational) {
    poles_[0] = std::move(poles);
    // Poles of derivatives, over the same knots without the outermost ones.
    for (int d = 1; d <= 2 && d <= degree; ++d) {
      const auto& p = poles_[d - 1];
      for (int i = 0; i + 1 < isize(p); ++i) {
        const double length = knots_[i + degree + 1] - knots_[i + d];
        poles_[d].push_back(length > 0 ? Homogeneous((degree - d + 1) / length * (p[i + 1] - p[i]))
                                       : Homogeneous::Zero());
      }
    }
  }
  double start() const override { return knots_[degree_]; }
  double end() const override { return knots_[knots_.size() - 1 - degree_]; }
  bool piecewise_cubic() const override { return !rational_ && degree_ <= 3; }
  std::vector<double> breaks() const override {
    std::vector<double> all(knots_.begin() + degree_, knots_.end() - degree_);
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
  }
  Vec3 evaluate(double t, int order) const override {
    const Homogeneous h = de_boor(t, 0);
    const double w = h[3];
    const Vec3 x = h.head<3>() / w;
    if (order == 0) return x;
    const Homogeneous h1 = de_boor(t, 1);
    const Vec3 x1 = (h1.head<3>() - h1[3] * x) / w;
    if (order == 1) return x1;
    const Homogeneous h2 = de_boor(t, 2);
    return (h2.head<3>() - 2 * h1[3] * x1 - h2[3] * x) / w;
  }

 private:
  Homogeneous de_boor(double t, int derivative) const {
    const int p = degree_ - derivative;
    if (p < 0) return Homogeneous::Zero();
    const auto& poles = poles_[derivative];
    const double* knots = knots_.data() + derivative;
    int k = p;  // the span [knot k, knot k+1) that has t
    while (k + 1 < isize(poles) && t >= knots[k + 1]) ++k;
    std::array<Homogeneous, 10> d;
    for (int i = 0; i <= p; ++i) d[i] = poles[k - p + i];
    for (int r = 1; r <= p; ++r)
      for (int i = p; i >= r; --i) {
        const double a = knots[k - p + i], b = knots[k + 1 + i - r];
        const double f = b > a ? (t - a) / (b - a) : 0;
        d[i] = (1 - f) * d[i - 1] + f * d[i];
      }
    return d[p];
  }

  int degree_;
  std::vector<double> knots_;
  bool rational_;
  std::array<std::vector<Homogeneous>, 3> poles_;
};

std::vector<double> even_knots(int degree, int poles) {
  std::vector<double> knots(degree + 1, 0.0);
  const int spans = poles - degree;
  for (int i = 1; i < spans; ++i) knots.push_back(static_cast<double>(i) / spans);
  knots.insert(knots.end(), degree + 1, 1.0);
  return knots;
}

void check_knots(int degree, int poles, const std::vector<double>& knots) {
  if (isize(knots) != poles + degree + 1)
    throw InputError("found " + std::to_string(knots.size()) + " knots for " +
                     std::to_string(poles) + " poles and degree " + std::to_string(degree) +
                     ", expected " + std::to_string(poles + degree + 1));
  for (size_t i = 0; i + 1 < knots.size(); ++i)
    if (!(knots[i] <= knots[i + 1]))
      throw InputError("found the knot " + format_number(knots[i + 1]) + " behind " +
                       format_number(knots[i]) + ", expected knots that do not descend");
  // An inner knot as often as the degree still leaves the curve in one piece.
  const double first = knots[degree], last = knots[knots.size() - 1 - degree];
  for (size_t i = 0; i + degree < knots.size(); ++i)
    if (knots[i] == knots[i + degree] && knots[i] > first && knots[i] < last)
      throw InputError("found the knot " + format_number(knots[i]) + " more than " +
                       std::to_string(degree) +
                       " times, expected at most that: the curve is torn there");
  if (!(last > first)) throw InputError("found knots without a span, expected ones that ascend");
}

}  // namespace

std::shared_ptr<const InputCurve> nurbs_curve(int degree, const std::vector<Vec3>& poles,
                                              const std::vector<double>& weights,
                                              const std::vector<double>& knots) {
  constexpr int most = 9;
  if (degree < 1 || degree > most)
    throw InputError("found the degree " + std::to_string(degree) + ", expected 1 to " +
                     std::to_string(most));
  if (isize(poles) <= degree)
    throw InputError("found " + std::to_string(poles.size()) + " poles for degree " +
                     std::to_string(degree) + ", expected " + std::to_string(degree + 1) +
                     " or more");
  if (!weights.empty() && weights.size() != poles.size())
    throw InputError("found " + std::to_string(weights.size()) + " weights for " +
                     std::to_string(poles.size()) + " poles, expected one for each");
  if (!knots.empty()) check_knots(degree, isize(poles), knots);
  std::vector<Homogeneous> all;
  bool rational = false;
  for (size_t i = 0; i < poles.size(); ++i) {
    const double w = weights.empty() ? 1 : weights[i];
    if (!(w > 0))
      throw InputError("found the weight " + format_number(w) + ", expected weights above 0");
    rational = rational || w != (weights.empty() ? 1 : weights[0]);
    all.emplace_back(w * poles[i].x(), w * poles[i].y(), w * poles[i].z(), w);
  }
  return std::make_shared<Spline>(
      degree, std::move(all), knots.empty() ? even_knots(degree, isize(poles)) : knots, rational);
}

}  // namespace batten
