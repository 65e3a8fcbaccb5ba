// Springs against the energy of a curve on one mesh: the inner problem of fairing. Internal.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "batten/fairing/curves/curve_dof_ordering.h"
#include "batten/fairing/curves/fairing_energy.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// Arc length along a Hermite curve, at its nodes and inside its segments. Keeps a reference.
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

/// Draws the curve at one parameter towards a place.
struct Spring {
  CurveMesh::SegmentPoint at;
  Vec3 goal;
};

/// The least of Σ |X(u_i) - goal_i|² + a FairingEnergy, for any wavelength of it. Keeps references.
class PenalisedLeastSquares {
 public:
  /// `fixed_dofs`: dofs and their values.
  PenalisedLeastSquares(const CurveMesh& mesh, const std::vector<Spring>& springs,
                        const FairingEnergy& energy, std::vector<std::pair<int, Vec3>> fixed_dofs);

  /// Dofs of the curve of least energy. Throws NoSolutionError where the wavelength is so large
  /// that the springs are lost in rounding.
  Points solve(double wavelength);
  /// Trace of the influence matrix of the last solve().
  double effective_dofs() const;
  /// Root mean square by which a curve is off the springs' goals.
  double rms_residual(const Points& dofs) const;
  /// Generalised cross-validation of one wavelength. Each degree of freedom counts more than once
  /// where there are points enough; infinite where points move by more than `most` (root mean
  /// square), or solve() would throw.
  double gcv_score(double wavelength, double most);

  /// The whole matrix at a wavelength, and the springs' load about `origin`, in the mesh's order of
  /// dofs.
  SparseMatrix matrix(double wavelength) const;
  Points load(const Vec3& origin) const;
  /// Load minus matrix times `dofs`, with more digits than these two have.
  Points residual(double wavelength, const Points& dofs) const;

 private:
  bool try_solve(double wavelength, Points& q);
  Vec3 at(const Points& dofs, const Spring& spring) const;
  // What multiplies the two parts of the energy.
  double bending_fraction(double wavelength) const;  // FairingEnergy's b
  double variation_weight(double wavelength) const;
  double bending_weight(double wavelength) const;

  const CurveMesh& mesh_;
  const std::vector<Spring>& springs_;
  std::vector<FairingEnergy::Part> spring_parts_;
  const FairingEnergy& energy_;
  std::vector<std::pair<int, Vec3>> fixed_dofs_;
  Vec3 origin_;     // of the unknowns: far from it digits would be lost
  double density_;  // springs per length
  CurveDofOrdering band_;
  BandCholesky spring_band_, variation_band_, bending_band_, A_;
  Points load_, rhs_;
};

/// Where f is smallest over [low, high]: `samples` values, then golden sections. Of equal values
/// the one at the larger place wins.
double golden_section_minimum(const std::function<double(double)>& f, double low, double high,
                              int samples);

}  // namespace batten
