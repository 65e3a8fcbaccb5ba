// SPDX-License-Identifier: MPL-2.0
// Rest shape of a region from its boundary curves: blended sweeps between opposite sides.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "batten/fem/curves/hermite_curve.h"
#include "batten/fem/surface.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/layout/region_layout.h"
#include "batten/skinning/model/sweep.h"

namespace batten {

// A side of a region: boundary curves from one corner to the next, parametrised by arc length.

/// A chain of curves with their pcurves in (u, v), as a function of the fraction f of its arc
/// length, from 0 at its start to 1 at its end.
class BoundarySide {
 public:
  struct Point {
    Vec3 x, x_f;    ///< position, and its derivative with respect to f; model units
    Vec2 uv, uv_f;  ///< pcurve, and its derivative with respect to f
  };

  /// Appends a curve. `pcurve` has the parameters of `curve`, z = 0.
  void add(HermiteCurve curve, HermiteCurve pcurve);

  double length() const { return lengths_.empty() ? 0 : lengths_.back(); }  ///< model units
  /// Point at a fraction f of the length. Beyond [0, 1] the side continues straight. O(log
  /// segments).
  Point at(double f) const;

 private:
  Point on(double length) const;

  // A part of a segment. Arc length is tabulated at its ends.
  struct Part {
    int piece;
    double from, to;  // parameters of the curve
    Vec3 c[4];        // x = c0 + c1 t + c2 t² + c3 t³, t from 0 to 1
    double rates[2];  // dt/ds at both ends, times the length of the part

    Vec3 position(double t) const { return c[0] + t * (c[1] + t * (c[2] + t * c[3])); }
    Vec3 slope(double t) const { return c[1] + t * (2 * c[2] + 3 * t * c[3]); }
    double length_to(double t) const;
  };
  std::vector<HermiteCurve> pcurves_;  // one per curve
  std::vector<Part> parts_;
  std::vector<double> lengths_;  // arc length at the end of each part
};

/// Blended sweeps between the sides of a region with two, three or four corners, over its flat
/// domain. Sides that meet within the corner angle count as one side.
///
///     four sides   both pairs are swept, and the results are blended
///     three sides  one rail degenerates to a corner: three sweeps, blended
///     two sides    both rails degenerate to corners: one sweep
///
/// Weights are 1 / (ρ² + 1e-6), where ρ is the mismatch of the pair (sweep.h): the pair with more
/// similar ends dominates, and the weights are continuous.
///
/// Each sweep has its own parameters (s, t). The map from these to (u, v) is the bilinearly blended
/// Coons patch of the sides' pcurves, so that the surface contains every boundary curve with its
/// own parametrisation. If (u, v) are a projection to a plane, over which the sweeps are a graph,
/// the map is that projection of the sweeps.
///
/// Around a corner that is a degenerate rail, the sweep's lines of constant t fan out. With the
/// Coons patch, (s, t) are reparametrised so that the fan is linear in (u, v), and the surface is
/// C1 there. The three sweeps of a triangle have different parametrisations of nearly the same
/// surface. Their weighted mean is therefore projected onto each, and the projections are averaged.
class BoundarySweep {
 public:
  /// Builds the sweeps. Returns nullopt if the region has another number of sides, if its boundary
  /// is planar within 1e-4 of the size, or if no pair can be swept. `region` must outlive the
  /// result.
  static std::optional<BoundarySweep> of(const RegionLayout& region);

  /// True if the region has five or more sides that are not coplanar: no side has an opposite one.
  static bool has_many_sides(const RegionLayout& region);

  /// The smallest Sweep::mismatch() of all sweeps: how little two opposite sides differ in shape.
  double mismatch() const;
  /// Position and gradient at a point of the domain; points slightly outside are allowed.
  FirstOrderJet at(const Vec2& uv) const;
  /// Interpolating dofs on the region's mesh; nullopt if the surface would be inverted in the
  /// domain.
  std::optional<Points> dofs() const;

