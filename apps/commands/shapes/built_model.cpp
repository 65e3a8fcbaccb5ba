#include "batten/apps/commands/shapes/built_model.h"

#include <algorithm>

#include "batten/apps/commands/lines/scene_lines.h"
#include "batten/apps/commands/shapes/scene_target.h"

namespace batten {

ModelBuildOptions model_build_options(const Scene& scene, const std::vector<CharacterLine>& lines) {
  ModelBuildOptions options;
  options.model.name = scene.name;
  options.model.skin = scene.skin.options;
  options.model.material = scene.skin.material;
  options.model.joins = mirrored_joins(scene, lines);
  options.model.rest = scene.skin.has_rest();
  options.model.crease_angle_deg = scene.network.crease_angle;
  options.model.join_tolerance_deg = scene.network.join_tolerance;
  options.network.tolerance = scene.network.tolerance;
  options.network.tangent_angle = scene.network.tangent_angle;
  options.search.specs = mirrored_regions(scene, lines);
  options.search.max_faces_per_edge = scene.network.max_faces_per_edge;
  options.single_face = specifies_single_region(scene);
  for (const LocatedString& section : scene.skin.sections) options.sections.push_back(section.text);
  options.fix_corners_only = scene.skin.boundary == SceneSkin::FixedBoundary::Corners;
  if (!scene.targets.empty())
    options.tolerance = [&scene](double size) {
      constexpr double of_target = 0.1;
      return scene.skin.options.tolerance > 0 ? scene.skin.options.tolerance
                                              : of_target * target_tolerance(scene, size);
    };
  options.unit = scene.unit;
  options.where = scene.at({});
  options.network_where = scene.at(scene.network.location);
  return options;
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

BuiltModel build_model(const Scene& scene, const std::vector<CharacterLine>& lines,
                       const Progress& progress) {
  return build_model(lines, model_build_options(scene, lines), progress);
}

}  // namespace batten
