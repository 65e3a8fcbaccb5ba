// Loads, weight fields, constraints and moves of a sculpting session: plain data with names.
//
// Each of them can be added and removed at any moment. The number that a slider moves is the
// parameter of the same name (sculpting/loads/parameters.h); the goal of a point has three of them,
// NAME.x, NAME.y, NAME.z. Places are given in space. They are put where the surface is nearest to
// them when the load or constraint is added, and stay at that place of the domain from then on,
// also when the mesh is refined.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// Says where a load or a weight field acts: by a weight w in [0, 1] at each point of the surface,
/// in all regions of a model, or in those that are named.
struct Area {
  struct Everywhere {};
  /// w is (1 - (r/radius)²)² for r < radius, with r the distance from the line, and 0 beyond.
  struct NearLine {
    std::string line;
    double radius = 0;  ///< model units
  };
  /// Each stroke adds strength · (1 - (r/radius)²)², with r the distance from its place. They are
  /// added in their order, and w is held between 0 and 1 after each.
  struct Painted {
    struct Stroke {
      Vec3 at = Vec3::Zero();
      double radius = 0;    ///< model units
      double strength = 1;  ///< below 0: takes away from the strokes before it
    };
    std::vector<Stroke> strokes;
  };
  std::variant<Everywhere, NearLine, Painted> where;
  std::vector<std::string> regions = {};  ///< names; none: all regions
};

/// A load. `value` below is that of its parameter, which multiplies it. In relative units pressure,
/// forces and stiffness of springs are pure numbers on the model scaled to size 1. In absolute
/// units uniform loads and pressure are force/length², point loads are forces, in the model's
/// length unit.
struct Load {
  /// The force value · w · n acts per area of the present surface; it follows the normal n.
  struct Pressure {
    Area area;
  };
  /// The force value · w · direction acts per area of the domain.
  struct Uniform {
    Vec3 direction = Vec3::Zero();
    Area area = {};
  };
  /// The force value · direction acts per area of the surface as it was when the load was added, as
  /// gravity does on a sheet.
  struct Gravity {
    Vec3 direction = Vec3::Zero();
  };
  /// The force value · direction acts at the place of the surface that is nearest to `at`.
  struct Point {
    Vec3 at = Vec3::Zero(), direction = Vec3::Zero();
  };
  /// The force value · direction acts per length of a line, once however many regions have it.
  struct Line {
    std::string line;
    Vec3 direction = Vec3::Zero();
  };
  /// Springs pull places of the surface to a target. With t the point of the target that is nearest
  /// to a place x and r = |x - t|, the force on the place is
  ///
  ///     f = value φ(r) (r - rest_length) (t - x)/r,    φ = exp(-(r/falloff)²), or 1 for falloff 0
  ///
  /// A spring to a plane pulls along the plane's normal only.
  struct AttractorSprings {
    struct TargetPoints {
      std::vector<Vec3> to;  ///< one for each spring
    };
    struct Curve {
      HermiteCurve curve;
    };
    struct Plane {
      Vec3 through = Vec3::Zero(), normal = Vec3::Zero();
    };
    std::vector<Vec3> at;  ///< springs stay where the surface is nearest to these
    std::variant<TargetPoints, Curve, Plane> target;
    double rest_length = 0, falloff = 0;  ///< model units
  };
  /// Springs pull the surface to n measured points p_i: they add Σ value/n |x(c_i) - p_i|² to the
  /// energy. c_i is the place of the surface that is nearest to p_i; settle() finds it again until
  /// none moves (20 times at most). `value` is the stiffness of all n springs together. Points
  /// beyond the surface's rim are left out.
  struct PointCloudSprings {
    std::vector<Vec3> points;
  };
  std::string name;
  std::variant<Pressure, Uniform, Gravity, Point, Line, AttractorSprings, PointCloudSprings> kind;
};

/// A weight field adds value · w to alpha or beta, in all directions or in one.
struct StiffnessField {
  enum class Kind { Stretching, Bending };
  std::string name;
  Kind kind = Kind::Bending;
  Area area = {};
  /// With it, the field resists in one direction only: a direction of (u, v), or the tangent of the
  /// nearest point of the line with this name.
  std::optional<std::variant<Vec2, std::string>> along = {};
};

/// A geometric constraint beside those of the lines, which the layout has.
struct Constraint {
  /// The place stays at its goal, which is the parameters NAME.x, NAME.y, NAME.z.
  struct Point {
    Vec3 at, goal;
  };
  /// The normal at the place is parallel to n.
  struct Normal {
    Vec3 at = Vec3::Zero(), normal = Vec3::Zero();
  };
  /// The derivative of the surface in the direction `along` of (u, v) is parallel to tau.
  struct Tangent {
    Vec3 at = Vec3::Zero();
    Vec2 along = Vec2::Zero();
    Vec3 tau = Vec3::Zero();
  };
  /// The tangent plane along a line stays as it is when this is added, or parallel to `normal`: on
  /// all sides of a crease, on one side of a smooth join, which carries it to the other.
  struct LineNormal {
    std::string line;
    std::optional<Vec3> normal = {};
  };
  std::string name;
  std::variant<Point, Normal, Tangent, LineNormal> kind;
};

/// A line that a parameter moves, in all regions that have it, to X(t) + value · profile(t) ·
/// direction(t), in model units. `direction` is used with its length. Without one the line moves
/// along the unit normal that the surface has when this is added (the "rib"), on a smooth join
/// along the mean of the normals of both sides; a crease needs a direction.
struct LineOffset {
  std::string name, line;
  std::optional<Vec3> direction = {};
  /// Share of the line's length at either end over which the profile rises smoothly from 0 to 1;
  /// 0: the line moves as a whole. At most 0.5; 0 for closed lines.
  double fade = 0;
};

}  // namespace batten