 private:
  // An edge of the square of (s, t): a side, forwards or backwards, or a corner (side -1).
  struct Edge {
    int side = -1;
    bool backwards = false;
    Vec3 x = Vec3::Zero();
    Vec2 uv = Vec2::Zero();
  };
  struct Edges {
    BoundarySide::Point bottom, top, left, right;  // bottom and top at s, left and right at t
  };
  // The curves that leave a corner that is a degenerate rail: derivatives of bottom and top with
  // respect to s, directed away from it.
  struct Fan {
    Vec3 bottom, top;
    double angle;
    double warped(double t) const;        // reparametrised t for which directions are linear
    double length_scale(double t) const;  // factor of s for which lengths are linear
  };
  // Sides around the square, and the sweeps between them.
  struct Patch {
    Edge bottom, top, left, right;
    std::optional<Fan> fan_left, fan_right;
    std::vector<Vec2> at, uv;  // samples of the map
    std::optional<Sweep> along_t, along_s;
    double weight_t = 0, weight_s = 0;
  };
  struct PatchPoint {
    Vec2 st, uv;
    Mat2 jacobian;  // derivative of uv with respect to (s, t)
    Edges edges;
  };
  using Jet = Sweep::Jet;  // by_u: derivative by s; by_v: by t
  // uv = linear x + offset, a projection to a plane.
  struct Projection {
    Eigen::Matrix<double, 2, 3> linear;
    Vec2 offset;
  };

  BoundarySweep(const RegionLayout& region, std::vector<BoundarySide> sides);
  void add(Edge bottom, Edge top, Edge left, Edge right, bool both);
  void sample(Patch& patch) const;
  bool compute_weights();
  std::optional<Projection> projection_of_sides() const;
  bool is_graph() const;
  void use_projection();
  BoundarySide::Point point(const Edge& edge, double f) const;
  PatchPoint evaluate_map(const Patch& patch, const Vec2& st) const;
  PatchPoint invert_map(const Patch& patch, const Vec2& uv) const;
  PatchPoint invert_map(const Patch& patch, const Vec2& uv, const Vec2& from) const;
  Vec2 start(const Patch& patch, const Vec2& uv) const;
  // Parameters of the sweeps at (s, t).
  static Vec2 warped(const Patch& patch, const Vec2& st);
  Vec2 parameters(const Patch& patch, const Vec2& st) const;
  static Jet jet(const Patch& patch, const Vec2& st, const Edges& edges);
  Jet jet(const Patch& patch, const PatchPoint& evaluate_map) const;
  Edges edges(const Patch& patch, const Vec2& st) const;
  FirstOrderJet slopes_at(const Patch& patch, const PatchPoint& evaluate_map) const;
  FirstOrderJet projected(const Patch& patch, Vec2 st, const FirstOrderJet& mean) const;
  FirstOrderJet slopes_of_blend(const Vec2& uv) const;
  std::optional<FirstOrderJet> at_corner(const Vec2& uv) const;

  const RegionLayout* region_;
  std::vector<BoundarySide> sides_;
  std::vector<Patch> patches_;
  std::optional<Projection> projection_;  // the map from (s, t) to (u, v), if it is no Coons patch
  double extent_ = 1;                     // diagonal of the domain
};

// Element sizes that resolve a region's rest shape.

/// Interpolation error of a region's rest shape on its mesh.
struct RestShapeError {
  double largest = 0;  ///< model units; 0 if the rest shape is no sweep
  /// Longest edges that resolve the rest shape, as estimated; null if `largest` is within the
  /// tolerance.
  std::shared_ptr<const SizeField> size_field;
};

/// Compares the interpolated rest shape with the sweep itself at the midpoint of each edge, where
/// the error of a cubic is largest. Where it exceeds `tolerance` (model units), edges of length h
/// shall become h (0.1 tolerance / error)^(1/4), limited to 0.5 h … 0.7 h. Elsewhere they may be as
/// long as before. `before`: size field with which the region was meshed, or null. Cost: one
/// rest_dofs().
RestShapeError rest_shape_error(const RegionLayout& region, double tolerance,
                                const SizeField* before = nullptr);

}  // namespace batten
