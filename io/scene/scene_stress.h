// SPDX-License-Identifier: MPL-2.0
// The table [stress] of a scene: material, thickness, supports and load cases of a shell.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/geometry.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/scene/formula.h"
#include "batten/io/scene/scene_material.h"
#include "batten/sculpting/loads/loads.h"

namespace batten {

// Areas of a surface for loads, stiffness fields and thicknesses.

/// Area of a surface in which a load or stiffness field acts: everywhere, near a curve, or painted;
/// optionally restricted to some faces.
struct SceneArea {
  Area area;                           ///< the area, not yet restricted to `regions`
  LocatedString line;                  ///< name of the curve near which the area lies (key `near`)
  std::vector<LocatedString> regions;  ///< names of the faces; empty: all faces
};

/// Reads an area of a surface from the keys `near`, `radius`, `paint` and `faces` of a table.
/// Throws InputError, with the location in the scene, if a value is invalid.
SceneArea read_area(const TomlTable& table);

/// [stress]: properties of the shell for `batten stress` and for CalculiX decks.
struct SceneStress {
  /// A thickness on part of the shell that differs from the default thickness.
  struct Thickness {
    LocatedString region;  ///< name of the face with this thickness; empty: `area` is used
    /// Alternative to `region`: area in which the shell's thickness blends into `thickness`.
    SceneArea area;
    double thickness = 0;
  };
  /// A boundary condition at a curve, a point, a box or an area.
  struct Support {
    enum class Kind {
      Clamped,     ///< no displacement, no rotation about the curve
      Pinned,      ///< no displacement (simply supported)
      Symmetric,   ///< symmetry plane, with the normal Support::directions[0]
      Prescribed,  ///< displacement along Support::directions (and Support::rotation) is prescribed
      Elastic      ///< springs along x, y and z, or a Winkler foundation along the normal
    };
    Kind kind = Kind::Clamped;
    LocatedString line;
    std::optional<Vec3> point;  ///< alternative to `line`: the surface point nearest to this point
    /// Restricts the support to the part of the curve, face or model in this box.
    std::optional<Box3> box;
    std::vector<Vec3> directions;
    Vec3 displacement = Vec3::Zero();
    /// Axis of cylindrical directions: `directions` and `displacement` are radial, hoop and axial.
    std::optional<Vec3> axis;
    Vec3 origin = Vec3::Zero();  ///< a point of the axis
    bool rotation = false;
    LocatedString region;  ///< name of the supported face; empty: all faces
    /// Elastic only: spring stiffness along x, y, z. Force per displacement at a `point`, per unit
    /// length of a `line`, otherwise per unit area.
    Vec3 springs = Vec3::Zero();
    /// Elastic only: stiffness along the normal per unit area (Winkler foundation).
    double foundation = 0;
    SourceLocation location;
    std::string description() const;  ///< text for messages, such as "clamped rim"
  };
  /// A load on the shell in one load case.
  struct Load {
    enum class Type {
      Pressure,     ///< pressure (value_at()), a force per unit area along the normal
      AreaForce,    ///< surface traction (vector_at()), a force per unit area
      Gravity,      ///< acceleration Load::vector
      Hydrostatic,  ///< pressure Load::value · (Load::level − z) at points below z = Load::level
      Point,        ///< concentrated force Load::vector
      LineForce,    ///< force vector_at() per unit length of the curve
      /// Moment value_at() per unit length of the curve, about its tangent (right-handed).
      LineMoment,
      /// Force value_at() per unit length of an edge, in the tangent plane, away from the face.
      EdgeForce,
      Temperature,  ///< change of temperature, Load::temperature
      Total,  ///< force Load::vector and moment Load::moment, spread over a curve, face or part
      Spin    ///< centrifugal force of the angular velocity Load::value about an axis
    };
    Type type = Type::Pressure;
    std::string load_case;      ///< name of the load case to which the load belongs
    LocatedString region;       ///< name of the loaded face; empty: all faces
    std::optional<Box3> box;    ///< restricts the load to the part of the surface in this box
    LocatedString line;         ///< name of the loaded curve, of loads on curves
    Vec3 point = Vec3::Zero();  ///< loads of type Point: point of application
    double value = 0, level = 0;
    Vec3 vector = Vec3::Zero(), moment = Vec3::Zero();
    /// The value, or the components of the vector, as formulas of the position; empty: constant.
    std::vector<Formula> formulas;
    Vec3 axis = Vec3::UnitZ(), origin = Vec3::Zero();  ///< Spin: axis of rotation
    /// Temperature: changes in the middle of the shell, and from bottom to top, as formulas.
    std::optional<Formula> temperature, temperature_difference;
    SourceLocation location;
    /// Value or vector at the point x, for the types that may vary.
    double value_at(const Vec3& x) const { return formulas.empty() ? value : formulas[0](x); }
    Vec3 vector_at(const Vec3& x) const {
      return formulas.empty() ? vector : Vec3(formulas[0](x), formulas[1](x), formulas[2](x));
    }
  };
  /// A stiffener along a curve.
  struct Stiffener {
    LocatedString line;
    std::string name;  ///< in results; that of the curve, unless given
    SceneMaterial material;
    enum class Shape { Rectangle, Circle, Tube, Tee, Numbers };
    Shape shape = Shape::Rectangle;
    /// Rectangle: width, height; Circle: radius; Tube: radius, wall; Tee: height and thickness of the
    /// web, width and thickness of the flange; Numbers: area, inertia, lateral inertia, torsion
    /// constant, eccentricity.
    std::vector<double> dimensions;
    double side = 1;  ///< 1: on the top of the shell, -1: on its bottom, 0: in its middle
  };
  /// A mass at a point of the surface.
  struct Mass {
    Vec3 point = Vec3::Zero();
    double mass = 0;
    SourceLocation location;
  };
  /// Steady vibration under the load cases, at equal steps between two frequencies.
  struct Harmonic {
    double from = 0, to = 0, damping = 0;
    int steps = 0;
  };
  /// Response spectrum of an acceleration of all supports.
  struct Spectrum {
    Vec3 direction = Vec3::UnitZ();
    std::vector<std::pair<double, double>> points;  ///< frequencies and accelerations
    double damping = 0;
  };
  /// A point, a curve or a face whose values are reported.
  struct Result {
    std::string name;
    std::optional<Vec3> point;
    LocatedString line, region;  ///< alternatives to `point`
    /// Axis of revolution, for hoop and meridional stresses, and a point of it.
    std::optional<Vec3> axis;
    Vec3 origin = Vec3::Zero();
    SourceLocation location;
  };
  /// A linear combination of load cases.
  struct Combination {
    std::string name;
    std::vector<std::pair<LocatedString, double>> parts;
  };

