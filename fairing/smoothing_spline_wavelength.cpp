#include "batten/fairing/smoothing_spline_solver.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"

namespace batten {

// Largest distance of a point from the curve at its parameter, across the tangent.
double SmoothingSplineSolver::max_normal_distance(const Points& q) const {
  const HermiteCurve curve(mesh_, q);
  double worst = 0;
  for (int i = 0; i < count_; ++i) {
    Vec3 d = curve.evaluate(u_[i]) - sequence_.points[i];
    const Vec3 t = curve.evaluate(u_[i], 1).normalized();
    if (!std::binary_search(sequence_.corners.begin(), sequence_.corners.end(), i))
      d -= t.dot(d) * t;
    worst = std::max(worst, d.norm());
  }
  return worst;
}

// Root mean square by which noise may have moved the points: what moves them farther was none.
double SmoothingSplineSolver::max_rms_move() const {
  constexpr double any = 0.025, none = 1e-6;  // of the size
  constexpr int fewest = 11;                  // points of which estimate_noise() knows something
  if (count_ < fewest) return any * sequence_.size;
  return std::min(any * sequence_.size, 2 * noise_ + none * sequence_.size);
}

// The longest wavelength that fits, of those that are long, fit not, or are short and fit.
double SmoothingSplineSolver::longest_wavelength(const std::function<bool(double)>& fits) const {
  const auto can = [&](double wavelength) {
    try {
      return fits(wavelength);
    } catch (const NoSolutionError&) {
      return false;  // so long a wave leaves nothing of the springs
    }
  };
  const double coarsest = 2 * length_;
  if (can(coarsest)) return coarsest;
  const bool is_close = options_.smoothing == FairOptions::Smoothing::Deviation;
  double low = std::log(is_close ? negligible_wavelength() : shortest_wavelength()),
         high = std::log(coarsest);
  constexpr int halvings = 24;
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (low + high);
    (can(std::exp(middle)) ? low : high) = middle;
  }
  return std::exp(low);
}

double SmoothingSplineSolver::choose_wavelength(PenalisedLeastSquares& smoothing, double before) {
  const double finest = shortest_wavelength(), coarsest = 2 * length_;
  switch (options_.smoothing) {
    case FairOptions::Smoothing::Wavelength:
      // Beyond twice an open line's length all of it is smoothed but a parabola.
      return sequence_.closed ? options_.wavelength : std::min(options_.wavelength, coarsest);
    case FairOptions::Smoothing::CrossValidation: {
      constexpr int fewest = 6;  // points from which something can be learned about noise
      if (count_ < fewest) return min_wavelength_;
      // Where points lie unevenly the finest wave already moves what has no noise.
      if (smoothing.rms_residual(smoothing.solve(finest)) > max_rms_move()) return min_wavelength_;
      const double low = before > 0 ? std::max(finest, before / 3) : finest,
                   high = before > 0 ? std::min(coarsest, before * 3) : coarsest;
      return std::exp(golden_section_minimum(
          [&](double x) { return smoothing.gcv_score(std::exp(x), max_rms_move()); }, std::log(low),
          std::log(high), before > 0 ? 6 : 16));
    }
    case FairOptions::Smoothing::Noise:
      return longest_wavelength([&](double wavelength) {
        const Points q = solve(smoothing, wavelength);
        if (!is_unconstrained()) smoothing.solve(wavelength);
        const double left = 1 - smoothing.effective_dofs() / count_;
        return left > 0 && smoothing.rms_residual(q) <= options_.noise * std::sqrt(left);
      });
    case FairOptions::Smoothing::Deviation:
      return longest_wavelength([&](double wavelength) {
        return max_normal_distance(solve(smoothing, wavelength)) <=
               tolerance_factor_ * options_.deviation;
      });
  }
  return 0;
}

}  // namespace batten
