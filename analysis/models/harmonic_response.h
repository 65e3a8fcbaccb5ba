// SPDX-License-Identifier: MPL-2.0
// Steady vibration of a shell under a harmonic load, by superposition of its modes.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "batten/analysis/models/shell_modes.h"

namespace batten {

/// Response to a load F cos(2π f t), with modal damping. With the modes φ_k (modal mass 1), their
/// angular frequencies ω_k, the damping ratio ζ, ω = 2π f, and the static displacement u_0 under F:
///
///     u(f) = u_0 + Σ_k φ_k (φ_kᵀ F) (1/(ω_k² - ω² + 2 i ζ ω_k ω) - 1/ω_k²)
///
/// The static displacement contains the response of all modes that are not in the sum (static
/// correction), so that the error is small if the last ω_k is at least twice ω. Reference:
/// [Clough1993].
class HarmonicResponse {
 public:
  /// `modes`: those of a supported shell; `F`: load vector, n×3. `damping`: ζ, from 0 (then a response
  /// at a natural frequency is infinite) to below 1. Throws InputError for another one, and for modes of a
  /// free shell.
  HarmonicResponse(const ShellModes& modes, const Points& F, double damping);

  /// The amplitudes of x, y and z at a point: their absolute values, and their phases relative to the
  /// load. `static_displacement`: u_0 there; `shapes`: φ_k there.
  Eigen::Vector3cd at(double frequency, const Vec3& static_displacement,
                      const std::vector<Vec3>& shapes) const;
  const VecX& frequencies() const { return frequencies_; }

 private:
  VecX frequencies_, loads_;
  double damping_;
};

/// The modes of a supported shell up to the first one above a frequency.
ShellModes modes_up_to(const ShellModel& shell, double frequency);

}  // namespace batten
