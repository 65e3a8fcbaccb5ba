#include "batten/apps/commands/shapes/stress_words.h"

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/sculpting/loads/area.h"
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

// The area that a scene means, once for each part of a line that is in parts.
std::vector<Area> areas_of(const Scene& scene, const ModelLayout& layout, const SceneArea& area) {
  Area common = area.area;
  for (const PlacedWord& region : area.regions) {
    region_named(layout, scene, region);
    common.regions.push_back(region.text);
  }
  auto* near = std::get_if<Area::NearLine>(&common.where);
  if (!near) return {common};
  std::vector<Area> areas;
  for (const std::string& line : lines_named(layout, scene, area.line)) {
    near->line = line;
    areas.push_back(common);
  }
  return areas;
}

ShellPlace place_of(const Scene& scene, const ModelLayout& layout, const Points& shape,
                    const Vec3& point, const FilePlace& at) {
  const ShellPlace place = nearest_place(layout, shape, point);
  constexpr double far = 0.05;  // of the model
  if (place.distance > far * layout.size())
    throw InputError(scene.at(at) + "found a point " + number(place.distance) + " " + scene.unit +
                     " away from the surface, expected one on it or near it");
  return place;
}

ShellPart part_of(const Scene& scene, const ModelLayout& layout, const PlacedWord& region,
                  const std::optional<Box3>& box) {
  ShellPart part;
  if (!region.text.empty()) part.regions = {region_named(layout, scene, region)};
  part.box = box;
  return part;
}

void add_support_words(const Scene& scene, const ModelLayout& layout, const Points& shape,
                       const SceneStress::Support& support, ShellDefinition& definition) {
  using Kind = SceneStress::Support::Kind;
  const ShellPart part = part_of(scene, layout, support.region, support.box);
  if (support.kind == Kind::Elastic) {
    ElasticSupport springs{support.in_words(), {}, "", part, support.springs, support.foundation};
    if (support.point)
      springs.place = place_of(scene, layout, shape, *support.point, support.place);
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
  if (support.line.text.empty()) {
    definition.areas.push_back({support.in_words(), part, directions, support.displacement});
    return;
  }
  for (const std::string& line : lines_named(layout, scene, support.line))
    definition.lines.push_back({support.in_words(), line, directions, support.displacement,
                                support.rotation, support.box});
}

Points load_of(const Scene& scene, const ModelLayout& layout, const Points& shape,
               const ShellDefinition& definition, const SceneStress::Load& load) {
  using Type = SceneStress::Load::Type;
  const ShellPart part = part_of(scene, layout, load.region, load.box);
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
          layout, shape, [=](const Vec3&, const Vec3& n) -> Vec3 { return value * n; }, part);
    case Type::AreaForce:
      return area_force(
          layout, shape, [=](const Vec3&, const Vec3&) { return v; }, part);
    case Type::Hydrostatic:
      return area_force(
          layout, shape,
          [=](const Vec3& x, const Vec3& n) -> Vec3 {
            return value * std::max(0.0, level - x.z()) * n;
          },
          part);
    case Type::Gravity:
      return weight(layout, shape, triangle_sections(layout, definition), v);
    case Type::Point:
      return point_force(layout, place_of(scene, layout, shape, load.point, load.place), v);
    case Type::LineForce:
      return along_lines(
          [&](const std::string& line) { return line_force(layout, shape, line, v, load.box); });
    case Type::LineMoment:
      return along_lines([&](const std::string& line) {
        return line_moment(layout, shape, line, value, load.box);
      });
  }
  return {};
}

// Thicknesses of regions, then those that fade from them, one after the other.
void set_thicknesses(const Scene& scene, const ModelLayout& layout, const Points& shape,
                     ShellDefinition& definition) {
  const auto& stated = scene.stress->thicknesses;
  if (stated.empty()) return;
  definition.sections.assign(static_cast<size_t>(layout.region_count()), definition.sections[0]);
  for (const auto& of : stated)
    if (!of.region.text.empty())
      definition.sections[region_named(layout, scene, of.region)].thickness = of.thickness;
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
  if (all != base) definition.more_thickness = all - base;
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
  set_thicknesses(scene, layout, shape, definition);
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
    try {
      sum += load_of(scene, layout, shape, definition, load);
    } catch (const EmptyPartError& e) {
      throw InputError(scene.at(load.place) + e.what());
    }
  }
  return loads;
}

}  // namespace batten
