// What a sculpting session knows of loads, weights, constraints and moves: plain data with names.
//
// Each is a separate thing that can come and go at any moment. The number that a slider moves is
// the parameter of the same name (sculpting/loads/parameters.h); three of them, NAME.x, NAME.y, NAME.z,
// for the goal of a point. Places are given in space, on the surface as it is when the thing is
// added, and stay with the material from then on: refinement carries them over.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "batten/fem/curve.h"

namespace batten {

/// Where something acts: a weight w in [0, 1] over the surface; on a whole model in all regions, or
/// in those that are named.
struct Area {
  struct Everywhere {};
  /// (1 - (r/radius)²)² for r < radius, r the distance to the line; 0 beyond.
  struct NearLine {
    std::string line;
    double radius = 0;  ///< model units
  };
  /// The same bump around each place, times its strength; bumps add up, to 1 at most.
  struct Painted {
    struct Stroke {
      Vec3 at = Vec3::Zero();
      double radius = 0;    ///< model units
      double strength = 1;  ///< below 0: an eraser, for strokes before it
    };
    std::vector<Stroke> strokes;
  };
  std::variant<Everywhere, NearLine, Painted> where;
  std::vector<std::string> regions = {};
};

/// A load; its parameter multiplies it. Relative units: pressure, forces and stiffness of springs
/// are pure numbers on the model scaled to size 1. Absolute: uniform loads and pressure are
/// force/length², point loads force, in the model's length unit.
struct Load {
  /// value · w · n per area of the surface as it is: follows the normal.
  struct Pressure {
    Area area;
  };
  /// value · w · direction per area of the domain.
  struct Uniform {
    Vec3 direction = Vec3::Zero();
    Area area = {};
  };
  /// value · direction per area of the surface as it is when this is added: weight.
  struct Gravity {
    Vec3 direction = Vec3::Zero();
  };
  /// value · direction at one place.
  struct Point {
    Vec3 at = Vec3::Zero(), direction = Vec3::Zero();
  };
  /// value · direction per length of a line, once however many regions have it.
  struct Line {
    std::string line;
    Vec3 direction = Vec3::Zero();
  };
  /// Springs from places of the surface to what draws them. Force on a place x, with t the point of
  /// the target nearest to x and r = |x - t|:
  ///
  ///     f = value φ(r) (r - rest_length) (t - x)/r,    φ = exp(-(r/falloff)²), or 1 for falloff 0
  ///
  /// A spring to a plane pulls along the plane's normal only.
  struct Pulls {
    struct Places {
      std::vector<Vec3> to;  ///< one for each spring
    };
    struct Curve {
      HermiteCurve curve;
    };
    struct Plane {
      Vec3 through = Vec3::Zero(), normal = Vec3::Zero();
    };
    std::vector<Vec3> at;  ///< springs stay where the surface is nearest to these
    std::variant<Places, Curve, Plane> target;
    double rest_length = 0, falloff = 0;  ///< model units
  };
  /// Measured points that draw the surface: the energy gets Σ value/n |x(c_i) - p_i|², c_i the
  /// place that is nearest to point i, looked for anew until it stands still. `value`: stiffness of
  /// all n together. Points beyond the surface's rim are left out.
  struct Scan {
    std::vector<Vec3> points;
  };
  std::string name;
  std::variant<Pressure, Uniform, Gravity, Point, Line, Pulls, Scan> kind;
};

/// A field that is added to alpha or beta: value · w, in all directions or in one.
struct WeightField {
  enum class Kind { Stretching, Bending };
  std::string name;
  Kind kind = Kind::Bending;
  Area area = {};
  /// Resistance in one direction only: of (u, v), or along the tangent of the nearest point of a
  /// line.
  std::optional<std::variant<Vec2, std::string>> along = {};
};

/// A geometric constraint of its own (lines are constraints of the layout).
struct Constraint {
  /// The place stays at its goal; parameters NAME.x, NAME.y, NAME.z.
  struct Point {
    Vec3 at, goal;
  };
  /// The normal at the place is parallel to n.
  struct Normal {
    Vec3 at = Vec3::Zero(), normal = Vec3::Zero();
  };
  /// The derivative in a direction of (u, v) is parallel to tau.
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

/// A line that a parameter moves, with all regions that have it: X(t) + value · profile(t) ·
/// direction(t), in model units. Without a direction: along the surface's normal where it is when
/// this is added (the "rib"), of a smooth join along the mean of both; a crease needs a direction.
struct LineMove {
  std::string name, line;
  std::optional<Vec3> direction = {};
  /// Share of the line's length at either end over which the profile rises smoothly from 0 to 1;
  /// 0: moves as a whole. Not for closed lines.
  double fade = 0;
};

}  // namespace batten
