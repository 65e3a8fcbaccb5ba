// What a curve that is faired resists: bending, and more so the change of it. Internal.
#pragma once

#include <array>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/fem/curves/curve_mesh.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// The energy of one coordinate of a cubic curve, for the wavelength w = 2πa below which waves are
/// smoothed away:
///
///     ρ ∫ (1-b) (ra)⁶ |X_uuu|² + b (ra)⁴ (|X_uu|² + alpha |X_u|²) du
///   + ρ Σ_n (1-b) (ra)⁶ μ/h [X_uu]²
///
/// with ρ springs per length, r the ease (CurvatureAdaptiveWavelength), h the mean length of the segments beside a
/// node n that is no corner, and [X_uu] by how much the second derivative jumps there: μ = 1000
/// leaves little of that. A wave of wavelength v along even springs keeps
/// 1 / (1 + (1-b) (rw/v)⁶ + b (rw/v)⁴) of its height. The third derivative smooths the curvature
/// too, which bending leaves in waves of noise. Where waves are nearly as long as the line bending
/// holds what the third derivative leaves free there: b = 1 / (1 + (βL/w)²), β = 0.5, L the length.
class FairingEnergy {
 public:
  using Matrix = Eigen::Matrix<double, 6, 6>;
  /// The first `count` of its dofs, and that corner of its matrix.
  struct Part {
    int count = 4;
    std::array<int, 6> dofs{};
    Matrix K = Matrix::Zero();
    /// Of the two straight lines that cost nothing, 1 and u: their dofs. Without them the products
    /// of K lose fewer digits.
    Eigen::Matrix<double, 6, 2> free = Eigen::Matrix<double, 6, 2>::Zero();
    int dof(int a) const { return dofs[static_cast<size_t>(a)]; }
  };
  /// `wavelength_factor`: r at each parameter of the mesh, or none for 1; alpha ≥ 0, 1/length².
  FairingEnergy(const CurveMesh& mesh, const std::vector<double>& wavelength_factor, double alpha,
                double mu = 1000);

  /// Matrices of what is multiplied by ρ (1-b) a⁶, and by ρ b a⁴.
  const std::vector<Part>& variation() const { return variation_; }
  const std::vector<Part>& bending() const { return bending_; }
  /// f -= factor K x of all parts.
  static void subtract(const std::vector<Part>& parts, double factor, const Points& x, Points& f);

 private:
  std::vector<Part> variation_, bending_;
};


// Where a curve that is faired is smoothed less. Internal.

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
