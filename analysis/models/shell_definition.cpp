#include "batten/analysis/models/shell_definition.h"

#include <algorithm>

#include "batten/analysis/models/elastic_supports.h"
#include "batten/analysis/models/line_rotation.h"
#include "batten/analysis/models/line_sides.h"
#include "batten/analysis/models/part_quadrature.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

void add_point_support(const ModelLayout& model, const PointSupport& support, ConstraintSet& set) {
  const ConstraintEntries position = shape_functions_at(model, support.position.where);
  for (const Vec3& unit : unit_directions(support.name, support.directions))
    add_summed(support.name, along(unit, position), unit.dot(support.displacement), set);
}

void add_area_support(const ModelLayout& model, const Points& shape,
                      const std::vector<ShellSection>& sections, const AreaSupport& support,
                      ShellSprings& springs) {
  const std::vector<Vec3> directions = unit_directions(support.name, support.directions);
  const Surface surface = model.surface(shape);
  constexpr int degree = 4;
  bool any = false;
  const TabulatedRule whole(surface.kind(), symmetric_triangle_rule(degree + 2));
  for_each_part_point(model, surface, support.part, whole, degree, [&](const PartPoint& at) {
    any = true;
    if (!(at.area.norm() > 0)) return;
    const int r = model.region_of(at.where.triangle);
    const SpringStiffness k(surface, sections[sections.size() == 1 ? 0 : r], at.where.triangle);
    const ConstraintEntries position = at.entries();
    for (const Vec3& unit : directions)
      springs.add(support.name, along(unit, position), k.displacement / k.edge * at.area.norm(),
                  unit.dot(support.displacement));
  });
  if (!any) throw InputError("support '" + support.name + "' holds nothing of the surface");
}

}  // namespace

std::vector<ShellSection> triangle_sections(const ModelLayout& model,
                                            const ShellDefinition& definition) {
  const auto& sections = definition.sections;
  const VecX& thickness_offset = definition.nodal_thickness_offset;
  if (sections.size() != 1 && isize(sections) != model.region_count())
    throw InputError(std::to_string(sections.size()) + " sections for " +
                     std::to_string(model.region_count()) + " regions, expected one, or one each");
  for (const ShellSection& section : sections) require_section(section);
  if (thickness_offset.size() > 0 && thickness_offset.size() != model.mesh()->vertex_count())
    throw InputError(std::to_string(thickness_offset.size()) + " thicknesses for " +
                     std::to_string(model.mesh()->vertex_count()) + " vertices");
  if (sections.size() == 1 && thickness_offset.size() == 0) return sections;
  std::vector<ShellSection> all;
  for (int t = 0; t < model.mesh()->triangle_count(); ++t) {
    all.push_back(sections[sections.size() == 1 ? 0 : model.region_of(t)]);
    if (thickness_offset.size() == 0) continue;
    for (int i = 0; i < 3; ++i)
      all.back().thickness_offset[i] = thickness_offset[model.mesh()->triangles()[t][i]];
    require_section(all.back());
  }
  return all;
}

ShellTies shell_ties(const ModelLayout& model, const Points& shape,
                     const ShellDefinition& definition) {
  ShellTies ties = shell_ties(model, shape, definition.sections, definition.hinges);
  for (const LineSupport& support : definition.lines)
    add_support(model, shape, definition.sections, support, ties);
  for (const PointSupport& support : definition.points)
    add_point_support(model, support, ties.constraints);
  for (const AreaSupport& support : definition.areas)
    add_area_support(model, shape, definition.sections, support, ties.springs);
  for (const ElasticSupport& support : definition.elastic)
    add_elastic_support(model, shape, support, ties.springs);
  return ties;
}

std::vector<std::string> support_names(const ShellDefinition& definition) {
  std::vector<std::string> names;
  const auto add = [&](const auto& supports) {
    for (const auto& support : supports)
      if (std::find(names.begin(), names.end(), support.name) == names.end())
        names.push_back(support.name);
  };
  add(definition.lines);
  add(definition.points);
  add(definition.areas);
  add(definition.elastic);
  return names;
}

}  // namespace batten
