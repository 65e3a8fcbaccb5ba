#include <cmath>

#include "batten/core/errors.h"
#include "batten/fairing/variation_geometry.h"
#include "batten/fairing/variation_terms.h"

namespace batten {
namespace {

// The forms on both sides of a point, and what the jump of curvature counts there.
template <class Point>
struct Sides {
  LineForms forms[2];
  double root, jump;

  Sides(const Point& point, const TriangleDofs* q, const std::array<double, 2>& areas,
        double jumps) {
    double thickness = 0, speed = 0;
    for (int s = 0; s < 2; ++s) {
      const auto side = static_cast<size_t>(s);
      const LocalJet jet = q[s].transpose().lazyProduct(point.N[side]);
      forms[s] = line_forms(jet, point.way[side]);
      // Of the third beside the line, if the triangle is equilateral.
      constexpr double altitude = 0.439;
      thickness += altitude / 2 * std::sqrt(areas[side] * jet.col(0).cross(jet.col(1)).norm());
      speed += 0.5 * (jet.leftCols<2>() * point.way[side]).norm();
    }
    root = std::sqrt(jumps * point.weight * speed / thickness);
    jump = forms[0].across - point.sign * forms[1].across;
  }
};

std::array<double, 2> areas_of(const Surface& surface, const std::array<int, 2>& triangle) {
  return {surface.mesh().shape(triangle[0]).area, surface.mesh().shape(triangle[1]).area};
}

}  // namespace

void VariationTerms::add_joins(const Surface& start, const std::vector<JoinPoint>& points) {
  for (const JoinPoint& point : points) {
    JumpPoint added;
    added.way = point.way;
    added.weight = point.weight;
    std::array<int, 2> triangle;
    Vec3 normal[2];
    for (size_t s = 0; s < 2; ++s) {
      const Location& at = point.at[s];
      triangle[s] = at.triangle;
      const Tabulation N = C1Triangle(start.kind(), start.mesh().shape(at.triangle)).evaluate(at.L);
      added.N[s] = N.middleCols<5>(kU);
      normal[s] = start.jet(at).normal();
    }
    added.sign = normal[0].dot(normal[1]) < 0 ? -1 : 1;
    if (joins_.empty() || joins_.back().triangle != triangle || joins_.back().points.size() > 1)
      joins_.push_back({triangle, {}});
    joins_.back().points.push_back(std::move(added));
  }
}

std::array<int, kJoinDofs> VariationTerms::join_dofs(const Surface& surface, int j) const {
  std::array<int, kJoinDofs> dofs;
  auto next = dofs.begin();
  for (const int t : joins_[j].triangle) {
    const auto own = surface.dof_map().triangle(surface.mesh(), t);
    next = std::copy(own.begin(), own.end(), next);
  }
  return dofs;
}

double VariationTerms::join_value(const Surface& surface, const Join& join) const {
  const TriangleDofs q[2] = {surface.triangle_dofs(join.triangle[0]),
                             surface.triangle_dofs(join.triangle[1])};
  double sum = 0;
  for (const JumpPoint& point : join.points) {
    const Sides sides(point, q, areas_of(surface, join.triangle), jumps_);
    sum += std::pow(sides.root * sides.jump, 2);
  }
  return sum;
}

void VariationTerms::join(const Surface& surface, int j, JoinRows& rows) const {
  const Join& join = joins_[j];
  const TriangleDofs q[2] = {surface.triangle_dofs(join.triangle[0]),
                             surface.triangle_dofs(join.triangle[1])};
  rows.count = 0;
  for (const JumpPoint& point : join.points) {
    const Sides sides(point, q, areas_of(surface, join.triangle), jumps_);
    for (int s = 0; s < 2; ++s) {
      const LineForms& f = sides.forms[s];
      const auto& N = point.N[static_cast<size_t>(s)];
      const double root = sides.root * (s == 0 ? 1 : -point.sign);
      const Vec12 Y2 = N.leftCols<2>() * f.M.row(1).transpose();
      const Vec12 Y22 =
          N.rightCols<3>() * mixed(f.M, 1, 1) - N.leftCols<2>() * (f.M.transpose() * f.gamma22);
      const Vec3 turn = -2 * (f.twist * f.Y1 + f.across * f.Y2);
      for (int c = 0; c < 3; ++c)
        for (int a = 0; a < 12; ++a)
          rows.J[kJoinDofs * c + 12 * s + a][rows.count] =
              root * (f.n[c] * Y22[a] + turn[c] * Y2[a]);
    }
    rows.r[rows.count++] = sides.root * sides.jump;
  }
}

}  // namespace batten
