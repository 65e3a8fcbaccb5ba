// SPDX-License-Identifier: MPL-2.0
// Materials and plies in the table [stress] of a scene.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "batten/io/files/toml_table.h"

namespace batten {

/// A built-in material, in SI units. The values are converted to the units of the scene.
struct NamedMaterial {
  const char* name;
  /// Young's modulus in Pa, Poisson's ratio, density in kg/m³, thermal expansion per K.
  double young, poisson, density, expansion;
  const char* source;
};
/// The built-in materials, which the key `material` of a scene can name.
const std::vector<NamedMaterial>& named_materials();

/// A material of a shell, in the units of the scene.
struct SceneMaterial {
  /// Strengths along direction 1 and across it, and in shear, all above 0.
  struct Strength {
    std::array<double, 2> tension, compression;
    double shear = 0;
  };
  std::string name;  ///< of a built-in material, or of an entry of `materials`; empty: none
  double young = 0, poisson = 0, density = 0;
  /// Orthotropic material: Young's modulus perpendicular to direction 1, that of the modulus `young`,
  /// and shear modulus. 0: isotropic material.
  double young_across = 0, shear = 0;
  std::array<double, 2> expansion = {};  ///< thermal expansion along direction 1 and across it
  std::optional<Strength> strength;
  bool is_orthotropic() const { return young_across > 0; }
};

/// A ply of a laminate.
struct ScenePly {
  SceneMaterial material;
  double thickness = 0;
  double angle = 0;  ///< in degrees from the direction of the section, about the normal
};

/// The keys of a material: those that read_material() reads.
const std::vector<std::string>& material_keys();
/// Reads the material of [stress], or of an entry of its `materials`, in a scene whose length unit is
/// `unit`. Throws InputError, with the location in the scene.
SceneMaterial read_material(const TomlTable& table, const std::string& unit);
/// Reads the plies of [stress] from the keys `plies`, or `layup` and `ply_thickness`, and `materials`,
/// from the bottom to the top; empty: the shell is not layered. Throws InputError, with the location
/// in the scene.
std::vector<ScenePly> read_plies(const TomlTable& table, const std::string& unit);

/// The angles of a stacking sequence in degrees, such as "[0/45/-45/90]s": angles between slashes;
/// "±45" stands for 45/-45 and "+-45" too, "90_2" for 90/90; after the bracket, a number repeats the
/// sequence, and `s` mirrors it, so that the laminate is symmetric. The brackets may be left out. Throws
/// InputError without a location.
std::vector<double> stacking_angles(const std::string& text);

}  // namespace batten
