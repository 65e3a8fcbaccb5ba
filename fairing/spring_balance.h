// Springs against bending on one mesh: the inner problem of fairing. Internal.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "batten/fairing/curve_band.h"
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

/// The springs of all points that belong to a node, as one.
struct Springs {
  std::vector<double> weight;  ///< number of points at each node
  std::vector<Vec3> goal;      ///< their mean, moved along the curve to the node's parameter
  double scatter = 0;          ///< Σ |point - mean of its node|²
};

/// The balance of springs against λ ∫ ease |X_uu|² + alpha |X_u|² du, for any λ; `ease` of each
/// segment, or none for 1. Keeps references.
class SpringBalance {
 public:
  SpringBalance(const CurveMesh& mesh, const Springs& springs, double alpha, int points,
                const std::vector<std::pair<int, Vec3>>& held,
                std::vector<HermiteSegment::Linear> ease = {})
      : mesh_(mesh),
        springs_(springs),
        alpha_(alpha),
        points_(points),
        held_(held),
        ease_(std::move(ease)),
        band_(mesh) {}

  /// Dofs of the curve of least energy at λ. Throws NoSolutionError.
  Points solve(double lambda);
  /// Trace of the influence matrix of the last solve().
  double freedom() const;
  /// Root mean square by which the points move at λ.
  double moved(double lambda);
  /// Generalised cross-validation at λ. Each degree of freedom counts more than once where there
  /// are points enough; infinite where points move by more than `most` (root mean square).
  double score(double lambda, double most);

 private:
  // Sum of the squares by which the points are off a solution.
  double rest_of(const Points& q) const;

  const CurveMesh& mesh_;
  const Springs& springs_;
  double alpha_;
  int points_;
  const std::vector<std::pair<int, Vec3>>& held_;
  std::vector<HermiteSegment::Linear> ease_;
  CurveBand band_;
  BandCholesky A_;
  Points right_;
};

/// Where f is smallest over [low, high]: `samples` values, then golden sections. Of equal values
/// the one at the larger place wins.
double minimum_of(const std::function<double(double)>& f, double low, double high, int samples);

}  // namespace batten
