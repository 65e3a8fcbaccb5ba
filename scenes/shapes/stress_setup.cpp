// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/shapes/stress_setup.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <utility>

#include "batten/analysis/models/inertia_relief.h"
#include "batten/core/errors.h"
#include "batten/scenes/shapes/stress_places.h"
#include "batten/sculpting/loads/loads.h"

namespace batten {

namespace {

// Throws InputError, with the location in the scene, for inconsistent units.
void require_consistent_units(const Scene& scene) {
  const SceneStress& stress = *scene.stress;
  const auto refuse = [&](const std::string& what, const std::string& expected) {
    throw InputError(scene.at({}) + "[stress]: found " + what + " in a scene in " + scene.unit +
                     ", expected " + expected);
  };
  std::vector<SceneMaterial> materials;
  for (const ScenePly& ply : stress.plies) materials.push_back(ply.material);
  if (materials.empty()) materials.push_back(stress.material);
  for (const SceneStress::Stiffener& stiffener : stress.stiffeners)
    materials.push_back(stiffener.material);
  constexpr double mpa_at_most = 5e6, tonnes_at_most = 1e-6, pascal_at_least = 1e5,
                   kilograms_at_least = 1e-3;
  for (const SceneMaterial& s : materials) {
    if (scene.unit == "mm") {
      if (s.young > mpa_at_most)
        refuse("young = " + format_number(s.young), "N/mm² (steel: 210000), not Pa");
      if (s.density > tonnes_at_most)
        refuse("density = " + format_number(s.density), "t/mm³ (steel: 7.85e-9), not kg/m³");
    }
    if (scene.unit == "m") {
      if (s.young < pascal_at_least && s.density > 0)
        refuse("young = " + format_number(s.young), "Pa (steel: 210e9), not N/mm²");
      if (s.density > 0 && s.density < kilograms_at_least)
        refuse("density = " + format_number(s.density), "kg/m³ (steel: 7850), not t/mm³");
    }
  }
}

// The areas of a scene's area: one per segment of a split line.
std::vector<Area> areas_of(const Scene& scene, const ModelLayout& layout, const SceneArea& area) {
  Area common = area.area;
  for (const LocatedString& region : area.regions) {
    find_region(layout, scene, region);
    common.regions.push_back(region.text);
  }
  auto* near = std::get_if<Area::NearLine>(&common.where);
  if (!near) return {common};
  std::vector<Area> areas;
  for (const std::string& line : find_lines(layout, scene, area.line)) {
    near->line = line;
    areas.push_back(common);
  }
  return areas;
}

void add_support(const Scene& scene, const ModelLayout& layout, const Points& shape,
                 const SceneStress::Support& support, ShellDefinition& definition) {
  using Kind = SceneStress::Support::Kind;
  const ShellPart part = part_of(scene, layout, support.region, support.box);
  if (support.kind == Kind::Elastic) {
    ElasticSupport springs{support.description(), {}, "", part, support.springs,
                           support.foundation};
    if (support.point)
      springs.position = place_of(scene, layout, shape, *support.point, support.location);
    if (support.line.text.empty()) {
      definition.elastic.push_back(springs);
      return;
    }
    for (const std::string& line : find_lines(layout, scene, support.line)) {
      springs.line = line;
      definition.elastic.push_back(springs);
    }
    return;
  }
  std::optional<CylindricalAxes> axes;
  if (support.axis) axes = {support.origin, *support.axis};
  const bool all = support.kind == Kind::Clamped || support.kind == Kind::Pinned;
  const std::vector<Vec3> directions =
      all ? std::vector<Vec3>{Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()} : support.directions;
  if (support.point) {
    definition.points.push_back({support.description(),
                                 place_of(scene, layout, shape, *support.point, support.location),
                                 directions, support.displacement, axes});
    return;
  }
  if (support.line.text.empty()) {
    definition.areas.push_back(
        {support.description(), part, directions, support.displacement, axes});
    return;
  }
  for (const std::string& line : find_lines(layout, scene, support.line))
    definition.lines.push_back({support.description(), line, directions, support.displacement,
                                support.rotation, support.box, axes});
}

/// The temperature of a load at the vertices of the model's mesh; 0 on other faces.
ShellTemperature temperature_of(const Scene& scene, const ModelLayout& layout, const Points& shape,
                                const SceneStress::Load& load) {
  const ParametricMesh& mesh = *layout.mesh();
  const VecX none = VecX::Zero(mesh.vertex_count());
  ShellTemperature temperature{none, none};
  const int region = load.region.text.empty() ? -1 : find_region(layout, scene, load.region);
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    if (region >= 0 && layout.region_of(t) != region) continue;
    for (const int v : mesh.triangles()[t]) {
      const Vec3 x = shape.row(3L * v).transpose();
      const auto value = [&](const std::optional<Formula>& formula) {
        return formula ? at_load(scene, load, [&] { return (*formula)(x); }) : 0.0;
      };
      temperature.middle[v] = value(load.temperature);
      temperature.difference[v] = value(load.temperature_difference);
    }
  }
  return temperature;
}

Points thermal_load(const ModelLayout& layout, const Points& shape,
                    const ShellDefinition& definition, const ShellTemperature& temperature) {
  const ShellAssembler assembler(layout.surface(shape), triangle_sections(layout, definition));
  Points F = assembler.thermal_load(temperature);
  const Stiffeners stiffeners(layout, shape, definition.stiffeners);
  if (!stiffeners.empty()) F += stiffeners.thermal_load(temperature);
  return F;
}

Points load_of(const Scene& scene, const ModelLayout& layout, const Points& shape,
               const ShellDefinition& definition, const SceneStress::Load& load) {
  using Type = SceneStress::Load::Type;
  const ShellPart part = part_of(scene, layout, load.region, load.box);
  const Vec3 v = load.vector;
  const double value = load.value, level = load.level;
  const LineIntensity intensity = [&](const Vec3& x) { return value_of(scene, load, x); };
  const auto along_lines = [&](const auto& one) {
    Points sum = Points::Zero(shape.rows(), 3);
    for (const std::string& line : find_lines(layout, scene, load.line)) sum += one(line);
    return sum;
  };
  switch (load.type) {
    case Type::Pressure:
      return surface_traction(
          layout, shape,
          [&](const Vec3& x, const Vec3& n) -> Vec3 { return value_of(scene, load, x) * n; }, part);
    case Type::AreaForce:
      return surface_traction(
          layout, shape, [&](const Vec3& x, const Vec3&) { return vector_of(scene, load, x); },
          part);
    case Type::Hydrostatic:
      return surface_traction(
          layout, shape,
          [=](const Vec3& x, const Vec3& n) -> Vec3 {
            return value * std::max(0.0, level - x.z()) * n;
          },
          part);
    case Type::Gravity:
      return body_load(layout, shape, definition, [&](const Vec3&) { return v; });
    case Type::Point:
      return point_force(layout, place_of(scene, layout, shape, load.point, load.location), v);
    case Type::LineForce:
      return along_lines([&](const std::string& line) {
        return line_force(layout, shape, line,
                          LineTraction([&](const Vec3& x) { return vector_of(scene, load, x); }),
                          load.box);
      });
    case Type::LineMoment:
      return along_lines([&](const std::string& line) {
        return line_moment(layout, shape, line, intensity, load.box);
      });
    case Type::EdgeForce:
      return along_lines([&](const std::string& line) {
        return edge_force(layout, shape, line, intensity, load.box);
      });
    case Type::Total:
      return spread_load(
          layout, shape,
          [&](const LineTraction& f) {
            if (load.line.text.empty())
              return surface_traction(
                  layout, shape, [&](const Vec3& x, const Vec3&) { return f(x); }, part);
            return along_lines([&](const std::string& line) {
              return line_force(layout, shape, line, f, load.box);
            });
          },
          v, load.moment);
    case Type::Temperature:
      return thermal_load(layout, shape, definition, temperature_of(scene, layout, shape, load));
    case Type::Spin:
      return body_load(layout, shape, definition, [&](const Vec3& x) -> Vec3 {
        const Vec3 r = x - load.origin;
        return value * value * (r - r.dot(load.axis) * load.axis);
      });
  }
  return {};
}

// Applies the thicknesses of regions, then those of blended areas, in order.
void set_thicknesses(const Scene& scene, const ModelLayout& layout, const Points& shape,
                     ShellDefinition& definition) {
  const auto& stated = scene.stress->thicknesses;
  if (stated.empty()) return;
  definition.sections.assign(static_cast<size_t>(layout.region_count()), definition.sections[0]);
  for (const auto& of : stated)
    if (!of.region.text.empty())
      definition.sections[find_region(layout, scene, of.region)].thickness = of.thickness;
  const Surface surface = layout.surface(shape);
  const ParametricMesh& mesh = surface.mesh();
  const VecX none = VecX::Zero(mesh.vertex_count());
  VecX base = none, all;
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (const int v : mesh.triangles()[t])
      base[v] = definition.sections[layout.region_of(t)].thickness;
  all = base;
  for (const auto& of : stated) {
    if (!of.region.text.empty()) continue;
    for (const Area& area : areas_of(scene, layout, of.area)) {
      const VecX weights = triangle_weights(area, layout, surface);
      VecX sum = none, count = none;
      for (int t = 0; t < mesh.triangle_count(); ++t)
        for (const int v : mesh.triangles()[t]) {
          sum[v] += weights[t];
          count[v] += 1;
        }
      for (long v = 0; v < all.size(); ++v)
        if (count[v] > 0) all[v] += sum[v] / count[v] * (of.thickness - all[v]);
    }
  }
  if (all != base) definition.nodal_thickness_offset = all - base;
}

ShellMaterial shell_material(const SceneMaterial& m) {
  ShellMaterial material =
      m.is_orthotropic()
          ? ShellMaterial::orthotropic(m.young, m.young_across, m.poisson, m.shear, m.density)
          : ShellMaterial::isotropic(m.young, m.poisson, m.density);
  material.expansion = {m.expansion[0], m.expansion[1]};
  if (m.strength)
    material.strength = {m.strength->tension[0], m.strength->compression[0], m.strength->tension[1],
                         m.strength->compression[1], m.strength->shear};
  return material;
}

ShellSection shell_section(const SceneStress& stress) {
  std::vector<Ply> plies;
  for (const ScenePly& ply : stress.plies)
    plies.push_back(
        {shell_material(ply.material), ply.thickness, ply.angle * std::numbers::pi / 180});
  ShellSection section;
  if (plies.empty())
    section = {shell_material(stress.material), stress.thickness, stress.along};
  else
    section = ShellSection::of_plies(std::move(plies), stress.along);
  section.offset = stress.offset;
  return section;
}

StiffenerSection stiffener_section(const SceneStress::Stiffener& of, const ShellSection& shell) {
  using Shape = SceneStress::Stiffener::Shape;
  const std::vector<double>& d = of.dimensions;
  StiffenerSection section;
  if (of.shape == Shape::Numbers) {
    section.area = d[0];
    section.inertia = d[1];
    section.lateral_inertia = d[2];
    section.torsion = d[3];
    section.eccentricity = d[4];
  } else {
    section = of.shape == Shape::Rectangle ? StiffenerSection::rectangle(d[0], d[1])
              : of.shape == Shape::Circle  ? StiffenerSection::circle(d[0])
              : of.shape == Shape::Tube    ? StiffenerSection::tube(d[0], d[1])
                                           : StiffenerSection::tee(d[0], d[1], d[2], d[3]);
    section = section.on_side(of.side, (shell.offset + of.side / 2) * shell.thickness);
  }
  section.young = of.material.young;
  section.shear_modulus = of.material.young / (2 * (1 + of.material.poisson));
  section.density = of.material.density;
  section.expansion = of.material.expansion[0];
  return section;
}

void add_stiffeners(const Scene& scene, const ModelLayout& layout, ShellDefinition& definition) {
  for (const SceneStress::Stiffener& of : scene.stress->stiffeners)
    for (const std::string& line : find_lines(layout, scene, of.line)) {
      const int region = layout.model_line(line).sides[0].region;
      const auto& sections = definition.sections;
      const ShellSection& shell = sections[sections.size() == 1 ? 0 : static_cast<size_t>(region)];
      try {
        definition.stiffeners.push_back({of.name, line, stiffener_section(of, shell)});
      } catch (const InputError& e) {
        throw InputError(scene.at(of.line.location) + e.what());
      }
    }
}

/// A field that is much larger or smaller than the model has another unit.
void require_similar_sizes(const Scene& scene, const ModelLayout& layout) {
  constexpr double most = 50;
  for (const auto& [name, field] : scene.stress->fields)
    if (const double ratio = field.size() / layout.size(); ratio > most || ratio < 1 / most)
      throw InputError(scene.at({}) + "[[field]] '" + name + "': found values over " +
                       format_number(field.size()) + " " + scene.unit + " for a surface of " +
                       format_number(layout.size()) + " " + scene.unit +
                       ", expected similar sizes: check the unit of the file");
}

ShellDefinition shell_definition(const Scene& scene, const ModelLayout& layout,
                                 const Points& shape) {
  const SceneStress& s = *scene.stress;
  require_similar_sizes(scene, layout);
  ShellDefinition definition;
  definition.sections = {shell_section(s)};
  definition.inertia_relief = s.inertia_relief;
  set_thicknesses(scene, layout, shape, definition);
  for (const SceneStress::Support& support : s.supports)
    add_support(scene, layout, shape, support, definition);
  add_stiffeners(scene, layout, definition);
  for (const LocatedString& curve : s.rigid_curves)
    for (const std::string& line : find_lines(layout, scene, curve))
      definition.rigid_lines.push_back(line);
  for (const SceneStress::Mass& mass : s.masses)
    definition.masses.push_back(
        {place_of(scene, layout, shape, mass.point, mass.location), mass.mass});
  for (const LocatedString& hinge : s.hinges)
    for (const std::string& line : find_lines(layout, scene, hinge)) {
      if (layout.model_line(line).sides.size() < 2)
        throw InputError(scene.at(hinge.location) + "found the hinge '" + line +
                         "', which is a free edge, expected an edge of two faces");
      definition.hinges.push_back(line);
    }
  return definition;
}

void add(const ShellTemperature& temperature, double factor, ShellTemperature& sum) {
  if (temperature.empty()) return;
  if (sum.empty()) sum.middle = sum.difference = VecX::Zero(temperature.middle.size());
  sum.middle += factor * temperature.middle;
  sum.difference += factor * temperature.difference;
}

// Adds `factor` times a load case to another one.
void add(const ShellLoadCase& load_case, double factor, ShellLoadCase& sum) {
  sum.load += factor * load_case.load;
  add(load_case.temperature, factor, sum.temperature);
  if (load_case.follower.size() == 0) return;
  if (sum.follower.size() == 0)
    sum.follower = factor * load_case.follower;
  else
    sum.follower += factor * load_case.follower;
}

// A pressure and its gradient; of a formula, by central differences.
PressureAt pressure_at(const Scene& scene, const SceneStress::Load& load, const Vec3& x,
                       double step) {
  PressureAt at{value_of(scene, load, x), Vec3::Zero()};
  if (load.formulas.empty()) return at;
  for (int c = 0; c < 3; ++c) {
    const Vec3 h = step * Vec3::Unit(c);
    at.gradient[c] = (value_of(scene, load, x + h) - value_of(scene, load, x - h)) / (2 * step);
  }
  return at;
}

// The stiffness of a pressure that follows the surface; empty for other loads.
SparseMatrix follower_of(const Scene& scene, const ModelLayout& layout, const Points& shape,
                         const SceneStress::Load& load) {
  using Type = SceneStress::Load::Type;
  const double value = load.value, level = load.level;
  const ShellPart part = part_of(scene, layout, load.region, load.box);
  constexpr double of_size = 1e-5;  // step of differences
  const double step = of_size * layout.size();
  if (load.type == Type::Pressure)
    return follower_stiffness(
        layout, shape, [&](const Vec3& x) { return pressure_at(scene, load, x, step); }, part);
  if (load.type == Type::Hydrostatic)
    return follower_stiffness(
        layout, shape,
        [=](const Vec3& x) {
          const double depth = level - x.z();
          return depth > 0 ? PressureAt{value * depth, -value * Vec3::UnitZ()} : PressureAt{};
        },
        part);
  return {};
}

std::map<std::string, ShellLoadCase> case_loads(const Scene& scene, const ModelLayout& layout,
                                                const Points& shape,
                                                const ShellDefinition& definition) {
  const bool follows = scene.stress->buckling > 0 && scene.stress->follower_pressure;
  std::map<std::string, ShellLoadCase> loads;
  for (const SceneStress::Load& load : scene.stress->loads) {
    const ShellLoadCase none{load.load_case, Points::Zero(shape.rows(), 3)};
    ShellLoadCase& sum = loads.try_emplace(load.load_case, none).first->second;
    try {
      ShellLoadCase one{load.load_case, load_of(scene, layout, shape, definition, load)};
      if (load.type == SceneStress::Load::Type::Temperature)
        one.temperature = temperature_of(scene, layout, shape, load);
      if (follows) one.follower = follower_of(scene, layout, shape, load);
      add(one, 1, sum);
    } catch (const EmptyPartError& e) {
      throw InputError(scene.at(load.location) + e.what());
    }
  }
  return loads;
}

// Balances the loads of a free shell by its inertia.
void balance(const ModelLayout& layout, const Points& shape, const ShellDefinition& definition,
             std::vector<ShellLoadCase>& cases) {
  const ShellAssembler assembler(layout.surface(shape), triangle_sections(layout, definition));
  const InertiaRelief relief(layout, shape, mass_matrix(layout, shape, definition, assembler));
  for (ShellLoadCase& one : cases) one.load = relief.balanced(one.load);
}

std::vector<ShellLoadCase> load_cases(const Scene& scene, const ModelLayout& layout,
                                      const Points& shape, const ShellDefinition& definition) {
  const auto loads = case_loads(scene, layout, shape, definition);
  std::vector<ShellLoadCase> cases;
  for (const std::string& name : scene.stress->cases()) cases.push_back(loads.at(name));
  for (const SceneStress::Combination& sum : scene.stress->combinations) {
    cases.push_back({sum.name, Points::Zero(shape.rows(), 3)});
    for (const auto& [load_case, factor] : sum.parts)
      add(loads.at(load_case.text), factor, cases.back());
  }
  if (cases.empty())  // prescribed displacements only
    cases.push_back({"supports", Points::Zero(shape.rows(), 3)});
  if (definition.inertia_relief) balance(layout, shape, definition, cases);
  for (ShellLoadCase& one : cases)
    for (const SceneStress::Load& load : scene.stress->loads)
      if (load.type == SceneStress::Load::Type::Point) one.singular_points.push_back(load.point);
  return cases;
}

}  // namespace

void require_differentiable(const Scene& scene) {
  const auto refuse = [&](const auto& entry, const std::string& what) {
    if (entry.box)
      throw InputError(
          scene.at(entry.location) + "found a " + what +
          " limited by a box, expected one on a whole face or curve, or without a box: "
          "the box selects other elements when the shape changes, so that there are no "
          "derivatives");
  };
  if (scene.stress->inertia_relief)
    throw InputError(
        "derivatives of a shell with inertia_relief are not implemented, expected "
        "supports");
  for (const SceneStress::Support& support : scene.stress->supports) refuse(support, "support");
  for (const SceneStress::Load& load : scene.stress->loads) refuse(load, "load");
}

ShellProblem shell_problem(const Scene& scene) {
  return {
      [&scene](const ModelLayout& layout, const Points& shape) {
        require_consistent_units(scene);
        return shell_definition(scene, layout, shape);
      },
      [&scene](const ModelLayout& layout, const Points& shape, const ShellDefinition& definition) {
        return load_cases(scene, layout, shape, definition);
      }};
}

}  // namespace batten
