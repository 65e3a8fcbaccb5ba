#include "batten/apps/commands/shapes/make_model.h"

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
#include "batten/skinning/surfaces/section_row.h"
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
  return box_around(points).diagonal().norm();
}

// The lines of a scene that is a stack of sections and nothing else, in their order; or none.
std::vector<CharacterLine> stated_sections(const Scene& scene,
                                           const std::vector<CharacterLine>& lines) {
  const auto& sections = scene.skin.sections;
  if (sections.size() < 2 || sections.size() != lines.size()) return {};
  std::vector<CharacterLine> in_order;
  for (const PlacedWord& section : sections) {
    const auto it = std::find_if(lines.begin(), lines.end(),
                                 [&](const CharacterLine& l) { return l.name == section.text; });
    if (it == lines.end()) return {};  // loft_shape() says which
    in_order.push_back(*it);
  }
  return in_order;
}

// Lays a region out, its normals on the side of normal_side.h.
RegionLayout laid_out(const Scene& scene, const std::vector<CharacterLine>& lines,
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
    const Points shape = rest.rows() > 0 ? rest : model.least_energy(scene.skin.material, Points());
    const SkinnedRegion region = usual.region(shape);
    options.against_first = !normal_side(side_integrals({&region}), false).agrees;
  } catch (const CancelledError&) {
    throw;
  } catch (const Error&) {
    // What is wrong with the shape is said where it is made.
  }
  options.edge_length = stated;
  return stated > 0 || options.against_first ? layout(options) : usual;
}

// A region as a model.
MadeModel one_region(const Scene& scene, const std::vector<CharacterLine>& lines,
                     const std::vector<CharacterLine>& sections, const Progress& progress) {
  MadeModel made;
  try {
    made.model.layout =
        std::make_shared<const ModelLayout>(laid_out(scene, lines, sections, progress));
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
  region.in_layout = 0;
  region.warnings = made.model.layout->warnings();
  return made;
}

}  // namespace

CharacterLineNetwork network_of(const Scene& scene, const std::vector<CharacterLine>& lines,
                                const Progress& progress) {
  NetworkOptions options;
  options.tolerance = scene.network.tolerance;
  options.fit_tolerance =
      scene.targets.empty() ? scene.skin.options.tolerance : fit_tolerance(scene, size_of(lines));
  options.corner_angle = scene.skin.options.corner_angle;
  options.straight_angle = scene.network.straight_angle;
  try {
    return CharacterLineNetwork(lines, options, progress);
  } catch (const InputError& e) {
    throw InputError(scene.at(scene.network.place) + e.what());
  }
}

FoundRegions regions_of(const Scene& scene, const CharacterLineNetwork& network,
                        const Progress& progress) {
  RegionOptions options;
  options.words = mirrored_regions(scene, network.lines());
  options.most_at_line = scene.network.most_at_line;
  FoundRegions found = find_regions(network, options, progress);
  if (!found.regions.empty()) return found;
  std::string text = scene.at(scene.network.place) + "found no loop of lines that bounds a " +
                     "surface, expected one or more (lines meet within " +
                     number(network.tolerance()) + " " + scene.unit + ")";
  int more = 0;
  for (const NetworkFinding& finding : network.findings()) {
    if (finding.repaired) continue;
    constexpr int most = 5;
    if (++more <= most) text += "; " + finding.text;
  }
  throw InputError(text);
}

std::vector<std::string> MadeModel::region_names() const {
  std::vector<std::string> names;
  for (const ModelRegion& region : model.regions)
    if (region.in_layout >= 0) names.push_back(region.plan.name);
  return names;
}

bool states_one_region(const Scene& scene) {
  using Treatment = CharacterLine::Treatment;
  const SceneSkin& skin = scene.skin;
  const SkinOptions& options = skin.options;
  if (!scene.network.regions.empty() || !scene.network.joins.empty() || scene.network.symmetry)
    return false;
  return options.domain != SkinOptions::Domain::Auto || options.settle ||
         options.mesher != SkinOptions::Mesher::Delaunay || options.fan_refinements >= 0 ||
         !skin.isotropic_alpha || !skin.isotropic_beta || skin.fair == SceneSkin::Fair::Loft ||
         std::any_of(scene.lines.begin(), scene.lines.end(),
                     [](const SceneLine& line) { return line.treatment != Treatment::Auto; });
}

