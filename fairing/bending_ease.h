// Where a curve that is faired may bend more easily. Internal.
#pragma once

#include <vector>

#include "batten/elements/hermite_segment.h"
#include "batten/fem/curve.h"

namespace batten {

/// What multiplies bending along a curve, so that tight bends are not flattened where the rest is
/// wide, as at an airfoil's nose: (κ̄/2κ_m)^-1.5 where the mean curvature κ̄ around a place exceeds
/// twice that of the whole line, κ_m; else 1. It is what bending of even weight becomes in a
/// parameter that runs faster through bends, dτ ∝ √κ ds. A circle has 1 everywhere, and so has a
/// straight line.
class BendingEase {
 public:
  BendingEase() = default;
  /// κ̄ is the turn over a quarter of the wavelength that is smoothed there on either side (of
  /// `wave` times the fourth root of `before`), not across corners: waves of noise cancel in it.
  BendingEase(const HermiteCurve& curve, double wave, const BendingEase& before);

  bool even() const { return ease_.empty(); }
  /// At a share of the length, in [0, 1].
  double at(double share) const;
  /// Linear along each segment, none where it is even: curvature then does not jump at nodes.
  std::vector<HermiteSegment::Linear> of(const CurveMesh& mesh) const;

 private:
  std::vector<double> u_, ease_;  // at shares of the length
};

}  // namespace batten