  SceneMaterial material;       ///< of a shell that is not layered
  std::vector<ScenePly> plies;  ///< from the bottom to the top; empty: `material`
  Vec3 along = Vec3::Zero();  ///< direction 1 of the material, from which the angles of plies count
  /// Height of the middle of the shell above the surface of the model, divided by the thickness.
  double offset = 0;
  double thickness = 0, yield = 0;  ///< default thickness, and yield stress (0: not given)
  std::vector<Thickness> thicknesses;
  std::vector<Support> supports;
  std::vector<Load> loads;
  std::vector<Combination> combinations;
  std::vector<LocatedString> hinges, rigid_curves;
  std::vector<Stiffener> stiffeners;
  std::vector<Mass> masses;
  std::vector<Result> results;
  std::optional<Harmonic> harmonic;
  std::optional<Spectrum> spectrum;
  NamedFields fields;  ///< of all [[field]]
  bool sensitivities = false;
  /// Number of natural modes, and of buckling load factors per load case, to compute; 0: none.
  int modes = 0, buckling = 0;
  /// Whether pressures follow the surface in buckling analyses; otherwise they keep their direction.
  bool follower_pressure = true;
  /// Whether the shell is free, and its inertia balances the loads.
  bool inertia_relief = false;

  std::vector<std::string> cases() const;  ///< names of the load cases, in order of first use
  bool has_density() const;                ///< whether the material, or a ply, has a density
  bool has_expansion() const;              ///< whether the material, or a ply, expands with heat
};

/// The keys that are permitted in [stress].
const std::vector<std::string>& stress_keys();
/// Reads the table [stress] of a scene whose length unit is `unit`. Throws InputError, with the
/// location in the scene, if the table is invalid. `fields`: what formulas may use.
SceneStress read_stress(const TomlTable& table, const std::string& unit,
                        const NamedFields& fields = {});

}  // namespace batten
