#include "batten/apps/commands/shapes/stress_words.h"

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/skinning/region/quality.h"

namespace batten {

std::vector<std::string> lines_named(const ModelLayout& layout, const Scene& scene,
                                     const PlacedWord& line) {
  std::vector<std::string> all, found;
  for (const ModelLine& l : layout.lines()) {
    all.push_back(l.name);
    if (is_part_of(l.name, line.text)) found.push_back(l.name);
  }
  if (found.empty())
    throw InputError(scene.at(line.place) + "found the line '" + line.text + "', expected " +
                     one_of(line.text, all));
  return found;
}

int region_named(const ModelLayout& layout, const Scene& scene, const PlacedWord& region) {
  std::vector<std::string> names;
  for (const auto& r : layout.regions()) {
    if (r->name() == region.text) return count_of(names);
    names.push_back(r->name());
  }
  throw InputError(scene.at(region.place) + "found the region '" + region.text + "', expected " +
                   one_of(region.text, names));
}

void require_one_system(const Scene& scene) {
  const SceneStress& s = *scene.stress;
  const auto refuse = [&](const std::string& what, const std::string& expected) {
    throw InputError(scene.at({}) + "[stress]: found " + what + " in a scene in " + scene.unit +
                     ", expected " + expected);
  };
  constexpr double mpa_at_most = 5e6, tonnes_at_most = 1e-6, pascal_at_least = 1e5,
                   kilograms_at_least = 1e-3;
  if (scene.unit == "mm") {
    if (s.young > mpa_at_most)
      refuse("young = " + number(s.young), "N/mm² (steel: 210000), not Pa");
    if (s.density > tonnes_at_most)
      refuse("density = " + number(s.density), "t/mm³ (steel: 7.85e-9), not kg/m³");
  }
  if (scene.unit == "m") {
    if (s.young < pascal_at_least && s.density > 0)
      refuse("young = " + number(s.young), "Pa (steel: 210e9), not N/mm²");
    if (s.density > 0 && s.density < kilograms_at_least)
      refuse("density = " + number(s.density), "kg/m³ (steel: 7850), not t/mm³");
  }
}

namespace {

ShellPlace place_of(const Scene& scene, const ModelLayout& layout, const Points& shape,
                    const Vec3& point, const FilePlace& at) {
  const ShellPlace place = nearest_place(layout, shape, point);
  constexpr double far = 0.05;  // of the model
  if (place.distance > far * layout.size())
    throw InputError(scene.at(at) + "found a point " + number(place.distance) + " " + scene.unit +
                     " away from the surface, expected one on it or near it");
  return place;
}

void add_support_words(const Scene& scene, const ModelLayout& layout, const Points& shape,
                       const SceneStress::Support& support, ShellDefinition& definition) {
  using Kind = SceneStress::Support::Kind;
  if (support.kind == Kind::Elastic) {
    ElasticSupport springs{support.in_words(), {}, "", -1, support.springs, support.foundation};
    if (support.point)
      springs.place = place_of(scene, layout, shape, *support.point, support.place);
    if (!support.region.text.empty()) springs.region = region_named(layout, scene, support.region);
    if (support.line.text.empty()) {
      definition.elastic.push_back(springs);
      return;
    }
    for (const std::string& line : lines_named(layout, scene, support.line)) {
      springs.line = line;
      definition.elastic.push_back(springs);
    }
    return;
  }
  const bool all = support.kind == Kind::Clamped || support.kind == Kind::Pinned;
  const std::vector<Vec3> directions =
      all ? std::vector<Vec3>{Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()} : support.directions;
  if (support.point) {
    definition.points.push_back({support.in_words(),
                                 place_of(scene, layout, shape, *support.point, support.place),
                                 directions, support.displacement});
    return;
  }
  for (const std::string& line : lines_named(layout, scene, support.line))
    definition.lines.push_back(
        {support.in_words(), line, directions, support.displacement, support.rotation});
}

Points load_of(const Scene& scene, const ModelLayout& layout, const Points& shape,
               const ShellDefinition& definition, const SceneStress::Load& load) {
  using Type = SceneStress::Load::Type;
  std::vector<int> regions;
  if (!load.region.text.empty()) regions = {region_named(layout, scene, load.region)};
  const Vec3 v = load.vector;
  const double value = load.value, level = load.level;
  const auto along_lines = [&](const auto& one) {
    Points sum = Points::Zero(shape.rows(), 3);
    for (const std::string& line : lines_named(layout, scene, load.line)) sum += one(line);
    return sum;
  };
  switch (load.type) {
    case Type::Pressure:
      return area_force(
          layout, shape, [=](const Vec3&, const Vec3& n) -> Vec3 { return value * n; }, regions);
    case Type::AreaForce:
      return area_force(
          layout, shape, [=](const Vec3&, const Vec3&) { return v; }, regions);
    case Type::Hydrostatic:
      return area_force(
          layout, shape,
          [=](const Vec3& x, const Vec3& n) -> Vec3 {
            return value * std::max(0.0, level - x.z()) * n;
          },
          regions);
    case Type::Gravity: {
      Points sum = Points::Zero(shape.rows(), 3);
      for (int r = 0; r < layout.region_count(); ++r) {
        const ShellSection& s = definition.sections[definition.sections.size() == 1 ? 0 : r];
        const Vec3 weight = s.material.density * s.thickness * v;
        sum += area_force(layout, shape, [=](const Vec3&, const Vec3&) { return weight; }, {r});
      }
      return sum;
    }
    case Type::Point:
      return point_force(layout, place_of(scene, layout, shape, load.point, load.place), v);
    case Type::LineForce:
      return along_lines([&](const std::string& line) { return line_force(layout, line, v); });
    case Type::LineMoment:
      return along_lines(
          [&](const std::string& line) { return line_moment(layout, shape, line, value); });
  }
  return {};
}

}  // namespace

ShellDefinition shell_of(const Scene& scene, const ModelLayout& layout, const Points& shape) {
  const SceneStress& s = *scene.stress;
  ShellDefinition definition;
  const ShellMaterial material =
      s.young_across > 0
          ? ShellMaterial::orthotropic(s.young, s.young_across, s.poisson, s.shear, s.density)
          : ShellMaterial::isotropic(s.young, s.poisson, s.density);
  definition.sections = {{material, s.thickness, s.along}};
  if (!s.thicknesses.empty()) {
    definition.sections.assign(static_cast<size_t>(layout.region_count()), definition.sections[0]);
    for (const auto& of : s.thicknesses)
      definition.sections[region_named(layout, scene, of.region)].thickness = of.thickness;
  }
  for (const SceneStress::Support& support : s.supports)
    add_support_words(scene, layout, shape, support, definition);
  for (const PlacedWord& hinge : s.hinges)
    for (const std::string& line : lines_named(layout, scene, hinge)) {
      if (layout.model_line(line).sides.size() < 2)
        throw InputError(scene.at(hinge.place) + "found the hinge '" + line +
                         "', which is a rim, expected a line of two regions");
      definition.hinges.push_back(line);
    }
  return definition;
}

std::map<std::string, Points> loads_of(const Scene& scene, const ModelLayout& layout,
                                       const Points& shape, const ShellDefinition& definition) {
  std::map<std::string, Points> loads;
  for (const SceneStress::Load& load : scene.stress->loads) {
    Points& sum = loads.try_emplace(load.load_case, Points::Zero(shape.rows(), 3)).first->second;
    sum += load_of(scene, layout, shape, definition, load);
  }
  return loads;
}

}  // namespace batten
