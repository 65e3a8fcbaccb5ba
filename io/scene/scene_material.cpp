// SPDX-License-Identifier: MPL-2.0
#include "batten/io/scene/scene_material.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

namespace batten {

const std::vector<NamedMaterial>& named_materials() {
  static const std::vector<NamedMaterial> materials = {
      {"steel", 210e9, 0.3, 7850, 12e-6, "EN 1993-1-1, 3.2.6"},
      {"stainless steel", 200e9, 0.3, 7900, 16e-6, "EN 1993-1-4, 2.1.3; 1.4301"},
      {"aluminium", 70e9, 0.3, 2700, 23e-6, "EN 1999-1-1, 3.2.5"},
      {"titanium", 114e9, 0.34, 4430, 8.6e-6, "Ti-6Al-4V, MMPDS-01"},
      {"glass", 70e9, 0.23, 2500, 9e-6, "EN 572-1"},
      {"concrete", 33e9, 0.2, 2500, 10e-6, "C30/37, EN 1992-1-1, table 3.1 and 3.1.3"},
  };
  return materials;
}

const std::vector<std::string>& material_keys() {
  static const std::vector<std::string> keys = {"material", "young",     "poisson", "shear_modulus",
                                                "density",  "expansion", "strength"};
  return keys;
}

namespace {

SceneMaterial named_material(const TomlTable& table, const std::string& unit) {
  SceneMaterial material;
  material.name = table.text("material");
  std::vector<std::string> names;
  for (const NamedMaterial& m : named_materials()) names.emplace_back(m.name);
  const auto known = std::find(names.begin(), names.end(), material.name);
  if (known == names.end())
    table.fail("material", "the material '" + material.name + "'",
               expected_one_of(material.name, names) + ", or 'young', 'poisson' and 'density'");
  const NamedMaterial& m = named_materials()[static_cast<size_t>(known - names.begin())];
  material.poisson = m.poisson;
  material.expansion = {m.expansion, m.expansion};
  if (unit == "m") {
    material.young = m.young;
    material.density = m.density;
  } else if (unit == "mm") {  // forces in N, masses in t
    material.young = 1e-6 * m.young;
    material.density = 1e-12 * m.density;
  } else {
    table.fail("material", "a material by name in a scene in " + unit,
               "a scene in mm (N, t, MPa) or m (N, kg, Pa); or 'young' and 'density' in your own");
  }
  return material;
}

/// One number, or two: along direction 1 and across it.
std::array<double, 2> along_and_across(const TomlTable& table, const std::string& key) {
  if (!table.is_array(key)) return {table.number(key), table.number(key)};
  const VecX both = table.numbers(key, "along, across");
  return {both[0], both[1]};
}

std::optional<SceneMaterial::Strength> read_strength(const TomlTable& table) {
  if (!table.has("strength")) return {};
  const TomlTable t = table.table("strength", {"tension", "compression", "shear"}).at(0);
  SceneMaterial::Strength strength{along_and_across(t, "tension"),
                                   along_and_across(t, "compression"), t.positive("shear")};
  for (const char* key : {"tension", "compression"})
    for (const double value : along_and_across(t, key))
      if (!(value > 0))
        t.fail(key, format_number(value), "a stress above 0, or two: [along, across]");
  return strength;
}

void read_moduli(const TomlTable& table, SceneMaterial& material) {
  if (table.is_array("young")) {
    const VecX moduli = table.numbers("young", "along, across");
    if (!(moduli.minCoeff() > 0))
      table.fail("young", "a modulus that is not above 0", "both above 0");
    material.young = moduli[0];
    material.young_across = moduli[1];
    material.shear = table.positive("shear_modulus");
  } else {
    material.young = table.positive("young");
    if (table.has("shear_modulus"))
      table.fail("shear_modulus", "'shear_modulus' of an isotropic material",
                 "young = [along, across] with it");
  }
  material.poisson = table.number("poisson", 0.3);
  if (material.poisson <= -1 || material.poisson >= 0.5)
    table.fail("poisson", format_number(material.poisson), "a number above -1 and below 0.5");
  material.density = table.positive("density", 0);
}

}  // namespace

SceneMaterial read_material(const TomlTable& table, const std::string& unit) {
  SceneMaterial material;
  if (table.has("material")) {
    for (const char* key : {"young", "poisson", "density", "shear_modulus"})
      if (table.has(key))
        table.fail(key, "'" + std::string(key) + "' beside 'material'", "one of the two");
    material = named_material(table, unit);
  } else {
    read_moduli(table, material);
  }
  if (table.has("expansion")) material.expansion = along_and_across(table, "expansion");
  material.strength = read_strength(table);
  return material;
}

namespace {

/// The number that a whole text is.
std::optional<double> number_in(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

/// A number of repetitions.
int repetitions(std::string_view text, const std::string& expected) {
  constexpr double most = 1000;
  const auto times = number_in(text);
  if (!times || *times < 1 || *times > most || *times != std::floor(*times))
    throw InputError("found '" + std::string(text) + "', expected " + expected);
  return static_cast<int>(*times);
}

/// The angles of an entry of a stacking sequence, such as 45, ±45 or 90_2.
std::vector<double> angles_of(std::string_view part) {
  bool both = false;
  for (const std::string_view sign : {std::string_view("±"), std::string_view("+-")})
    if (part.starts_with(sign)) {
      both = true;
      part.remove_prefix(sign.size());
    }
  if (part.starts_with("+")) part.remove_prefix(1);
  int count = 1;
  if (const size_t at = part.find('_'); at != std::string_view::npos) {
    count = repetitions(part.substr(at + 1), "a number of repetitions after '_'");
    part = part.substr(0, at);
  }
  const auto angle = number_in(part);
  if (!angle)
    throw InputError("found '" + std::string(part) +
                     "', expected angles between slashes, such as [0/45/-45/90]s");
  std::vector<double> angles;
  for (int i = 0; i < count; ++i) {
    angles.push_back(*angle);
    if (both) angles.push_back(-*angle);
  }
  return angles;
}

}  // namespace

std::vector<double> stacking_angles(const std::string& text) {
  std::string inside;
  for (const char c : text)
    if (c != ' ' && c != '\t') inside += c;
  std::string after;
  if (inside.starts_with("[")) {
    const size_t end = inside.find(']');
    if (end == std::string::npos) throw InputError("found '[' without ']', expected both");
    after = inside.substr(end + 1);
    inside = inside.substr(1, end - 1);
  }
  bool symmetric = false;
  if (after.ends_with("s") || after.ends_with("S")) {
    symmetric = true;
    after.pop_back();
  }
  if (after.starts_with("_")) after.erase(0, 1);
  const int times = after.empty()
                        ? 1
                        : repetitions(after,
                                      "after ']' a number of repetitions, s for symmetric, or "
                                      "both: [0/90]2s");
  std::vector<double> once;
  for (size_t from = 0; from <= inside.size();) {
    const size_t to = std::min(inside.find('/', from), inside.size());
    for (const double angle : angles_of(std::string_view(inside).substr(from, to - from)))
      once.push_back(angle);
    from = to + 1;
  }
  std::vector<double> all;
  for (int i = 0; i < times; ++i) all.insert(all.end(), once.begin(), once.end());
  if (symmetric) all.insert(all.end(), all.rbegin(), all.rend());
  return all;
}

namespace {

/// The materials of `materials`, and of the plies' keys `material`.
class PlyMaterials {
 public:
  PlyMaterials(const TomlTable& table, const std::string& unit) : table_(table), unit_(unit) {
    std::vector<std::string> keys = material_keys();
    keys.emplace_back("name");
    for (const TomlTable& t : table.tables("materials", keys)) {
      SceneMaterial material = read_material(t, unit);
      material.name = t.text("name");
      for (const SceneMaterial& other : own_)
        if (other.name == material.name)
          t.fail("name", "a second material '" + material.name + "'", "another name");
      own_.push_back(std::move(material));
    }
  }

