// SPDX-License-Identifier: MPL-2.0
// Least-squares fit of a curve to points on one given mesh, with moving point parameters.
#pragma once

#include <algorithm>
#include <initializer_list>
#include <optional>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/core/solvers/band_cholesky.h"
#include "batten/fem/curves/cubic.h"
#include "batten/fem/curves/curve_mesh.h"

namespace batten {
/// A point to be fitted.

struct FitPoint {
  Vec3 x;
  double t = 0;  ///< curve parameter; outside the mesh: used only as the end of a gap
  bool fixed_parameter = false;  ///< t does not move: corners, ends
  double gap = 0;                ///< distance from the previous point
  double sagitta = 0;            ///< largest permitted bulge in that gap, see sagitta_bound()
};

/// Fixed position and slopes of the node at parameter u; unset values are free.
struct NodeConstraint {
  double u;
  std::optional<Vec3> position, slope_in, slope_out;
  bool removable = false;  ///< may be removed together with its node
};

/// The least-squares curve through points on a given mesh, with node constraints.
///
/// Set the public members, then call set_mesh(), then iterate().
class CurveFitProblem {
 public:
  std::vector<FitPoint> points;                  ///< points in order of ascending t
  std::vector<NodeConstraint> node_constraints;  ///< constraints in order of ascending u
  /// Closed mesh: the gap from the last point to the first counts too.
  bool closed = false;
  bool fixed_parameters = false;  ///< no point parameter moves
  double tolerance = 0;

  CurveMesh mesh;
  Points dofs;                         ///< solution; empty before the first solve
  std::vector<double> segment_errors;  ///< maximum error per segment after the last iterate()

  /// Sets the mesh and discards the dofs. `corners`: node indices.
  void set_mesh(std::vector<double> knots, const std::vector<int>& corners);

  /// Alternates between solving and moving the parameters to the foot points.
  ///
  /// It stops when all errors are within the tolerance, or when they cannot get there in
  /// `max_rounds`. Keeps the best state.
  void iterate(int max_rounds);
  double worst() const { return *std::max_element(segment_errors.begin(), segment_errors.end()); }
  bool done() const { return worst() <= tolerance; }

  int count() const { return isize(points); }
  double period() const { return mesh.end() - mesh.start(); }
  Vec3 dof(int d) const { return dofs.row(d).transpose(); }
  /// Index of the first point with t ≥ u, and of the first with t > u.
  int first_from(double u) const;
  int first_behind(double u) const;
  /// Index of the first point of each segment, then one past the last point of the last segment.
  std::vector<int> first_points() const;

 private:
  void solve();
  void make_cubics();
  void move_parameters();
  void extrapolate_parameters();
  double move(int i, double change);
  void measure();
  int measure_gap(int i, std::initializer_list<int> places, int s);
  double local_parameter(double u, int segment) const {
    return (u - mesh.parameters()[segment]) / mesh.length(segment);
  }

  std::vector<PowerCubic<Vec3>> cubics_;  // of the segments, over s in [0, 1]
  std::vector<double> moves_;             // change of each parameter in the last round
  BandCholesky A_;
  Points rhs_;
};

}  // namespace batten
