// Loads, stiffness fields, constraints and line offsets of a sculpting session: plain data with
// names.
//
// Each item can be added and removed at any time. The number that a slider changes is the parameter
// of the same name (sculpting/loads/parameters.h). The goal of a point constraint has three
// parameters, NAME.x, NAME.y and NAME.z.
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

/// Region in which a load or stiffness field acts, as a weight w in [0, 1] at each point of the
/// surface. It covers all regions of a model or only the named ones.
struct Area {
  struct Everywhere {};
  /// w = (1 - (r/radius)²)² for r < radius and 0 beyond, with r the distance from the line.
  struct NearLine {
    std::string line;
    double radius = 0;  ///< distance at which w becomes 0; model units
  };
  /// Brush strokes. Each adds strength · (1 - (r/radius)²)², with r the distance from its centre.
  /// They are applied in order, and w is clamped to [0, 1] after each.
  struct Painted {
    struct Stroke {
      Vec3 at = Vec3::Zero();
      double radius = 0;    ///< distance at which the stroke ends; model units
      double strength = 1;  ///< negative: subtracts from the strokes before it
    };
    std::vector<Stroke> strokes;
  };
  std::variant<Everywhere, NearLine, Painted> where;
  std::vector<std::string> regions = {};  ///< region names; empty: all regions
};

/// A load. `value` below is that of its parameter, which multiplies the load.
///
/// In relative units, pressure, forces and spring stiffness are dimensionless and refer to the
/// model scaled to size 1. In absolute units, uniform loads and pressure are force/length², point
/// loads are forces, in the model's length unit.
struct Load {
  /// Pressure: force value · w · n per current area. It is a follower load, because it follows the
  /// normal n.
  struct Pressure {
    Area area;
  };
  /// Force value · w · direction per area of the domain.
  struct Uniform {
    Vec3 direction = Vec3::Zero();
    Area area = {};
  };
  /// Force value · direction per area of the surface at the time the load was added, like gravity
  /// on a sheet of metal.
  struct Gravity {
    Vec3 direction = Vec3::Zero();
  };
  /// Point force value · direction at the surface point closest to `at`.
  struct Point {
    Vec3 at = Vec3::Zero(), direction = Vec3::Zero();
  };
  /// Force value · direction per length of a line, counted once even if several regions share the
  /// line.
  struct Line {
    std::string line;
    Vec3 direction = Vec3::Zero();
  };
  /// Attractor springs between surface points and a target.
  ///
  /// With t the target point closest to a surface point x, and r = |x - t|, the force on x is
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
    std::vector<Vec3> at;  ///< each spring is attached to the surface point closest to one of these
    std::variant<TargetPoints, Curve, Plane> target;
    /// rest_length: length without force; falloff: decay length of φ, 0: none; model units.
    double rest_length = 0, falloff = 0;
  };
  /// Point-cloud springs that pull the surface to n measured points p_i. They add Σ value/n |x(c_i)
  /// - p_i|² to the energy.
  ///
  /// c_i is the surface point closest to p_i. solve_to_equilibrium() recomputes the c_i until none
  /// moves (at most 20 times). `value` is the total stiffness of all n springs. Points beyond the
  /// boundary of the surface are ignored.
  struct PointCloudSprings {
    std::vector<Vec3> points;
  };
  std::string name;
  std::variant<Pressure, Uniform, Gravity, Point, Line, AttractorSprings, PointCloudSprings> kind;
};

/// A stiffness field: adds value · w to the stretching stiffness alpha or the bending stiffness
/// beta, isotropically or in one direction.
struct StiffnessField {
  enum class Kind { Stretching, Bending };
  std::string name;
  Kind kind = Kind::Bending;
  Area area = {};
  /// Anisotropic field: the only direction that becomes stiffer. Either a direction in (u, v), or
  /// the name of a line whose tangent at the closest point is used.
  std::optional<std::variant<Vec2, std::string>> along = {};
};

/// A geometric constraint in addition to those of the lines, which are part of the layout.
struct Constraint {
  /// The surface point stays at its goal, given by the parameters NAME.x, NAME.y and NAME.z.
  struct Point {
    Vec3 at, goal;
  };
  /// The surface normal at the point is parallel to `normal`.
  struct Normal {
    Vec3 at = Vec3::Zero(), normal = Vec3::Zero();
  };
  /// The derivative of the surface in the direction `along` of (u, v) is parallel to tau.
  struct Tangent {
    Vec3 at = Vec3::Zero();
    Vec2 along = Vec2::Zero();
    Vec3 tau = Vec3::Zero();
  };
  /// The tangent plane along a line stays as it is when the constraint is added, or parallel to
  /// `normal` if that is given. The constraint acts on all sides of a crease. At a smooth join it
  /// acts on one side, and the join transfers it to the other.
  struct LineNormal {
    std::string line;
    std::optional<Vec3> normal = {};
  };
  std::string name;
  std::variant<Point, Normal, Tangent, LineNormal> kind;
};

/// A line that a parameter moves, in all regions that contain it, to X(t) + value · profile(t) ·
/// direction(t); model units.
///
/// `direction` is used with its length. If it is not set, the line moves along the unit surface
/// normal at the time the offset is added (a "rib"). At a smooth join that is the mean of the
/// normals on both sides; a crease requires a direction.
struct LineOffset {
  std::string name, line;
  std::optional<Vec3> direction = {};
  /// Fraction of the line's length at either end over which the profile rises smoothly from 0 to 1.
  /// 0: the line moves as a whole. At most 0.5; 0 for closed lines.
  double fade = 0;
};

}  // namespace batten
