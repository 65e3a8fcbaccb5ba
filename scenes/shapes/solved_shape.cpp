// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/shapes/solved_shape.h"

#include <algorithm>
#include <optional>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/io/files/text.h"
#include "batten/mesh/catmull_clark.h"
#include "batten/scenes/lines/scene_lines.h"
#include "batten/scenes/lines/scene_neighbours.h"
#include "batten/scenes/runs/target_files.h"
#include "batten/scenes/shapes/make_session.h"
#include "batten/sculpting/session/sculpting_session.h"
#include "batten/skinning/mesh_targets/mesh_target.h"
#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/model/model_projector.h"
#include "batten/skinning/model/model_shapes.h"
#include "batten/skinning/surfaces/skin_network.h"

namespace batten {

ModelBuildOptions model_build_options(const Scene& scene, const std::vector<CharacterLine>& lines) {
  ModelBuildOptions options;
  options.model.name = scene.name;
  options.model.skin = scene.skin.options;
  options.model.material = scene.skin.material;
  options.model.joins = mirrored_joins(scene, lines);
  options.model.rest = scene.skin.has_rest();
  SceneNeighbours given = read_neighbours(scene);
  options.model.neighbours = std::move(given.neighbours);
  constexpr double of_accuracy = 4;
  options.model.neighbour_tolerance = of_accuracy * given.accuracy;
  options.model.crease_angle_deg = scene.network.crease_angle;
  options.model.join_tolerance_deg = scene.network.join_tolerance;
  options.network.tolerance = scene.network.tolerance;
  options.network.tangent_angle = scene.network.tangent_angle;
  options.search.specs = mirrored_regions(scene, lines);
  // The openings are all there is to fill: their edges may bound further loops.
  options.search.only_specs = !given.regions.empty();
  options.search.specs.insert(options.search.specs.end(), given.regions.begin(),
                              given.regions.end());
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
  else if (given.accuracy > 0 && !(scene.skin.options.tolerance > 0))
    options.tolerance = [accuracy = given.accuracy](double size) {
      constexpr double usual = 1e-4;
      return std::max(usual * size, accuracy);
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
  if (!scene.network.regions.empty() || !scene.network.joins.empty() || !scene.neighbours.empty() ||
      scene.network.symmetry)
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

double target_tolerance(const Scene& scene, double size) {
  double least = 0;
  for (const SceneTarget& target : scene.targets) {
    const double own = target.tolerance > 0 ? target.tolerance : 1e-4 * size;
    least = least > 0 ? std::min(least, own) : own;
  }
  return least;
}

namespace {

/// Angle in degrees between the surface normal at a location and a direction, regardless of sign.
double normal_deviation_degrees(const Surface& surface, const Location& where,
                                const Vec3& direction) {
  const Vec3 n = surface.jet(where).normal();
  return std::min(degrees_between(n, direction), degrees_between(n, -direction));
}

void set_dofs(SolvedShape& shape, const Points& dofs, const Scene& scene) {
  const ModelLayout& layout = *shape.layout;
  shape.dofs = shape.unloaded = dofs;
  shape.energy = {};
  shape.energy.bending = bending_energy(layout, dofs, scene.skin.material);
  for (int r = 0; r < layout.region_count(); ++r)
    shape.regions[static_cast<size_t>(r)] = layout.skinned(r, dofs);
}

// Fairs the shape if the scene requests it: the whole shape, or the rest shape if loads act on it.
void fair(SolvedShape& shape, const Scene& scene, const BuiltModel& made,
          const Progress& progress) {
  if (!requests_fair_shape(scene, made) || !shape.layout) return;
  FairShape faired = compute_fair_shape(scene, made, shape.layout, shape.unloaded, progress);
  if (faired.rest && scene.is_sculpted()) {
    SessionReference start;
    SculptingSession session =
        make_session(*faired.layout, scene, made, FactorReuse::once, progress, &start, faired.rest);
    const SolveReport report = session.solve_to_equilibrium();
    shape = shape_of(session, scene, start.unloaded, report);
  } else if (faired.dofs.rows() > 0) {
    shape.layout = faired.layout;
    set_dofs(shape, faired.dofs, scene);
    shape.max_constraint_residual =
        shape.layout->line_constraints().max_residual(shape.dofs) / shape.layout->size();
  }
  shape.fairing = std::move(*faired.fairing);
}

// The shape of a network as it was skinned.
SolvedShape initial_shape(const BuiltModel& made, const Scene& scene) {
  SolvedShape shape;
  shape.layout = made.model.layout;
  shape.dofs = shape.unloaded = made.model.dofs;
  for (const SkinnedRegion* region : made.model.skinned()) shape.regions.push_back(*region);
  if (!shape.layout) return shape;
  shape.energy.bending = bending_energy(*shape.layout, shape.dofs, scene.skin.material);
  return shape;
}

}  // namespace

std::vector<const SkinnedRegion*> pointers(const std::vector<SkinnedRegion>& regions) {
  std::vector<const SkinnedRegion*> all;
  for (const SkinnedRegion& region : regions) all.push_back(&region);
  return all;
}

SolvedShape shape_of(const SculptingSession& session, const Scene& scene, const Points& unloaded,
                     const SolveReport& report) {
  SolvedShape shape;
  shape.layout = std::make_shared<const ModelLayout>(session.layout());
  shape.dofs = session.dofs();
  shape.unloaded = unloaded;
  shape.regions = session.regions();
  shape.energy = session.energy();
  shape.iterations = report.iterations;
  shape.last_change = report.change;
  shape.max_constraint_residual = session.residual();
  shape.reactions = session.reactions();
  shape.scans = session.scan_distances(unloaded);
  shape.joins_planned = report.joins_planned;
  std::optional<ModelProjector> projector;
  for (const auto& c : scene.constraints) {
    if (c.type != SceneConstraint::Type::Normal) continue;
    // At the same point as make_session(), although the mesh may be refined.
    if (!projector) projector.emplace(*shape.layout, unloaded);
    const ModelPoint at = projector->nearest_inside(c.at).at;
    const Surface& surface = shape.regions[at.region].surface;
    const double degrees = normal_deviation_degrees(surface, surface.locate(at.uv), c.goal);
    if (!(degrees <= shape.max_normal_constraint_deg)) shape.max_normal_constraint_deg = degrees;
  }
  return shape;
}

namespace {

// The equilibrium shape of a session.
SolvedShape equilibrium_shape(const ModelLayout& layout, const Scene& scene, const BuiltModel& made,
                              const Progress& progress) {
  SessionReference start;
  SculptingSession session = make_session(layout, scene, made, FactorReuse::once, progress, &start);
  const SolveReport report = session.solve_to_equilibrium();
  return shape_of(session, scene, start.unloaded, report);
}

// The equilibrium shape, with bisection of triangles until the gaps are closed.
SolvedShape refined_equilibrium_shape(const BuiltModel& made, const Scene& scene,
                                      const Progress& progress) {
  const bool lines_are_constrained = scene.skin.boundary == SceneSkin::FixedBoundary::Lines;
  ModelLayout layout = *made.model.layout;
  GapRefinement refinement(layout);
  for (;;) {
    SolvedShape shape = equilibrium_shape(layout, scene, made, progress);
    if (!lines_are_constrained || !refinement.bisect(layout, shape.regions)) return shape;
  }
}

}  // namespace

SolvedShape solve_shape(const ModelLayout& layout, const Scene& scene, const BuiltModel& made,
                        const Progress& progress) {
  SolvedShape shape = equilibrium_shape(layout, scene, made, progress);
  fair(shape, scene, made, progress);
  return shape;
}

SolvedShape solve_refined_shape(const BuiltModel& made, const Scene& scene,
                                const Progress& progress) {
  const bool at_rest = made.network && (!scene.is_sculpted() || !made.model.layout);
  SolvedShape shape =
      at_rest ? initial_shape(made, scene) : refined_equilibrium_shape(made, scene, progress);
  fair(shape, scene, made, progress);
  return shape;
}

ModelLayout refine_for_lines(const BuiltModel& made, const Scene& scene, const Progress& progress) {
  ModelLayout layout = *made.model.layout;
  const bool embeds = std::any_of(layout.lines().begin(), layout.lines().end(), [](const auto& l) {
    return std::any_of(l.sides.begin(), l.sides.end(), [](const auto& s) { return s.embedded; });
  });
  if (scene.skin.boundary != SceneSkin::FixedBoundary::Lines || !embeds) return layout;
  GapRefinement refinement(layout);
  while (!refinement.exhausted()) {
    SculptingSession session = make_session(layout, scene, made, FactorReuse::once, progress);
    try {
      session.solve_to_equilibrium();
    } catch (const NoSolutionError&) {
      return layout;
    }
    if (!refinement.bisect(layout, session.regions())) return layout;
  }
  return layout;
}

SculptModel sculpt_model(BuiltModel made, const Scene& scene, const Progress& progress) {
  if (!made.model.layout)
    throw InputError(scene.at({}) +
                     "found no face that could be given a surface, expected at least one");
  SculptModel model;
  model.layout = std::make_shared<const ModelLayout>(refine_for_lines(made, scene, progress));
  if (requests_fair_shape(scene, made)) {
    const Points bent = min_bending_shape(*model.layout, scene, progress);
    model.fair = compute_fair_shape(scene, made, model.layout, bent, progress);
  }
  if (model.fair.layout) model.layout = model.fair.layout;
  model.made = std::move(made);
  return model;
}

void set_shape(BuiltModel& made, const SolvedShape& shape, const Progress& progress) {
  if (!shape.layout) return;
  // A network without loads was measured when it was skinned.
  if (made.network && shape.layout == made.model.layout && !shape.fairing.surface &&
      !shape.fairing.lofted && !shape.fairing.fit)
    return;
  // The area of a fitted shape may exceed that of the hole filling.
  if (shape.fairing.fit)
    for (ModelRegion& region : made.model.regions) region.expected_area = 0;
  reshape(made.model, shape.layout, shape.dofs, shape.regions, progress);
}

namespace {

std::vector<std::string> section_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const LocatedString& section : scene.skin.sections) names.push_back(section.text);
  return names;
}

// The fair shape that a scene states, without the surface of its targets.
FairShapeOptions fair_shape_options(const Scene& scene, const BuiltModel& made) {
  using Fair = SceneSkin::Fair;
  using Shape = FairShapeOptions::Shape;
  const SceneSkin& skin = scene.skin;
  FairShapeOptions options;
  options.variation.strength = skin.strength;
  if (skin.max_displacement > 0) options.variation.largest_move = skin.max_displacement;
  options.join_tolerance_deg = scene.network.join_tolerance;
  options.sections = made.sections.empty() ? section_names(scene) : made.sections;
  const bool free = skin.boundary == SceneSkin::FixedBoundary::Lines && skin.isotropic_alpha &&
                    skin.isotropic_beta;
  if (!scene.targets.empty())
    options.shape = Shape::Target;
  else if (skin.fair == Fair::Loft || (skin.fair == Fair::Auto && !made.sections.empty()))
    options.shape = Shape::Loft;
  else if (skin.fair == Fair::Variation)
    options.shape = Shape::MinimumVariation;
  else
    options.shape = skin.fair == Fair::Auto && free ? Shape::Automatic : Shape::MinimumBending;
  return options;
}

}  // namespace

bool requests_fair_shape(const Scene& scene, const BuiltModel& made) {
  return has_fair_shape(fair_shape_options(scene, made), made.model.layout.get());
}

namespace {

void append_target(TargetFaces& all, const Scene& scene, const SceneTarget& target, double chord) {
  if (!target.mesh) {
    append_target_file(all, target.file, {scene.unit, target.unit, chord, target.cage});
    return;
  }
  const double unit = unit_in_metres(scene.unit);
  const double own = target.unit.empty() ? unit : unit_in_metres(target.unit);
  all.append(target.cage ? catmull_clark_limit(*target.mesh, {}, chord * unit / own) : *target.mesh,
             own / unit);
}

/// Combines all targets of a scene into one surface in the scene's unit. Meshes are used unchanged;
/// CAD faces become curved triangles within a quarter of the tolerance. Throws InputError that
/// begins with the location in the scene.
TargetParts target_of(const Scene& scene, double size, const Progress& progress) {
  constexpr double fraction = 0.25;  // of the tolerance
  const double chord = fraction * target_tolerance(scene, size);
  TargetFaces all;
  for (const SceneTarget& target : scene.targets) {
    progress.update("reading the target", 0);
    try {
      append_target(all, scene, target, chord);
    } catch (const InputError& e) {
      throw InputError(scene.at(target.location) + e.what());
    }
  }
  try {
    return target_parts(all);
  } catch (const InputError& e) {
    throw InputError(scene.at(scene.targets.front().location) + e.what());
  }
}

}  // namespace

FairShape compute_fair_shape(const Scene& scene, const BuiltModel& made,
                             std::shared_ptr<const ModelLayout> layout, const Points& bent,
                             const Progress& progress) {
  FairShapeOptions options = fair_shape_options(scene, made);
  if (options.shape == FairShapeOptions::Shape::Target) {
    const double size = layout->size();
    options.fit.tolerance = target_tolerance(scene, size);
    const TargetParts target = target_of(scene, size, progress);
    options.fit.parts = target.parts;
    options.target = target.whole;
  }
  try {
    return compute_fair_shape(made.model, std::move(layout), bent, options, progress);
  } catch (const InputError& e) {
    if (options.shape != FairShapeOptions::Shape::Loft || scene.skin.sections.empty()) throw;
    throw InputError(scene.at(scene.skin.sections.front().location) + e.what());
  }
}

Points min_bending_shape(const ModelLayout& layout, const Scene& scene, const Progress& progress) {
  StaticTask lines;
  lines.material = scene.skin.material;
  lines.units = scene.skin.units;
  lines.fix_corners_only = scene.skin.boundary == SceneSkin::FixedBoundary::Corners;
  return sculpt(layout, lines, progress).dofs;
}

}  // namespace batten
