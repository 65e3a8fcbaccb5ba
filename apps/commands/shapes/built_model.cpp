#include "batten/apps/commands/shapes/built_model.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "batten/apps/commands/lines/mirror_lines.h"
#include "batten/apps/commands/shapes/scene_target.h"
#include "batten/core/box.h"
#include "batten/core/errors.h"
#include "batten/skinning/layout/section_region.h"
#include "batten/skinning/model/rest_shape.h"
#include "batten/skinning/search/find_regions.h"
#include "batten/skinning/surfaces/normal_side.h"
#include "batten/skinning/surfaces/ordered_sections.h"
#include "batten/skinning/surfaces/skin_network.h"

namespace batten {
namespace {

double fit_tolerance(const Scene& scene, double size) {
  constexpr double usual = 1e-4, of_target = 0.1;
  if (scene.skin.options.tolerance > 0) return scene.skin.options.tolerance;
  return scene.targets.empty() ? usual * size : of_target * target_tolerance(scene, size);
}

double size_of(const std::vector<CharacterLine>& lines) {
  constexpr int samples = 16;  // of a line
  std::vector<Vec3> points;
  for (const CharacterLine& line : lines)
    for (int i = 0; i <= samples; ++i)
      points.push_back(line.curve->evaluate(
          line.curve->start() + (line.curve->end() - line.curve->start()) * i / samples));
  return bounding_box(points).diagonal().norm();
}

// The lines of a scene that is a stack of sections and nothing else, in their order; or none.
std::vector<CharacterLine> specified_sections(const Scene& scene,
                                              const std::vector<CharacterLine>& lines) {
  const auto& sections = scene.skin.sections;
  if (sections.size() < 2 || sections.size() != lines.size()) return {};
  std::vector<CharacterLine> in_order;
  for (const LocatedString& section : sections) {
    const auto it = std::find_if(lines.begin(), lines.end(),
                                 [&](const CharacterLine& l) { return l.name == section.text; });
    if (it == lines.end()) return {};  // loft_shape() says which
    in_order.push_back(*it);
  }
  return in_order;
}

// Lays a region out, its normals on the side of normal_side.h.
RegionLayout make_layout(const Scene& scene, const std::vector<CharacterLine>& lines,
                         const std::vector<CharacterLine>& sections, const Progress& progress) {
  const auto layout = [&](const SkinOptions& options) {
    return sections.empty() ? RegionLayout(scene.name, lines, options, progress)
                            : section_region(scene.name, sections, options, progress);
  };
  SkinOptions options = scene.skin.options;
  const double stated = std::exchange(options.edge_length, 0);  // the usual mesh tells the side
  const RegionLayout usual = layout(options);
  try {
    const ModelLayout model(usual);
    const Points rest = scene.skin.has_rest() ? rest_dofs(model) : Points();
    const Points shape =
        rest.rows() > 0 ? rest : model.minimize_energy(scene.skin.material, Points());
    const SkinnedRegion region = usual.region(shape);
    options.reverse_orientation = !normal_side(side_integrals({&region}), false).agrees;
  } catch (const CancelledError&) {
    throw;
  } catch (const Error&) {
    // What is wrong with the shape is said where it is made.
  }
  options.edge_length = stated;
  return stated > 0 || options.reverse_orientation ? layout(options) : usual;
}

// A region as a model.
BuiltModel one_region(const Scene& scene, const std::vector<CharacterLine>& lines,
                      const std::vector<CharacterLine>& sections, const Progress& progress) {
  BuiltModel made;
  try {
    made.model.layout =
        std::make_shared<const ModelLayout>(make_layout(scene, lines, sections, progress));
  } catch (const InputError& e) {
    std::string text = e.what();
    const size_t named = scene.skin.sections.size();
    if (!sections.empty() && text.find("'rail ") != std::string::npos)
      text += "; rails run through the ends of the sections in the order of 'sections'";
    else if (sections.empty() && named > 1)
      text += "; 'sections' names " + std::to_string(named) + " of " +
              std::to_string(lines.size()) + " lines: if there is nothing but sections, name all";
    throw InputError(scene.at({}) + text);
  }
  made.fit_tolerance = made.model.layout->tolerance();
  ModelRegion& region = made.model.regions.emplace_back();
  region.plan.name = scene.name;
  region.layout_index = 0;
  region.warnings = made.model.layout->warnings();
  return made;
}

}  // namespace

CurveNetwork network_of(const Scene& scene, const std::vector<CharacterLine>& lines,
                        const Progress& progress) {
  NetworkOptions options;
  options.tolerance = scene.network.tolerance;
  options.fit_tolerance =
      scene.targets.empty() ? scene.skin.options.tolerance : fit_tolerance(scene, size_of(lines));
  options.corner_angle = scene.skin.options.corner_angle;
  options.tangent_angle = scene.network.tangent_angle;
  try {
    return CurveNetwork(lines, options, progress);
  } catch (const InputError& e) {
    throw InputError(scene.at(scene.network.location) + e.what());
  }
}

FoundRegions regions_of(const Scene& scene, const CurveNetwork& network, const Progress& progress) {
  RegionSearchOptions options;
  options.specs = mirrored_regions(scene, network.lines());
  options.max_faces_per_edge = scene.network.max_faces_per_edge;
  FoundRegions found = find_regions(network, options, progress);
  if (!found.regions.empty()) return found;
  std::string text = scene.at(scene.network.location) + "found no loop of lines that bounds a " +
                     "surface, expected one or more (lines meet within " +
                     format_number(network.tolerance()) + " " + scene.unit + ")";
  int more = 0;
  for (const NetworkDiagnostic& finding : network.diagnostics()) {
    if (finding.repaired) continue;
    constexpr int most = 5;
    if (++more <= most) text += "; " + finding.text;
  }
  throw InputError(text);
}

std::vector<std::string> BuiltModel::region_names() const {
  std::vector<std::string> names;
  for (const ModelRegion& region : model.regions)
    if (region.layout_index >= 0) names.push_back(region.plan.name);
  return names;
}

bool specifies_single_region(const Scene& scene) {
  using MeshAlignment = CharacterLine::MeshAlignment;
  const SceneSkin& skin = scene.skin;
  const SkinOptions& options = skin.options;
  if (!scene.network.regions.empty() || !scene.network.joins.empty() || scene.network.symmetry)
    return false;
  return options.domain != SkinOptions::Domain::Auto || options.minimize_distortion ||
         options.mesher != SkinOptions::Mesher::Delaunay || options.fan_refinements >= 0 ||
         !skin.isotropic_alpha || !skin.isotropic_beta || skin.fair == SceneSkin::Fair::Loft ||
         std::any_of(scene.lines.begin(), scene.lines.end(), [](const SceneLine& line) {
           return line.mesh_alignment != MeshAlignment::Auto;
         });
}

namespace {

bool bounds(const CharacterLine& line) { return line.role == CharacterLine::Role::Outline; }

// Whether the outlines alone bound one region, on which all curves with another role lie.
bool outlines_bound_one_region(const Scene& scene, const std::vector<CharacterLine>& lines,
                               const Progress& progress) {
  std::vector<CharacterLine> outlines;
  std::copy_if(lines.begin(), lines.end(), std::back_inserter(outlines), bounds);
  if (outlines.size() == lines.size() && scene.skin.boundary == SceneSkin::FixedBoundary::Lines)
    return false;
  if (outlines.empty()) return true;  // whose error says what is missing
  const CurveNetwork network = network_of(scene, outlines, progress);
  const FoundRegions found = find_regions(network, {}, progress);
  return found.regions.empty() || (found.regions.size() == 1 && found.unused_edges.empty());
}

// Skins what was found in the network.
void skin(BuiltModel& made, const Scene& scene, const Progress& progress) {
  const std::vector<CharacterLine>& lines = made.network->lines();
  ModelOptions options;
  options.name = scene.name;
  options.skin = scene.skin.options;
  if (!scene.targets.empty()) options.skin.tolerance = fit_tolerance(scene, size_of(lines));
  options.material = scene.skin.material;
  options.joins = mirrored_joins(scene, lines);
  options.rest = scene.skin.has_rest();
  options.crease_angle_deg = scene.network.crease_angle;
  options.join_tolerance_deg = scene.network.join_tolerance;
  made.model = skin_network(*made.network, *made.found, options, progress);
  made.fit_tolerance = fit_tolerance(scene, made.network->size());
}

// The surfaces between closed sections that have a corner: two in each bay, from rails through the
// corners and through the noses. The sections themselves bound none.
BuiltModel between_cornered(const Scene& scene, const std::vector<CharacterLine>& sections,
                            const Progress& progress) {
  std::vector<CharacterLine> lines = sections;
  for (CharacterLine& rail : corner_rails(sections)) lines.push_back(std::move(rail));
  BuiltModel made;
  made.network.emplace(network_of(scene, lines, progress));
  RegionSearchOptions options;
  for (const CharacterLine& section : sections) {
    RegionSpec spec;
    spec.kind = RegionSpec::Kind::NoSurface;
    spec.loops = {{section.name}};
    options.specs.push_back(std::move(spec));
  }
  made.found.emplace(find_regions(*made.network, options, progress));
  skin(made, scene, progress);
  return made;
}

}  // namespace

BuiltModel build_model(const Scene& scene, const std::vector<CharacterLine>& lines,
                       const Progress& progress) {
  if (specifies_single_region(scene)) {
    const std::vector<CharacterLine> sections = specified_sections(scene, lines);
    if (have_corner_at_seam(sections, scene.skin.options.corner_angle))
      return between_cornered(scene, sections, progress);
    return one_region(scene, lines, sections, progress);
  }
  progress.update("network", 0);
  const bool specs = !scene.network.regions.empty() || !scene.network.joins.empty();
  if (!specs && outlines_bound_one_region(scene, lines, progress))
    return one_region(scene, lines, {}, progress);
  BuiltModel made;
  made.network.emplace(network_of(scene, lines, progress));
  if (!specs)
    if (const std::vector<CharacterLine> row = ordered_sections(*made.network); !row.empty()) {
      if (have_corner_at_seam(row, scene.skin.options.corner_angle))
        return between_cornered(scene, row, progress);
      made = one_region(scene, lines, row, progress);
      made.sections = {};
      for (const CharacterLine& section : row) made.sections.push_back(section.name);
      return made;
    }
  progress.update("regions", 0);
  made.found.emplace(regions_of(scene, *made.network, progress));
  // A surface by itself has the name of its scene.
  std::vector<NetworkRegion>& regions = made.found->regions;
  if (regions.size() == 1 && !regions[0].requested) regions[0].name = scene.name;
  skin(made, scene, progress);
  // Where there is nothing else to make, what went wrong is the answer.
  if (regions.size() == 1 && !made.model.layout)
    throw InputError(scene.at({}) + made.model.regions[0].rejection_reason);
  return made;
}

}  // namespace batten