  SceneMaterial of_ply(const TomlTable& ply) {
    if (!ply.has("material")) {
      if (!common_) common_ = read_material(table_, unit_);
      return *common_;
    }
    const std::string name = ply.text("material");
    std::vector<std::string> names;
    for (const SceneMaterial& material : own_) {
      if (material.name == name) return material;
      names.push_back(material.name);
    }
    for (const NamedMaterial& m : named_materials()) {
      if (m.name == name) return read_material(ply, unit_);
      names.emplace_back(m.name);
    }
    ply.fail("material", "the material '" + name + "'", expected_one_of(name, names));
  }
  SceneMaterial common() { return read_material(table_, unit_); }

 private:
  const TomlTable& table_;
  const std::string& unit_;
  std::vector<SceneMaterial> own_;
  std::optional<SceneMaterial> common_;
};

}  // namespace

std::vector<ScenePly> read_plies(const TomlTable& table, const std::string& unit) {
  std::vector<ScenePly> plies;
  if (table.has("plies") && table.has("layup"))
    table.fail("layup", "both 'plies' and 'layup'", "one of them");
  if (table.has("layup") != table.has("ply_thickness"))
    table.fail(
        table.has("layup") ? "layup" : "ply_thickness",
        table.has("layup") ? "'layup' without 'ply_thickness'" : "'ply_thickness' without 'layup'",
        "layup = \"[0/45/-45/90]s\" and ply_thickness = 0.125");
  PlyMaterials materials(table, unit);
  if (table.has("layup")) {
    const double thickness = table.positive("ply_thickness");
    const SceneMaterial material = materials.common();
    try {
      for (const double angle : stacking_angles(table.text("layup")))
        plies.push_back({material, thickness, angle});
    } catch (const InputError& e) {
      throw InputError(table.at("layup") + e.what());
    }
  }
  for (const TomlTable& t : table.tables("plies", {"material", "thickness", "angle"}))
    plies.push_back({materials.of_ply(t), t.positive("thickness"), t.number("angle", 0)});
  if (table.has("plies") && plies.empty())
    table.fail("plies", "no plies", "one or more: plies = [{thickness = 0.125, angle = 45}, …]");
  return plies;
}

}  // namespace batten
