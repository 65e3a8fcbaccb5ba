// The least-squares problem of the curve fit, on one mesh. Internal.
#pragma once

#include <algorithm>
#include <initializer_list>
#include <optional>
#include <vector>

#include "batten/core/solvers/band_cholesky.h"
#include "batten/core/eigen.h"
#include "batten/core/containers.h"
#include "batten/fem/curves/curve_mesh.h"

namespace batten {

struct FitPoint {
  Vec3 x;
  double t = 0;  ///< its parameter; outside of the mesh: only seen as the end of a gap
  bool fixed_parameter = false;  ///< t stays: corners, ends
  double gap = 0;                ///< distance from the point before it
  double sagitta = 0;            ///< sagitta_bound() of that gap
};

/// What a node may not change: its position, a slope.
struct NodeConstraint {
  double u;
  std::optional<Vec3> position, slope_in, slope_out;
  bool removable = false;  ///< with its node
};

/// Points with their parameters, a mesh, what is held on it; and the curve on that mesh that is
/// nearest to the points. What is below is set from outside; then set_mesh(), then iterate().
class CurveFitProblem {
 public:
  std::vector<FitPoint> points;                  ///< t ascending
  std::vector<NodeConstraint> node_constraints;  ///< u ascending
  bool closed = false;            ///< the mesh; the gap from the last point to the first counts too
  bool fixed_parameters = false;  ///< parameters stay
  double tolerance = 0;

  CurveMesh mesh;
  Points dofs;                         ///< empty before the first solve
  std::vector<double> segment_errors;  ///< error of each segment after the last iterate()

  void set_mesh(std::vector<double> knots, const std::vector<int>& corners);

  /// Solves and moves the parameters to the nearest points, until all is within the tolerance, or
  /// it does not get there in so many rounds; the best state stays.
  void iterate(int max_rounds);
  double worst() const { return *std::max_element(segment_errors.begin(), segment_errors.end()); }
  bool done() const { return worst() <= tolerance; }

  int count() const { return isize(points); }
  double period() const { return mesh.end() - mesh.start(); }
  Vec3 dof(int d) const { return dofs.row(d).transpose(); }
  /// Index of the first point that is not before u, and of the first behind it.
  int first_from(double u) const;
  int first_behind(double u) const;
  /// Index of the first point of each segment, and of the one behind the last segment.
  std::vector<int> first_points() const;

 private:
  // A segment over s in [0, 1]: x = c0 + s (c1 + s (c2 + s c3)).
  struct Cubic {
    Vec3 c0, c1, c2, c3;
    Vec3 position(double s) const { return c0 + s * (c1 + s * (c2 + s * c3)); }
    Vec3 first(double s) const { return c1 + s * (2 * c2 + 3 * s * c3); }
    Vec3 second(double s) const { return 2 * c2 + 6 * s * c3; }
  };

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

  std::vector<Cubic> cubics_;
  std::vector<double> moves_;  // of the parameters, in the last round
  BandCholesky A_;
  Points rhs_;
};

}  // namespace batten
