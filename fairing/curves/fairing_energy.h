// SPDX-License-Identifier: MPL-2.0
// Fairing energy of curves (bending and variation of the second derivative), and the local
// smoothing wavelength.
#pragma once

#include <array>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/fem/curves/curve_mesh.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// Element matrices of the fairing energy, for one coordinate of a cubic curve.
///
/// Waves below the wavelength w = 2πa are smoothed away by
///
///     ρ ∫ (1-b) (ra)⁶ |X_uuu|² + b (ra)⁴ (|X_uu|² + alpha |X_u|²) du
///   + ρ Σ_n (1-b) (ra)⁶ μ/h [X_uu]²
///
/// with ρ springs per length and the local wavelength factor r (CurvatureAdaptiveWavelength).
/// [X_uu] is the jump of the second derivative at a node n that is no corner, and h the mean length
/// of the adjacent segments. μ = 1000 leaves little of the jumps.
///
/// Under evenly spaced springs, a wave of wavelength v keeps 1 / (1 + (1-b) (rw/v)⁶ + b (rw/v)⁴) of
/// its height. Unlike bending, which leaves waves of noise in the curvature, the third derivative
/// smooths the curvature too. If waves are nearly as long as the curve, bending controls the modes
/// that the third derivative leaves free: b = 1 / (1 + (βL/w)²), β = 0.5, L the length.
class FairingEnergy {
 public:
  using Matrix = Eigen::Matrix<double, 6, 6>;
  /// Element matrix: the first `count` dofs and the leading count×count block of K are used.
  struct Part {
    int count = 4;
    std::array<int, 6> dofs{};
    Matrix K = Matrix::Zero();
    /// The straight lines 1 and u, which have zero energy, in terms of these dofs. Products with K
    /// lose fewer digits if this part is subtracted first.
    Eigen::Matrix<double, 6, 2> free = Eigen::Matrix<double, 6, 2>::Zero();
    int dof(int a) const { return dofs[static_cast<size_t>(a)]; }
  };
  /// `wavelength_factor`: r at each parameter of the mesh; empty: 1. alpha ≥ 0, 1/length². `mu`:
  /// weight μ of the jumps.
  FairingEnergy(const CurveMesh& mesh, const std::vector<double>& wavelength_factor, double alpha,
                double mu = 1000);

  /// Element matrices of the terms that are multiplied by ρ (1-b) a⁶ (variation) and by ρ b a⁴
  /// (bending).
  const std::vector<Part>& variation() const { return variation_; }
  const std::vector<Part>& bending() const { return bending_; }
  /// Computes f -= factor K x, summed over all parts.
  static void subtract(const std::vector<Part>& parts, double factor, const Points& x, Points& f);

 private:
  std::vector<Part> variation_, bending_;
};

/// Local factor of the smoothing wavelength, which keeps tight bends such as an airfoil's nose from
/// being flattened.
///
/// It is (κ̄/1.2κ_m)^(-5/12) where the local mean curvature κ̄ exceeds 1.2 times the mean curvature
/// κ_m of the whole curve, and 1 elsewhere. This is close to one constant wavelength in a parameter
/// that runs faster through bends, dτ ∝ √κ ds. Circles and straight lines have the factor 1
/// everywhere.
class CurvatureAdaptiveWavelength {
 public:
  CurvatureAdaptiveWavelength() = default;
  /// Computes the factors of a curve.
  ///
  /// κ̄ is the turning angle per length over a window of a quarter of the local wavelength
  /// (`wavelength` times `before`) on either side, in which waves of noise cancel. The window ends
  /// at corners.
  CurvatureAdaptiveWavelength(const HermiteCurve& curve, double wavelength,
                              const CurvatureAdaptiveWavelength& before);

  /// True if the factor is 1 everywhere.
  bool even() const { return factors_.empty(); }
  /// Factor at a fraction of the length, in [0, 1].
  double at(double fraction) const;
  /// Factors at all parameters of a mesh; empty if even().
  std::vector<double> of(const CurveMesh& mesh) const;

 private:
  std::vector<double> u_, factors_;  // u_: fractions of the length
};

}  // namespace batten
