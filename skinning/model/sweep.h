// A surface that carries one curve into another one along two rails: a sweep. Internal.
#pragma once

#include <functional>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Sections c0(u) and c1(u) at the ends of rails r0(v) and r1(v), u and v in [0, 1]: c0 goes from
/// r0(0) to r1(0), c1 from r0(1) to r1(1). A rail may be a point. With the chord of the rails
///
///     d(v) = r1(v) - r0(v),  l = |d|,  e = d / l
///
/// and P(v), the rotation that takes e(0) to e(v) without twist (parallel transport), the sections
/// are compared in the chord's frame
///
///     a0(u) = (c0(u) - r0(0)) / l(0)
///     a1(u) = Rot(e(0), -φ) P(1)ᵀ (c1(u) - r0(1)) / l(1)
///
/// where the twist φ takes a0 nearest to a1. The surface meets all four curves:
///
///     S(u, v) = r0(v) + l(v) P(v) Rot(e(0), v φ) [(1 - v) a0(u) + v a1(u)]
///
/// It is exact for planes, cylinders, cones, extrusions, ruled surfaces, helicoids, surfaces of
/// translation, and surfaces of revolution between parallels and meridians.
///
/// A twist of almost 180° has no sense of rotation. There φ fades to 0, so that sections that bulge
/// to opposite sides pass through a straight one.
class Sweep {
 public:
  /// A place of a curve and its derivative by the curve's parameter.
  struct Place {
    Vec3 x, slope;
  };
  using Curve = std::function<Place(double)>;
  /// `most_twist`: φ fades between this angle and 180°, radians.
  Sweep(const Curve& c0, const Curve& c1, const Curve& r0, const Curve& r1, double most_twist);

  /// Root mean square of |a1 - a0|: how much the shape of the section changes on its way, relative
  /// to the chord. Infinite where the chord vanishes, so that there is no sweep.
  double mismatch() const { return mismatch_; }

  /// Value and derivatives at (u, v).
  struct Jet {
    Vec3 x, by_u, by_v;
  };
  /// `c0`, `c1`: the sections at u; `r0`, `r1`: the rails at v. A little beyond [0, 1] is allowed.
  Jet at(double v, const Place& c0, const Place& c1, const Place& r0, const Place& r1) const;

 private:
  Mat3 transport(double v, const Vec3& e) const;

  std::vector<Vec3> chords_;       // e at equal steps of v
  std::vector<Mat3> transported_;  // P there
  Vec3 origin0_ = Vec3::Zero(), origin1_ = Vec3::Zero();
  double length0_ = 1, length1_ = 1, twist_ = 0, mismatch_ = 0;
  Mat3 to_first_ = Mat3::Identity();  // Rot(e(0), -φ) P(1)ᵀ
};

}  // namespace batten
