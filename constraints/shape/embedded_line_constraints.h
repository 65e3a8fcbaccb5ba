// Rows that hold a surface on curves that run across its elements.
//
// The grid ignores the line. At parameters t_k the surface goes through the curve, in between it
// nearly does: the gap falls with about h³. Twelve coefficients a row, the same for x, y and z; the
// surface stays C1 across the line, its Jacobian regular wherever c(t) bends (pinning a smooth line
// to bent element edges makes it singular, docs/theory/domains.md).
//
//   point rows          Σ_m N_m(c(t_k)) q_m = X(t_k)                       uncoupled
//   slope rows          ∫ φ_k (∂x/∂ν - g) ds = 0                           uncoupled
//   normal rows         ∫ φ_k ∂x/∂ν · n ds = 0                             coupled
//
// with ν the unit normal of c (to its left), φ_k hat functions along c over neighbouring points.
// Slopes at points instead of averages would be wrong for stress by h, these by h³.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/fem/hermite_curve.h"
#include "batten/fem/triangle_locator.h"

namespace batten {

struct PointSpacing {
  /// Largest step over the local size h = √(2 area of the triangle), or the edge that the line runs
  /// along where that is longer, measured along c. Below 0.35 the rows hold the surface so tightly
  /// that it waves, above 1 it dimples.
  double step = 0.7;
  /// A line's open ends are where the gap is largest: this many further points at half steps.
  int extra_end_points = 0;
};

/// Parameters of the points of one line: evenly in ∫ ds/h(c(t)) between its ends, both among them
/// (of a closed line the start), and between the parameters of `required`, which are among them too.
/// They ascend. `pcurve`: c.
std::vector<double> embedded_point_parameters(const ParametricMesh& mesh,
                                              const TriangleLocator& locator,
                                              const HermiteCurve& pcurve,
                                              const PointSpacing& spacing = {},
                                              std::vector<double> required = {});

/// Adds rows of embedded lines to a set. Keeps references to all three.
class EmbeddedLineConstraints {
 public:
  /// The set's dof count must be the mesh's. Throws InputError otherwise.
  EmbeddedLineConstraints(const ParametricMesh& mesh, TriangleElement kind,
                          const TriangleLocator& locator, ConstraintSet& set);

  /// x(c(t)) = X(t) at the parameters. Throws InputError where c(t) is not on the mesh.
  void points(const std::string& name, const HermiteCurve& pcurve, const HermiteCurve& curve,
              const std::vector<double>& parameters);
  /// The slope across the line is g(t) on the average of each hat over `parameters` (of a closed
  /// line, the last hat reaches over the start).
  void slope(const std::string& name, const HermiteCurve& pcurve,
             const std::vector<double>& parameters, const std::function<Vec3(double t)>& g);
  /// The normal is n(t) on the same averages, as far as the line itself lets it: the line's own
  /// tangent should be at right angles to n.
  void normal(const std::string& name, const HermiteCurve& pcurve,
              const std::vector<double>& parameters, const std::function<Vec3(double t)>& n);

 private:
  using Visit = std::function<void(double t, double weight, const Vec2& nu, const Location& where)>;
  // Gauss points under each hat: weight = φ_k ds over the hat's length.
  void integrate_hats(const HermiteCurve& pcurve, const std::vector<double>& parameters,
                      const std::function<void(size_t hat)>& begin, const Visit& visit,
                      const std::function<void()>& end) const;
  Location on_mesh(const std::string& name, const Vec2& uv) const;

  const ParametricMesh& mesh_;
  TriangleElement kind_;
  const TriangleLocator& locator_;
  ConstraintSet& set_;
  DofMap dofs_;
};

}  // namespace batten
