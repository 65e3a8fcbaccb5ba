#include "batten/fairing/fair_rounds.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"

namespace batten {

// Largest distance of a point from the curve at its parameter, across the tangent.
double FairRounds::off_axis(const Points& q) const {
  const HermiteCurve curve(mesh_, q);
  double worst = 0;
  for (int i = 0; i < count_; ++i) {
    Vec3 d = curve.evaluate(u_[i]) - row_.points[i];
    const Vec3 t = curve.evaluate(u_[i], 1).normalized();
    if (!std::binary_search(row_.corners.begin(), row_.corners.end(), i)) d -= t.dot(d) * t;
    worst = std::max(worst, d.norm());
  }
  return worst;
}

// Root mean square by which noise may have moved the points: what moves them farther was none.
double FairRounds::most_move() const {
  constexpr double any = 0.025, none = 1e-6;  // of the size
  constexpr int fewest = 11;                  // points of which noise_across() knows something
  if (count_ < fewest) return any * row_.size;
  return std::min(any * row_.size, 2 * noise_ + none * row_.size);
}

// The longest wavelength that fits, of those that are long, fit not, or are short and fit.
double FairRounds::longest_wave(const std::function<bool(double)>& fits) const {
  const auto can = [&](double wave) {
    try {
      return fits(wave);
    } catch (const NoSolutionError&) {
      return false;  // so long a wave leaves nothing of the springs
    }
  };
  const double coarsest = 2 * length_;
  if (can(coarsest)) return coarsest;
  const bool is_close = options_.balance == FairOptions::Balance::Deviation;
  double low = std::log(is_close ? no_wave() : finest_wave()), high = std::log(coarsest);
  constexpr int halvings = 24;
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (low + high);
    (can(std::exp(middle)) ? low : high) = middle;
  }
  return std::exp(low);
}

double FairRounds::find_wave(SpringBalance& balance, double before) {
  const double finest = finest_wave(), coarsest = 2 * length_;
  switch (options_.balance) {
    case FairOptions::Balance::Wavelength:
      // Beyond twice an open line's length all of it is smoothed but a parabola.
      return row_.closed ? options_.wavelength : std::min(options_.wavelength, coarsest);
    case FairOptions::Balance::CrossValidation: {
      constexpr int fewest = 6;  // points from which something can be learned about noise
      if (count_ < fewest) return least_wave_;
      // Where points lie unevenly the finest wave already moves what has no noise.
      if (balance.moved(balance.solve(finest)) > most_move()) return least_wave_;
      const double low = before > 0 ? std::max(finest, before / 3) : finest,
                   high = before > 0 ? std::min(coarsest, before * 3) : coarsest;
      return std::exp(minimum_of([&](double x) { return balance.score(std::exp(x), most_move()); },
                                 std::log(low), std::log(high), before > 0 ? 6 : 16));
    }
    case FairOptions::Balance::Noise:
      return longest_wave([&](double wave) {
        const Points q = solve(balance, wave);
        if (!free_of_rows()) balance.solve(wave);
        const double left = 1 - balance.freedom() / count_;
        return left > 0 && balance.moved(q) <= options_.noise * std::sqrt(left);
      });
    case FairOptions::Balance::Deviation:
      return longest_wave([&](double wave) {
        return off_axis(solve(balance, wave)) <= tightened_ * options_.deviation;
      });
  }
  return 0;
}

}  // namespace batten
