// SPDX-License-Identifier: MPL-2.0
// Largest response of a shell whose supports shake, from a response spectrum.
#pragma once

#include <utility>
#include <vector>

#include "batten/analysis/models/shell_modes.h"
#include "batten/analysis/models/shell_stresses.h"

namespace batten {

/// A response spectrum: the largest acceleration of an oscillator by its frequency, linear between the
/// given points in logarithmic scales, constant before the first and after the last one.
class ResponseSpectrum {
 public:
  /// `points`: frequencies and accelerations. Throws InputError without points, unless all numbers are
  /// above 0 and the frequencies ascend.
  explicit ResponseSpectrum(std::vector<std::pair<double, double>> points);
  double operator()(double frequency) const;
  double last_frequency() const { return points_.back().first; }
  /// The acceleration of a rigid body, that of the last point.
  double rigid_acceleration() const { return points_.back().second; }

 private:
  std::vector<std::pair<double, double>> points_;
};

/// Response of a shell to an acceleration of all supports in one direction, by superposition of modes:
/// the largest displacements of mode k are Γ_k S(f_k)/ω_k² φ_k, with its participation factor Γ_k and
/// the spectrum S. The modes are combined by CQC (complete quadratic combination),
///
///     R² = Σ_jk ρ_jk R_j R_k,   ρ_jk = 8 ζ² (1 + r) r^1.5 / ((1 - r²)² + 4 ζ² r (1 + r)²),  r = ω_j/ω_k
///
/// with the damping ratio ζ. The mass that does not belong to a mode moves as a rigid body: the static
/// response to its inertia under the acceleration of the last point of the spectrum is one more
/// response, which is not correlated with the modes. Reference: [Wilson1981], [Clough1993].
class SpectrumResponse {
 public:
  /// `modes`: those of the supported shell, up to the last frequency of the spectrum; `direction`: of
  /// the acceleration. `damping`: above 0, below 1. Throws InputError for another one, and for modes of a
  /// free shell. Cost: one pair of triangular solves.
  SpectrumResponse(const ShellModel& shell, const ShellModes& modes,
                   const ResponseSpectrum& spectrum, const Vec3& direction, double damping);

  /// The largest displacement dofs of each response, n×3: the modes, then that of the rest of the mass.
  const std::vector<Points>& displacements() const { return displacements_; }
  /// The inertia forces that cause them, n×3.
  const std::vector<Points>& loads() const { return loads_; }
  /// Part of the mass, in the direction, that belongs to the modes: Σ Γ_k²/m.
  double mass_fraction() const { return mass_fraction_; }

  /// Combination of one value per response.
  double combine(const VecX& values) const;
  /// Von Mises stress of the combination of one plane stress per response.
  double combined_von_mises(const std::vector<Mat3>& stresses) const;

 private:
  std::vector<Points> displacements_, loads_;
  MatX correlation_;
  double mass_fraction_ = 0;
};

}  // namespace batten