namespace {

bool bounds(const CharacterLine& line) { return line.role == CharacterLine::Role::Outline; }

// Whether the outlines alone bound one region, on which all curves with another role lie.
bool bound_one_region(const Scene& scene, const std::vector<CharacterLine>& lines,
                      const Progress& progress) {
  std::vector<CharacterLine> outlines;
  std::copy_if(lines.begin(), lines.end(), std::back_inserter(outlines), bounds);
  if (outlines.size() == lines.size() && scene.skin.hold == SceneSkin::Hold::Lines) return false;
  if (outlines.empty()) return true;  // whose error says what is missing
  const CharacterLineNetwork network = network_of(scene, outlines, progress);
  const FoundRegions found = find_regions(network, {}, progress);
  return found.regions.empty() || (found.regions.size() == 1 && found.bare.empty());
}

// Skins what was found in the network.
void skin(MadeModel& made, const Scene& scene, const Progress& progress) {
  const std::vector<CharacterLine>& lines = made.network->lines();
  ModelOptions options;
  options.name = scene.name;
  options.skin = scene.skin.options;
  if (!scene.targets.empty()) options.skin.tolerance = fit_tolerance(scene, size_of(lines));
  options.material = scene.skin.material;
  options.joins = mirrored_joins(scene, lines);
  options.rest = scene.skin.has_rest();
  options.smooth_below_deg = scene.network.smooth_below;
  options.join_tolerance_deg = scene.network.join_tolerance;
  made.model = skin_network(*made.network, *made.found, options, progress);
  made.fit_tolerance = fit_tolerance(scene, made.network->size());
}

// The surfaces between closed sections that have a corner: two in each bay, from rails through the
// corners and through the noses. The sections themselves bound none.
MadeModel between_cornered(const Scene& scene, const std::vector<CharacterLine>& sections,
                           const Progress& progress) {
  std::vector<CharacterLine> lines = sections;
  for (CharacterLine& rail : corner_rails(sections)) lines.push_back(std::move(rail));
  MadeModel made;
  made.network.emplace(network_of(scene, lines, progress));
  RegionOptions options;
  for (const CharacterLine& section : sections) {
    RegionWord word;
    word.kind = RegionWord::Kind::Nothing;
    word.loops = {{section.name}};
    options.words.push_back(std::move(word));
  }
  made.found.emplace(find_regions(*made.network, options, progress));
  skin(made, scene, progress);
  return made;
}

}  // namespace

MadeModel make_model(const Scene& scene, const std::vector<CharacterLine>& lines,
                     const Progress& progress) {
  if (states_one_region(scene)) {
    const std::vector<CharacterLine> sections = stated_sections(scene, lines);
    if (have_corners(sections, scene.skin.options.corner_angle))
      return between_cornered(scene, sections, progress);
    return one_region(scene, lines, sections, progress);
  }
  progress.at("network", 0);
  const bool words = !scene.network.regions.empty() || !scene.network.joins.empty();
  if (!words && bound_one_region(scene, lines, progress))
    return one_region(scene, lines, {}, progress);
  MadeModel made;
  made.network.emplace(network_of(scene, lines, progress));
  if (!words)
    if (const std::vector<CharacterLine> row = section_row(*made.network); !row.empty()) {
      if (have_corners(row, scene.skin.options.corner_angle))
        return between_cornered(scene, row, progress);
      made = one_region(scene, lines, row, progress);
      made.sections = {};
      for (const CharacterLine& section : row) made.sections.push_back(section.name);
      return made;
    }
  progress.at("regions", 0);
  made.found.emplace(regions_of(scene, *made.network, progress));
  // A surface by itself has the name of its scene.
  std::vector<NetworkRegion>& regions = made.found->regions;
  if (regions.size() == 1 && !regions[0].asked) regions[0].name = scene.name;
  skin(made, scene, progress);
  // Where there is nothing else to make, what went wrong is the answer.
  if (regions.size() == 1 && !made.model.layout)
    throw InputError(scene.at({}) + made.model.regions[0].why_not);
  return made;
}

}  // namespace batten
