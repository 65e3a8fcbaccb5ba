// Where a curve that is faired is smoothed less. Internal.
#pragma once

#include <vector>

#include "batten/fem/hermite_curve.h"

namespace batten {

/// What multiplies the wavelength that is smoothed along a curve, so that tight bends are not
/// flattened where the rest is wide, as at an airfoil's nose: (κ̄/1.2κ_m)^(-5/12) where the mean
/// curvature κ̄ around a place exceeds 1.2 times that of the whole line, κ_m; else 1. It is nearly
/// what one wavelength becomes in a parameter that runs faster through bends, dτ ∝ √κ ds. A circle
/// has 1 everywhere, and so has a straight line.
class CurvatureAdaptiveWavelength {
 public:
  CurvatureAdaptiveWavelength() = default;
  /// κ̄ is the turn over a quarter of the wavelength that is smoothed there on either side (of
  /// `wavelength` times `before`), not across corners: waves of noise cancel in it.
  CurvatureAdaptiveWavelength(const HermiteCurve& curve, double wavelength,
                              const CurvatureAdaptiveWavelength& before);

  bool even() const { return factors_.empty(); }
  /// At a share of the length, in [0, 1].
  double at(double fraction) const;
  /// At each parameter of a mesh; none where it is even.
  std::vector<double> of(const CurveMesh& mesh) const;

 private:
  std::vector<double> u_, factors_;  // at shares of the length
};

}  // namespace batten
