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
///     a1(u) = P(1)ᵀ (c1(u) - r0(1)) / l(1)
///
/// where the twist φ about e(0) takes a0 nearest to a1. Their parts along e(0) are interpolated
/// linearly, those across it by spherical linear interpolation over θ, the first quarter turn of φ;
/// the rest ψ = φ - θ is a rotation at constant speed. The surface meets all four curves:
///
///     S(u, v) = r0(v) + l(v) P(v) Rot(e(0), v ψ) [w0 a0 + w1 Rot(e(0), -ψ) a1]
///     w0, w1  = 1 - v, v along e(0);  sin((1 - v) θ) / sin θ, sin(v θ) / sin θ across it
///
/// It is exact for planes, cylinders, cones, extrusions, ruled surfaces, helicoids, surfaces of
/// translation, and surfaces of revolution between parallels and meridians, and within 1 % of
/// ellipsoids between sections at right angles.
///
/// A twist of almost 180° has no sense of rotation. From 130° on φ fades to 0, so that sections that
/// bulge to opposite sides pass through a straight one. Nor has that of a section that is nearly
/// straight, less than a quarter to a twentieth of the other one's bulge: it fades there, too.
class Sweep {
 public:
  /// A place of a curve and its derivative by the curve's parameter.
  struct PointAndSlope {
    Vec3 x, slope;
  };
  using Curve = std::function<PointAndSlope(double)>;
  Sweep(const Curve& c0, const Curve& c1, const Curve& r0, const Curve& r1);

  /// Root mean square of |a1 - a0|: how much the shape of the section changes on its way, relative
  /// to the chord. Infinite where the chord vanishes, so that there is no sweep.
  double mismatch() const { return mismatch_; }

  /// Value and derivatives at (u, v).
  struct Jet {
    Vec3 x, by_u, by_v;
  };
  /// `c0`, `c1`: the sections at u; `r0`, `r1`: the rails at v. A little beyond [0, 1] is allowed.
  Jet at(double v, const PointAndSlope& c0, const PointAndSlope& c1, const PointAndSlope& r0,
         const PointAndSlope& r1) const;

 private:
  // Weights of the sections across the chord at v, and their derivatives.
  struct Weights {
    double first, last, first_v, last_v;
  };
  Weights across(double v) const;
  Mat3 transport(double v, const Vec3& e) const;

  std::vector<Vec3> chords_;       // e at equal steps of v
  std::vector<Mat3> transported_;  // P there
  Vec3 origin0_ = Vec3::Zero(), origin1_ = Vec3::Zero();
  double length0_ = 1, length1_ = 1, mismatch_ = 0;
  double slerp_angle_ = 0, twist_ = 0;    // θ, ψ
  Mat3 to_first_ = Mat3::Identity();  // Rot(e(0), -ψ) P(1)ᵀ
};

}  // namespace batten
