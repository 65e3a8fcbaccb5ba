// SPDX-License-Identifier: MPL-2.0
// Quadrature over a part of a model's surface: selected regions, inside of trims and of a box.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "batten/analysis/shell_section.h"
#include "batten/core/cancellation.h"
#include "batten/core/errors.h"
#include "batten/elements/c1_triangle.h"
#include "batten/elements/reference_triangle.h"
#include "batten/skinning/model/join_edge.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

// Quadrature rule on the part of a triangle inside of a box. It is the given rule if the whole
// triangle is inside; otherwise the triangle is subdivided, down to 1/32 of its size at the border
// of the box.
class BoxQuadrature {
 public:
  BoxQuadrature(const Surface& surface, const Box3& box) : surface_(surface), box_(box) {}

  TriangleRule inside(int triangle, const TriangleRule& whole) const {
    Box3 around;
    for (long p = 0; p < whole.weights.size(); ++p)
      around.extend(surface_.position({triangle, whole.L.row(p).transpose()}));
    for (int i = 0; i < 3; ++i) around.extend(surface_.position({triangle, Vec3::Unit(i)}));
    if (box_.contains(around)) return whole;
    TriangleRule rule;
    constexpr double bulge = 0.1;
    const Vec3 more = Vec3::Constant(bulge * around.diagonal().norm());
    if (!Box3(around.min() - more, around.max() + more).intersects(box_)) return rule;
    std::vector<std::pair<Vec3, double>> points;
    halve(triangle, {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()}, 0, points);
    rule.L.resize(static_cast<long>(points.size()), 3);
    rule.weights.resize(static_cast<long>(points.size()));
    for (long p = 0; p < rule.weights.size(); ++p) {
      rule.L.row(p) = points[p].first;
      rule.weights[p] = points[p].second;
    }
    return rule;
  }

 private:
  static constexpr int kDepth = 5;

  bool holds(int triangle, const Vec3& L) const {
    return box_.contains(surface_.position({triangle, L}));
  }
  void halve(int triangle, const std::array<Vec3, 3>& corners, int depth,
             std::vector<std::pair<Vec3, double>>& points) const {
    const Vec3 middle = (corners[0] + corners[1] + corners[2]) / 3;
    const double weight = std::pow(0.25, depth);
    if (depth == kDepth) {
      if (holds(triangle, middle)) points.emplace_back(middle, weight);
      return;
    }
    int in = 0;
    for (const Vec3& L : corners) in += holds(triangle, L);
    constexpr int sure = 3;  // at lower depths, the box may lie between the corners
    if (depth >= sure && (in == 0 || in == 3) && holds(triangle, middle) == (in == 3)) {
      static const TriangleRule rule = symmetric_triangle_rule(4);
      for (long p = 0; p < rule.weights.size() && in == 3; ++p)
        points.emplace_back(
            corners[0] * rule.L(p, 0) + corners[1] * rule.L(p, 1) + corners[2] * rule.L(p, 2),
            weight * rule.weights[p]);
      return;
    }
    const std::array<Vec3, 3> half = {(corners[1] + corners[2]) / 2, (corners[2] + corners[0]) / 2,
                                      (corners[0] + corners[1]) / 2};
    halve(triangle, half, depth + 1, points);
    for (int i = 0; i < 3; ++i)
      halve(triangle, {corners[i], half[(i + 2) % 3], half[(i + 1) % 3]}, depth + 1, points);
  }

  const Surface& surface_;
  const Box3& box_;
};

// Quadrature point of a part, with the shape functions of its triangle.
struct PartPoint {
  Location where;
  Vec3 x, area;  // position, and area vector dA n
  const std::array<int, 12>& dofs;
  Vec12 functions;
  double weight;                        // dA = weight |x_u × x_v|
  Vec3 x_u, x_v;                        // tangents
  Eigen::Matrix<double, 12, 2> slopes;  // derivatives of the functions with respect to u and v

  ConstraintEntries entries() const {
    ConstraintEntries row;
    for (int m = 0; m < 12; ++m) row.push_back({dofs[m], functions[m]});
    return row;
  }
};

// Calls visit(PartPoint) at the quadrature points of a part, inside of trims. Uncut triangles use
// the rule `whole`, cut ones the trim's rule of the given degree. Throws InputError if a region is
// out of range.
template <class Visit>
void for_each_part_point(const ModelLayout& model, const Surface& surface, const ShellPart& part,
                         const TabulatedRule& whole, int degree, const Visit& visit) {
  for (const int r : part.regions)
    if (r < 0 || r >= model.region_count())
      throw InputError("found face index " + std::to_string(r) + ", expected 0 to " +
                       std::to_string(model.region_count() - 1));
  const Trim* trim = surface.trim().get();
  for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
    poll_every<256>(t);
    if (!part.regions.empty() && std::find(part.regions.begin(), part.regions.end(),
                                           model.region_of(t)) == part.regions.end())
      continue;
    if (trim && trim->side(t) == Trim::Side::Outside) continue;
    const bool cut = trim && trim->side(t) == Trim::Side::Cut;
    std::optional<TabulatedRule> own;
    if (cut) own.emplace(surface.kind(), trim->rule(t, degree));
    if (part.box && !cut)
      own.emplace(surface.kind(), BoxQuadrature(surface, *part.box).inside(t, whole.rule));
    const TabulatedRule& points = own ? *own : whole;
    if (points.rule.weights.size() == 0) continue;
    const C1Triangle triangle(surface.kind(), surface.mesh().shape(t));
    const DerivativeMap map(triangle.shape());
    const Mat12 P = triangle.pull_back_matrix();
    const Eigen::Matrix<double, 12, 3> X = triangle.pull_back(surface.triangle_dofs(t));
    const std::array<int, 12> dofs = surface.dof_map().triangle(surface.mesh(), t);
    for (long p = 0; p < points.rule.weights.size(); ++p) {
      const ReferenceTabulation& f = points.functions[p];
      const Vec3 x = X.transpose().lazyProduct(f.col(0));
      if (part.box && cut && !part.box->contains(x)) continue;
      const Eigen::Matrix<double, 3, 2> d =
          X.transpose().lazyProduct(f.middleCols<2>(1)).eval() * map.first.transpose();
      const double weight = points.rule.weights[p] * triangle.shape().area;
      visit(
          PartPoint{{t, points.rule.L.row(p).transpose()},
                    x,
                    weight * d.col(0).cross(d.col(1)),
                    dofs,
                    P.transpose().lazyProduct(f.col(0)),
                    weight,
                    d.col(0),
                    d.col(1),
                    P.transpose().lazyProduct(f.middleCols<2>(1)).eval() * map.first.transpose()});
    }
  }
}

}  // namespace batten
