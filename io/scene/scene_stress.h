// [stress] of a scene: what its shell is made of, what holds it, what acts on it.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/geometry.h"
#include "batten/io/files/toml_table.h"
#include "batten/sculpting/loads/loads.h"

namespace batten {

// The part of a surface that a scene means.

/// Where a load or weight acts: everywhere, `near` a line, or as painted; in the named regions.
struct SceneArea {
  Area area;                           ///< the area without its regions
  LocatedString line;                  ///< name of the line of `near`
  std::vector<LocatedString> regions;  ///< names of regions; none: all regions
};

/// Reads `near` and `radius`, `paint`, `regions`. Throws InputError with the place.
SceneArea read_area(const TomlTable& table);


/// A material by its name, in SI units; mass and force of other units follow from them.
struct NamedMaterial {
  const char* name;
  double young, poisson, density;  ///< Pa, 1, kg/m³
  const char* source;
};
/// The materials that `material` of a scene may name.
const std::vector<NamedMaterial>& named_materials();

/// [stress]: the shell of a scene, for `batten stress` and for CalculiX.
struct SceneStress {
  struct Thickness {
    LocatedString region;  ///< of all of a region; ""
    SceneArea area;        ///< and where it fades from the thickness around it to its own
    double thickness = 0;
  };
  struct Support {
    enum class Kind {
      Clamped,     ///< no displacement, no rotation about the line
      Pinned,      ///< no displacement
      Symmetric,   ///< in the plane with the normal directions[0]
      Prescribed,  ///< displacement in `directions`, and the rotation where `rotation` says so
      Elastic      ///< springs along x, y, z, or along the normal
    };
    Kind kind = Kind::Clamped;
    LocatedString line;
    std::optional<Vec3> point;  ///< in place of a line: the nearest place of the surface
    std::optional<Box3> box;    ///< what lies in it, of the line, the region, or all
    std::vector<Vec3> directions;
    Vec3 displacement = Vec3::Zero();
    bool rotation = false;
    LocatedString region;         ///< of an area: "" for all regions
    Vec3 springs = Vec3::Zero();  ///< of Elastic, or `foundation` per area along the normal
    double foundation = 0;
    SourceLocation location;
    std::string description() const;  ///< "clamped rim", "pinned rim in a box"
  };
  struct Load {
    enum class Type {
      Pressure,     ///< `value` per area along the normal
      AreaForce,    ///< `vector` per area
      Gravity,      ///< the acceleration `vector`
      Hydrostatic,  ///< pressure value · (level - z) below the level
      Point,        ///< the force `vector`
      LineForce,    ///< `vector` per length
      LineMoment    ///< `value` per length
    };
    Type type = Type::Pressure;
    std::string load_case;      ///< the case that it belongs to
    LocatedString region;       ///< "": all regions
    std::optional<Box3> box;    ///< what lies in it only
    LocatedString line;         ///< of LineForce and LineMoment
    Vec3 point = Vec3::Zero();  ///< of Point
    double value = 0, level = 0;
    Vec3 vector = Vec3::Zero();
    SourceLocation location;
  };
  /// Cases times factors, summed.
  struct Combination {
    std::string name;
    std::vector<std::pair<LocatedString, double>> parts;
  };

  std::string material;  ///< its name; "": the numbers below were stated
  double young = 0, poisson = 0, density = 0;
  /// Of an orthotropic material: Young's modulus across `along`, the shear modulus; 0: isotropic.
  double young_across = 0, shear = 0;
  Vec3 along = Vec3::Zero();
  double thickness = 0, yield = 0;  ///< yield: 0 when not stated
  std::vector<Thickness> thicknesses;
  std::vector<Support> supports;
  std::vector<Load> loads;
  std::vector<Combination> combinations;
  std::vector<LocatedString> hinges;
  bool sensitivities = false;
  int modes = 0, buckling = 0;  ///< how many natural modes, and buckling factors of each case

  std::vector<std::string> cases() const;  ///< names of load cases, in their order
};

/// The keys of [stress].
const std::vector<std::string>& stress_keys();
/// Reads [stress] of a scene with lengths in `unit`. Throws InputError with the place.
SceneStress read_stress(const TomlTable& table, const std::string& unit);

}  // namespace batten
