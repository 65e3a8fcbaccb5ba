// The surface that the sides of a region mean: sweeps between opposite sides, blended. Internal.
#pragma once

#include <array>
#include <optional>
#include <vector>
#include <memory>

#include "batten/skinning/layout/region_layout.h"
#include "batten/skinning/model/sweep.h"
#include "batten/skinning/domains/surface_interpolation.h"
#include "batten/fem/curves/hermite_curve.h"
#include "batten/skinning/domains/mesher.h"

namespace batten {

// A side of a region: boundary curves from one corner to the next, by arc length. Internal.

/// A chain of curves and of their images in (u, v), as a function of the fraction f of its arc
/// length, 0 at its start and 1 at its end.
class BoundarySide {
 public:
  struct Point {
    Vec3 x, x_f;    ///< position and its derivative by f, model units
    Vec2 uv, uv_f;  ///< image and its derivative by f
  };

  /// Adds a curve behind those added before. `pcurve` is over the parameters of `curve`, z = 0.
  void add(HermiteCurve curve, HermiteCurve pcurve);

  double length() const { return lengths_.empty() ? 0 : lengths_.back(); }  ///< model units
  /// The point at a fraction of the length; beyond the ends the side goes on straight.
  /// O(log segments).
  Point at(double f) const;

 private:
  Point on(double length) const;

  // A part of a segment. Arc length is tabulated at its ends.
  struct Part {
    int piece;
    double from, to;  // parameters of the piece's curve
    Vec3 c[4];        // x = c0 + c1 t + c2 t² + c3 t³, t from 0 to 1
    double rates[2];  // dt/ds at both ends, times the length of the part

    Vec3 position(double t) const { return c[0] + t * (c[1] + t * (c[2] + t * c[3])); }
    Vec3 slope(double t) const { return c[1] + t * (2 * c[2] + 3 * t * c[3]); }
    double length_to(double t) const;
  };
  std::vector<HermiteCurve> pcurves_;  // of the pieces
  std::vector<Part> parts_;
  std::vector<double> lengths_;  // arc length at the end of each part
};


/// Sweeps between the sides of a region with two, three or four corners, over its flat domain. Sides
/// that go on within the corner angle are one side.
///
///     four sides   both pairs are swept; the results are blended
///     three sides  one rail is a corner: three sweeps, blended
///     two sides    both rails are corners: one sweep
///
/// Weights are 1 / (ρ² + 1e-6), ρ the mismatch of the pair (sweep.h): the pair whose ends are alike
/// wins, continuously. Each sweep has its own parameters (s, t); the map from these to (u, v) is the
/// bilinearly blended Coons patch of the sides' images, so that the surface has every boundary curve
/// with the parameters that the curve has there. Where (u, v) are a projection to a plane, above
/// which the sweeps are a graph, the map is that projection of the sweeps. Around a corner that is a
/// rail the sweep's lines of equal t fan out; with the Coons patch, (s, t) are bent so that the fan is
/// linear in (u, v), and the surface C1, there. The three sweeps of a triangle move differently along
/// nearly the same surface: their weighted mean is projected onto each, and the projections are
/// averaged.
class BoundarySweep {
 public:
  /// None where the region has another number of sides, where its boundary lies in a plane within
  /// 1e-4 of the size, or where no pair can be swept. `region` must outlive it.
  static std::optional<BoundarySweep> of(const RegionLayout& region);

  /// Whether the region has five sides or more, which do not lie in a plane: no side has an opposite one.
  static bool has_many_sides(const RegionLayout& region);

  /// Value and gradient at a place of the domain, also a little outside of the boundary.
  FirstOrderJet at(const Vec2& uv) const;
  /// Dofs on the region's mesh; none where the surface would turn over in the domain.
  std::optional<Points> dofs() const;

 private:
  // An edge of the square of (s, t): a side, forwards or backwards, or a corner.
  struct Edge {
    int side = -1;
    bool backwards = false;
    Vec3 x = Vec3::Zero();
    Vec2 uv = Vec2::Zero();
  };
  struct Edges {
    BoundarySide::Point bottom, top, left, right;  // at s, s, t, t
  };
  // The curves that leave a corner which is a rail: derivatives of bottom and top by s, away from it.
  struct Fan {
    Vec3 bottom, top;
    double angle;
    double warped(double t) const;        // t, for which the directions are linear
    double length_scale(double t) const;  // of lengths, for which they are
  };
  // Sides laid around the square, and what is swept there.
  struct Patch {
    Edge bottom, top, left, right;
    std::optional<Fan> fan_left, fan_right;
    std::vector<Vec2> at, uv;  // samples of the map
    std::optional<Sweep> along_t, along_s;
    double weight_t = 0, weight_s = 0;
  };
  struct PatchPoint {
    Vec2 st, uv;
    Mat2 jacobian;  // of uv by (s, t)
    Edges edges;
  };
  using Jet = Sweep::Jet;  // by_u: by s, by_v: by t
  // uv = linear x + offset, as a projection to a plane has it.
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
  // Parameters of the sweeps at (s, t), and their derivatives.
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
  std::optional<Projection>
      projection_;     // the map from (s, t) to (u, v), instead of the Coons patch
  double extent_ = 1;  // of the domain
};


// Element sizes that resolve a region's rest shape. Internal.

/// How far the elements of a region are from its rest shape.
struct RestShapeError {
  double largest = 0;  ///< model units; 0 where the rest shape is no sweep
  /// Longest edges that resolve it, as far as is known; null where `largest` is within the tolerance.
  std::shared_ptr<const SizeField> size_field;
};

/// Compares the interpolated rest shape with the sweep itself in the middle of each edge, where the
/// error of a cubic is largest. Where it is above the tolerance (model units) edges of length h are to
/// become h (tolerance / 2 error)^(1/4), at least h / 2; elsewhere they may be as long as `before` says,
/// the sizes that the region was meshed with. One rest_dofs().
RestShapeError rest_shape_error(const RegionLayout& region, double tolerance,
                                const SizeField* before = nullptr);

}  // namespace batten
