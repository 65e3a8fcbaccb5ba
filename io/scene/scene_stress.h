// [stress] of a scene: material, thickness, supports and load cases of its shell.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/geometry.h"
#include "batten/io/files/toml_table.h"
#include "batten/sculpting/loads/loads.h"

namespace batten {

// Areas of a surface.

/// Area in which a load or weight acts: everywhere, near a line, or painted; optionally limited to
/// some regions.
struct SceneArea {
  Area area;                           ///< the area, without the restriction to regions
  LocatedString line;                  ///< name of the line of `near`
  std::vector<LocatedString> regions;  ///< names of regions; empty: all regions
};

/// Reads `near` and `radius`, `paint`, `regions`. Throws InputError with the location.
SceneArea read_area(const TomlTable& table);

/// A material of the built-in table, in SI units; other unit systems are derived from them.
struct NamedMaterial {
  const char* name;
  double young, poisson, density;  ///< Pa, 1, kg/m³
  const char* source;
};
/// The materials that `material` of a scene may name.
const std::vector<NamedMaterial>& named_materials();

/// [stress]: the shell of a scene, for `batten stress` and for CalculiX.
struct SceneStress {
  /// A thickness that differs from the default.
  struct Thickness {
    LocatedString region;  ///< face with this thickness; empty: none
    SceneArea area;        ///< alternatively: area in which the thickness blends into this value
    double thickness = 0;
  };
  /// A boundary condition at a curve, a point, a box or an area.
  struct Support {
    enum class Kind {
      Clamped,     ///< no displacement, no rotation about the curve
      Pinned,      ///< no displacement (simply supported)
      Symmetric,   ///< symmetry plane with the normal directions[0]
      Prescribed,  ///< displacement in `directions`; also the rotation, if `rotation` is set
      Elastic      ///< springs along x, y, z, or along the normal
    };
    Kind kind = Kind::Clamped;
    LocatedString line;
    std::optional<Vec3> point;  ///< alternative to a curve: the nearest point of the surface
    std::optional<Box3> box;    ///< limits the curve, the face or the whole model to this box
    std::vector<Vec3> directions;
    Vec3 displacement = Vec3::Zero();
    bool rotation = false;
    LocatedString region;         ///< area support: name of the region; empty: all
    Vec3 springs = Vec3::Zero();  ///< Elastic: spring stiffness along x, y, z
    /// Elastic: stiffness per area along the normal (Winkler foundation).
    double foundation = 0;
    SourceLocation location;
    std::string description() const;  ///< "clamped rim", "pinned rim in a box"
  };
  /// A load of one load case.
  struct Load {
    enum class Type {
      Pressure,     ///< `value` per area along the normal
      AreaForce,    ///< `vector` per area (surface traction)
      Gravity,      ///< `vector`: the acceleration
      Hydrostatic,  ///< pressure value · (level − z) below the level
      Point,        ///< `vector`: the force
      LineForce,    ///< `vector` per length
      LineMoment    ///< `value` per length
    };
    Type type = Type::Pressure;
    std::string load_case;      ///< name of its load case
    LocatedString region;       ///< empty: all regions
    std::optional<Box3> box;    ///< limits the load to this box
    LocatedString line;         ///< LineForce and LineMoment: name of the line
    Vec3 point = Vec3::Zero();  ///< Point: point of application
    double value = 0, level = 0;
    Vec3 vector = Vec3::Zero();
    SourceLocation location;
  };
  /// A linear combination of load cases.
  struct Combination {
    std::string name;
    std::vector<std::pair<LocatedString, double>> parts;
  };

  std::string material;  ///< name; empty: the constants below are given
  double young = 0, poisson = 0, density = 0;
  /// Orthotropic material: Young's modulus perpendicular to `along`, and shear modulus; 0:
  /// isotropic.
  double young_across = 0, shear = 0;
  Vec3 along = Vec3::Zero();
  double thickness = 0, yield = 0;  ///< yield: yield stress; 0: not given
  std::vector<Thickness> thicknesses;
  std::vector<Support> supports;
  std::vector<Load> loads;
  std::vector<Combination> combinations;
  std::vector<LocatedString> hinges;
  bool sensitivities = false;
  int modes = 0, buckling = 0;  ///< number of natural modes, and of buckling factors per load case

  std::vector<std::string> cases() const;  ///< names of load cases, in order
};

/// Permitted keys of [stress].
const std::vector<std::string>& stress_keys();
/// Reads [stress] of a scene with lengths in `unit`. Throws InputError with the location.
SceneStress read_stress(const TomlTable& table, const std::string& unit);

}  // namespace batten
