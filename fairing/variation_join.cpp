#include <cmath>

#include "batten/core/errors.h"
#include "batten/fairing/variation_geometry.h"
#include "batten/fairing/variation_terms.h"

namespace batten {
namespace {

// The forms on both sides of a point, and what the jumps of curvature and of the tangent plane
// count there.
template <class Point>
struct Sides {
  EdgeSecondForm forms[2];
  double root, jump;    // of curvature
  double stiff, angle;  // of the tangent plane

  Sides(const Point& point, const TriangleDofs* q, const std::array<double, 2>& areas,
        double jumps) {
    double thickness = 0, speed = 0;
    for (int s = 0; s < 2; ++s) {
      const auto side = static_cast<size_t>(s);
      const LocalJet jet = q[s].transpose().lazyProduct(point.N[side]);
      forms[s] = edge_second_form(jet, point.direction[side]);
      // Of the third beside the line, if the triangle is equilateral.
      constexpr double altitude = 0.439;
      thickness += altitude / 2 * std::sqrt(areas[side] * jet.col(0).cross(jet.col(1)).norm());
      speed += 0.5 * (jet.leftCols<2>() * point.direction[side]).norm();
    }
    root = std::sqrt(jumps * point.weight * speed / thickness);
    jump = forms[0].across - point.sign * forms[1].across;
    constexpr double first = 10;  // the tangent plane comes before the curvature
    stiff = first * root / thickness;
    angle = forms[0].n.dot(forms[1].Y2);
    if (!point.curvature) root = 0;
    if (!point.tangent) stiff = 0;
  }
};

std::array<double, 2> areas_of(const Surface& surface, const std::array<int, 2>& triangle) {
  return {surface.mesh().shape(triangle[0]).area, surface.mesh().shape(triangle[1]).area};
}

}  // namespace

void CurvatureVariationTerms::add_joins(const Surface& start,
                                        const std::vector<JoinPoint>& points) {
  for (const JoinPoint& point : points) {
    Join& added = joins_.emplace_back();
    added.direction = point.direction;
    added.weight = point.weight;
    added.curvature = point.curvature;
    added.tangent = point.tangent;
    Vec3 normal[2];
    for (size_t s = 0; s < 2; ++s) {
      const Location& at = point.at[s];
      added.triangle[s] = at.triangle;
      const Tabulation N = C1Triangle(start.kind(), start.mesh().shape(at.triangle)).evaluate(at.L);
      added.N[s] = N.middleCols<5>(kU);
      normal[s] = start.jet(at).normal();
    }
    added.sign = normal[0].dot(normal[1]) < 0 ? -1 : 1;
  }
}

std::array<int, kJoinDofs> CurvatureVariationTerms::join_dofs(const Surface& surface, int j) const {
  std::array<int, kJoinDofs> dofs;
  auto next = dofs.begin();
  for (const int t : joins_[j].triangle) {
    const auto own = surface.dof_map().triangle(surface.mesh(), t);
    next = std::copy(own.begin(), own.end(), next);
  }
  return dofs;
}

double CurvatureVariationTerms::join_value(const Surface& surface, const Join& join) const {
  const TriangleDofs q[2] = {surface.triangle_dofs(join.triangle[0]),
                             surface.triangle_dofs(join.triangle[1])};
  const Sides sides(join, q, areas_of(surface, join.triangle), jumps_);
  return std::pow(sides.root * sides.jump, 2) + std::pow(sides.stiff * sides.angle, 2);
}

void CurvatureVariationTerms::join(const Surface& surface, int j, JoinResiduals& rows) const {
  const Join& join = joins_[j];
  const TriangleDofs q[2] = {surface.triangle_dofs(join.triangle[0]),
                             surface.triangle_dofs(join.triangle[1])};
  const Sides sides(join, q, areas_of(surface, join.triangle), jumps_);
  for (int s = 0; s < 2; ++s) {
    const EdgeSecondForm& f = sides.forms[s];
    const auto& N = join.N[static_cast<size_t>(s)];
    const double root = sides.root * (s == 0 ? 1 : -join.sign);
    // The second side turns to the first one's normal, or that normal turns.
    const double tilt = s == 1 ? sides.stiff : -sides.stiff * sides.forms[1].Y2.dot(f.Y2);
    const Vec3 turn = -2 * (f.twist * f.Y1 + f.across * f.Y2);
    const Vec3& n = sides.forms[0].n;
    const Vec12 Y2 = N.leftCols<2>() * f.M.row(1).transpose();
    const Vec12 Y22 = N.rightCols<3>() * mixed_derivative_weights(f.M, 1, 1) -
                      N.leftCols<2>() * (f.M.transpose() * f.gamma22);
    for (int c = 0; c < 3; ++c)
      for (int a = 0; a < 12; ++a) {
        double* column = rows.J[kJoinDofs * c + 12 * s + a];
        column[0] = root * (f.n[c] * Y22[a] + turn[c] * Y2[a]);
        column[1] = tilt * n[c] * Y2[a];
      }
  }
  rows.count = 2;
  rows.r[0] = sides.root * sides.jump;
  rows.r[1] = sides.stiff * sides.angle;
}

}  // namespace batten
