// SPDX-License-Identifier: MPL-2.0
// Loads, stiffness fields, constraints and curve offsets of a sculpting session, as plain named
// data, and the weights of their areas on the triangles of a model.
//
// Each item can be added and removed at any time. Each load, stiffness field and curve offset is
// scaled by the parameter of the same name, which a slider can change
// (sculpting/loads/parameters.h). The goal of a point constraint has three parameters, NAME.x,
// NAME.y and NAME.z.
//
// Points of application are given in space. When an item is added, each is projected onto the
// closest point of the surface. From then on it stays at that location of the domain, also when the
// mesh is refined.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "batten/fem/curves/hermite_curve.h"

namespace batten {

class ModelLayout;
class Surface;

/// Region in which a load or stiffness field acts, as a weight w in [0, 1] at each point of the
/// surface. It covers all regions of a model or only the named ones.
struct Area {
  struct Everywhere {};
  /// Neighbourhood of a curve: the weight is w = (1 - (r/radius)²)² at a distance r < radius from
  /// the curve, and 0 beyond.
  struct NearLine {
    std::string line;
    double radius = 0;  ///< distance from the curve at which w becomes 0; model units
  };
  /// Area painted by brush strokes. Each stroke adds strength · (1 - (r/radius)²)² to the weight w
  /// at a distance r < radius from the centre of the stroke. The strokes are applied in order, and
  /// w is clamped to [0, 1] after each stroke.
  struct Painted {
    struct Stroke {
      Vec3 at = Vec3::Zero();
      double radius = 0;  ///< radius of the stroke; model units
      /// Change of w at the centre; negative: subtracts from previous strokes.
      double strength = 1;
    };
    std::vector<Stroke> strokes;
  };
  std::variant<Everywhere, NearLine, Painted> where;
  std::vector<std::string> regions = {};  ///< region names; empty: all regions
};

/// A load. In the comments of its types, `value` is the value of the parameter that has the load's
/// name.
///
/// In relative units, pressure, forces and spring stiffness are dimensionless and refer to the
/// model scaled to size 1. In absolute units, uniform loads and pressure are force/length², point
/// loads are forces, in the model's length unit.
struct Load {
  /// Pressure p (follower load): force p · w · n per current area, with the current surface normal
  /// n and the weight w of `area`; p is the value of the load's parameter.
  struct Pressure {
    Area area;
  };
  /// Force p · w · direction per area of the domain (u, v), with the value p of the load's
  /// parameter and the weight w of `area`.
  struct Uniform {
    Vec3 direction = Vec3::Zero();
    Area area = {};
  };
  /// Force p · direction per area of the surface, as for gravity on sheet metal, with the value p
  /// of the load's parameter. The area is that of the surface at the time when the load is added.
  struct Gravity {
    Vec3 direction = Vec3::Zero();
  };
  /// Point force p · direction at the surface point closest to `at`; p: value of the parameter.
  struct Point {
    Vec3 at = Vec3::Zero(), direction = Vec3::Zero();
  };
  /// Force p · direction per length of a curve, with the value p of the load's parameter. It acts
  /// once, even if several regions share the curve.
  struct Line {
    std::string line;
    Vec3 direction = Vec3::Zero();
  };
  /// Attractor springs between surface points and a target.
  ///
  /// Let t be the target point closest to the surface point x, r = |x - t|, and `value` the value
  /// of the load's parameter. The force on x is
  ///
  ///     f = value φ(r) (r - rest_length) (t - x)/r,    φ = exp(-(r/falloff)²), or 1 for falloff 0
  ///
  /// A spring to a plane acts along the plane's normal only.
  struct AttractorSprings {
    struct TargetPoints {
      std::vector<Vec3> to;  ///< target point of each spring
    };
    struct Curve {
      HermiteCurve curve;
    };
    struct Plane {
      Vec3 through = Vec3::Zero(), normal = Vec3::Zero();
    };
    std::vector<Vec3> at;  ///< one spring per point, attached to the closest surface point
    std::variant<TargetPoints, Curve, Plane> target;
    /// `rest_length`: spring length without force. `falloff`: distance at which the stiffness has
    /// decayed to 1/e; 0: no decay. Model units.
    double rest_length = 0, falloff = 0;
  };
  /// Point-cloud springs that pull the surface to n measured points p_i. They add Σ value/n |x(c_i)
  /// - p_i|² to the energy.
  ///
  /// x(c_i) is the surface point closest to p_i. solve_to_equilibrium() recomputes the c_i until
  /// they no longer move (at most 20 times). `value`, the value of the load's parameter, is the
  /// total stiffness of all n springs. Points beyond the boundary of the surface are ignored.
  struct PointCloudSprings {
    std::vector<Vec3> points;
  };
  std::string name;
  std::variant<Pressure, Uniform, Gravity, Point, Line, AttractorSprings, PointCloudSprings> kind;
};

/// A stiffness field: adds the value of its parameter times the weight of `area` to the stretching
/// stiffness alpha or the bending stiffness beta, isotropically or in one direction.
struct StiffnessField {
  enum class Kind { Stretching, Bending };
  std::string name;
  Kind kind = Kind::Bending;
  Area area = {};
  /// Anisotropic field: the only direction that becomes stiffer. Either a direction in (u, v), or
  /// the name of a curve, whose tangent at the closest point is used. Unset: isotropic field.
  std::optional<std::variant<Vec2, std::string>> along = {};
};

/// A geometric constraint, in addition to the constraints along the curves of the ModelLayout.
struct Constraint {
  /// Moves the surface point closest to `at` to the position given by the parameters NAME.x, NAME.y
  /// and NAME.z, which start at `goal` (NAME: name of the constraint).
  struct Point {
    Vec3 at, goal;
  };
  /// The surface normal at the surface point closest to `at` is parallel to `normal`.
  struct Normal {
    Vec3 at = Vec3::Zero(), normal = Vec3::Zero();
  };
  /// At the surface point closest to `at`, the derivative in the direction `along` of (u, v) is
  /// parallel to `tau`.
  struct Tangent {
    Vec3 at = Vec3::Zero();
    Vec2 along = Vec2::Zero();
    Vec3 tau = Vec3::Zero();
  };
  /// The surface normal along a curve stays as it is when the constraint is added or, if `normal`
  /// is set, is parallel to `normal`. On a crease, the constraint acts on all sides. At a smooth
  /// join it acts on one side, and the join transfers it to the other.
  struct LineNormal {
    std::string line;
    std::optional<Vec3> normal = {};
  };
  std::string name;
  std::variant<Point, Normal, Tangent, LineNormal> kind;
};

/// Displacement of a curve by the parameter of the same name, in all regions that contain the
/// curve: X(t) moves to X(t) + value · profile(t) · direction(t); model units.
///
/// `direction` need not be a unit vector; its length scales the displacement. If it is unset, the
/// curve moves along the unit surface normal at the time when the offset is added (a "rib"). At a
/// smooth join, this is the mean of the normals on both sides; at a crease, `direction` is
/// required.
struct LineOffset {
  std::string name, line;
  std::optional<Vec3> direction = {};
  /// Fraction of the curve's length at each end over which the profile rises smoothly from 0 to 1;
  /// at most 0.5. 0: the curve moves as a whole. Must be 0 for closed curves.
  double fade = 0;
};

// Areas and directions on the triangles of a model.

/// Computes the mean weight w in [0, 1] of an area on each triangle, sampled at seven points per
/// triangle.
///
/// Triangles that are cut by a trim count as a whole. Distances are measured in space, from points
/// of `reference`, a surface on the layout's mesh. Distances to a curve are accurate to 1e-3 of the
/// radius. w is 0 in regions that are not listed in `area`.
///
/// Throws InputError for an unknown curve or region (the message suggests the closest name), a
/// radius that is not above 0, a painted area without strokes, numbers that are not finite, and a
/// reference on another mesh. O(triangles + strokes · triangles).
VecX triangle_weights(const Area& area, const ModelLayout& layout, const Surface& reference);

/// Computes a unit vector in (u, v) for each triangle: the tangent of a curve in (u, v), at the
/// point of the curve closest to the centroid of the triangle. Curves are approximated by 16 chords
/// per segment.
///
/// The vector is zero in regions that do not contain the curve. On annular domains u is not taken
/// modulo the period, because the boundary circles run straight along u. Throws InputError for an
/// unknown curve. O(triangles · segments).
std::vector<Vec2> triangle_directions(const std::string& line, const ModelLayout& layout);

}  // namespace batten
