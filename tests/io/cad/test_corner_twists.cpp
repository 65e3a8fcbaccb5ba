// SPDX-License-Identifier: MPL-2.0
// Corner twists: at a node where smooth edges meet, normals rotate so that every face has a unique
// twist.
#include <Eigen/Geometry>
#include <cmath>

#include "batten/io/step/tangent_joins.h"
#include "batten/tests/support/catch.h"

using namespace batten;

namespace {

/// Two curves that intersect at a node of a surface with the second fundamental form B: four ends,
/// four corners. Their normals additionally rotate by `torsion`, which is incompatible with one
/// surface.
struct Crossing {
  std::vector<TwistEnd> ends;
  std::vector<TwistCorner> corners;

  Crossing(double angle, const std::vector<double>& torsion) {
    const Vec3 n = Vec3(0.2, -0.3, 1).normalized(), e1 = n.unitOrthogonal(), e2 = n.cross(e1);
    const Vec3 B(0.7, -0.4, 1.1);  // of e1 e1, e1 e2, e2 e2
    for (int k = 0; k < 4; ++k) {
      const double at = (k % 2) * angle + (k / 2) * std::acos(-1.0);
      const Vec3 t = std::cos(at) * e1 + std::sin(at) * e2;
      const double a = t.dot(e1), b = t.dot(e2);
      const Vec3 slope = -(B[0] * a + B[1] * b) * e1 - (B[1] * a + B[2] * b) * e2;
      ends.push_back({t, n, slope + torsion[static_cast<size_t>(k)] * n.cross(t)});
      corners.push_back({{k, (k + 1) % 4}, {1, 1}});
    }
  }

  /// Largest |n₁'·t₂ - n₂'·t₁| after the normals rotate at these rates.
  double mismatch(const std::vector<double>& rates) const {
    double largest = 0;
    for (const TwistCorner& corner : corners) {
      const auto slope = [&](size_t k) {
        const auto e = static_cast<size_t>(corner.ends[k]);
        return Vec3(ends[e].slope + rates[e] * ends[e].normal.cross(ends[e].along));
      };
      const auto along = [&](size_t k) { return ends[static_cast<size_t>(corner.ends[k])].along; };
      largest = std::max(largest, std::abs(slope(0).dot(along(1)) - slope(1).dot(along(0))));
    }
    return largest;
  }
};

}  // namespace

TEST_CASE("normals of a surface with one curvature stay as they are", "[io][step]") {
  for (const double rate :
       matching_twists(Crossing(1.2, {0, 0, 0, 0}).ends, Crossing(1.2, {0, 0, 0, 0}).corners))
    CHECK(std::abs(rate) < 1e-3);
}

TEST_CASE("four faces around a node get one twist each, by rates no larger than the defect",
          "[io][step]") {
  for (const double angle : {0.5, 1.2, 2.4}) {
    const Crossing crossing(angle, {0.8, -0.3, 0.1, 0.5});
    REQUIRE(crossing.mismatch({0, 0, 0, 0}) > 0.1);
    const auto rates = matching_twists(crossing.ends, crossing.corners);
    CHECK(crossing.mismatch(rates) < 1e-3);
    for (const double rate : rates) CHECK(std::abs(rate) < 1);
  }
}

TEST_CASE("the sides of a join may have opposite normals", "[io][step]") {
  Crossing crossing(1.2, {0.8, -0.3, 0.1, 0.5});
  const auto rates = matching_twists(crossing.ends, crossing.corners);
  TwistEnd& turned = crossing.ends[1];
  turned.normal = -turned.normal;
  turned.slope = -turned.slope;
  for (TwistCorner& corner : crossing.corners)
    for (const size_t k : {0, 1})
      if (corner.ends[k] == 1) corner.sign[k] = -1;
  const auto others = matching_twists(crossing.ends, crossing.corners);
  for (size_t k = 0; k < 4; ++k) CHECK(others[k] == Approx(rates[k]).margin(1e-9));
}
