// SPDX-License-Identifier: MPL-2.0
// Penalised least squares on one curve mesh: springs to the data against the fairing energy.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "batten/fairing/curves/curve_dof_ordering.h"
#include "batten/fairing/curves/fairing_energy.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// Arc length along a Hermite curve, at nodes and inside segments. Keeps a reference to the curve.
class HermiteArcLength {
 public:
  explicit HermiteArcLength(const HermiteCurve& curve);
  double total() const { return at_node_.back(); }
  double operator()(double u) const;

 private:
  double inside(CurveMesh::SegmentPoint at) const;
  const HermiteCurve& curve_;
  std::vector<double> at_node_;
};

/// Spring that pulls the curve at one parameter towards a point.
struct Spring {
  CurveMesh::SegmentPoint at;
  Vec3 goal;
};

/// Minimises Σ |X(u_i) - goal_i|² + FairingEnergy for any smoothing wavelength. Keeps references to
/// its arguments.
class PenalisedLeastSquares {
 public:
  /// `fixed_dofs`: pairs of a dof and its prescribed value.
  PenalisedLeastSquares(const CurveMesh& mesh, const std::vector<Spring>& springs,
                        const FairingEnergy& energy, std::vector<std::pair<int, Vec3>> fixed_dofs);

  /// Dofs of the minimising curve. Throws NoSolutionError if the wavelength is so large that the
  /// springs are lost in rounding.
  Points solve(double wavelength);
  /// Effective dofs per coordinate: trace of the influence matrix of the last solve(). Every fixed
  /// dof counts 1.
  double effective_dofs() const;
  /// RMS distance of the curve from the goals of the springs.
  double rms_residual(const Points& dofs) const;
  /// Generalised cross-validation score of a wavelength; smaller is better.
  ///
  /// From six points on, each degree of freedom counts more than once, up to 1.3 times from 20
  /// points on. The score is infinite if the points move by more than `most` (RMS), or if solve()
  /// would throw.
  double gcv_score(double wavelength, double most);

  /// System matrix for a wavelength, and the load of the springs relative to `origin`; both in the
  /// dof order of the mesh.
  SparseMatrix matrix(double wavelength) const;
  Points load(const Vec3& origin) const;
  /// Load minus matrix times `dofs`, accurate to more digits than matrix() and load() would give.
  Points residual(double wavelength, const Points& dofs) const;

 private:
  bool try_solve(double wavelength, Points& q);
  Vec3 at(const Points& dofs, const Spring& spring) const;
  // Factors of the parts of the energy.
  double bending_fraction(double wavelength) const;  // b of FairingEnergy
  double variation_weight(double wavelength) const;
  double bending_weight(double wavelength) const;

  const CurveMesh& mesh_;
  const std::vector<Spring>& springs_;
  std::vector<FairingEnergy::Part> spring_parts_;
  const FairingEnergy& energy_;
  std::vector<std::pair<int, Vec3>> fixed_dofs_;
  Vec3 origin_;     // the unknowns are relative to it, to save digits
  double density_;  // springs per length
  CurveDofOrdering band_;
  BandCholesky spring_band_, variation_band_, bending_band_, A_;
  Points load_, rhs_;
};

/// The curve through the same nodes whose second derivative is continuous between corners. Slopes at
/// corners and at the ends of an open curve remain. The penalty of FairingEnergy leaves jumps of
/// about 1/μ of the second derivative, and slopes that change by less than 1/μ remove them.
/// O(segments).
HermiteCurve with_continuous_second_derivative(const HermiteCurve& curve);

/// Minimises f over [low, high]: evaluates `samples` + 1 values, then refines by golden-section
/// search. Among equal values, the largest argument wins.
double golden_section_minimum(const std::function<double(double)>& f, double low, double high,
                              int samples);

}  // namespace batten
