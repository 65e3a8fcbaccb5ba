// Springs against the energy of a curve on one mesh: the inner problem of fairing. Internal.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "batten/fairing/curve_band.h"
#include "batten/fairing/fair_energy.h"
#include "batten/fem/curve.h"

namespace batten {

/// Arc length along a Hermite curve, at its nodes and inside its segments. Keeps a reference.
class NodeArc {
 public:
  explicit NodeArc(const HermiteCurve& curve);
  double total() const { return at_node_.back(); }
  double operator()(double u) const;

 private:
  double inside(CurveMesh::Where at) const;
  const HermiteCurve& curve_;
  std::vector<double> at_node_;
};

/// Draws the curve at one parameter towards a place.
struct Spring {
  CurveMesh::Where at;
  Vec3 goal;
};

/// The least of Σ |X(u_i) - goal_i|² + a FairEnergy, for any wavelength of it. Keeps references.
class SpringBalance {
 public:
  /// `held`: dofs and their values.
  SpringBalance(const CurveMesh& mesh, const std::vector<Spring>& springs, const FairEnergy& energy,
                std::vector<std::pair<int, Vec3>> held);

  /// Dofs of the curve of least energy. Throws NoSolutionError where the wavelength is so large
  /// that the springs are lost in rounding.
  Points solve(double wave);
  /// Trace of the influence matrix of the last solve().
  double freedom() const;
  /// Root mean square by which a curve is off the springs' goals.
  double moved(const Points& dofs) const;
  /// Generalised cross-validation of one wavelength. Each degree of freedom counts more than once
  /// where there are points enough; infinite where points move by more than `most` (root mean
  /// square), or solve() would throw.
  double score(double wave, double most);

  /// The whole matrix at a wavelength, and the springs' load about `origin`, in the mesh's order of
  /// dofs.
  SparseMatrix matrix(double wave) const;
  Points load(const Vec3& origin) const;
  /// Load minus matrix times `dofs`, with more digits than these two have.
  Points imbalance(double wave, const Points& dofs) const;

 private:
  bool try_solve(double wave, Points& q);
  Vec3 at(const Points& dofs, const Spring& spring) const;
  // What multiplies the two parts of the energy.
  double bending_share(double wave) const;  // FairEnergy's b
  double of_change(double wave) const;
  double of_bending(double wave) const;

  const CurveMesh& mesh_;
  const std::vector<Spring>& springs_;
  std::vector<FairEnergy::Part> spring_parts_;
  const FairEnergy& energy_;
  std::vector<std::pair<int, Vec3>> held_;
  Vec3 origin_;     // of the unknowns: far from it digits would be lost
  double density_;  // springs per length
  CurveBand band_;
  BandCholesky spring_band_, change_band_, bending_band_, A_;
  Points load_, right_;
};

/// Where f is smallest over [low, high]: `samples` values, then golden sections. Of equal values
/// the one at the larger place wins.
double minimum_of(const std::function<double(double)>& f, double low, double high, int samples);

}  // namespace batten
