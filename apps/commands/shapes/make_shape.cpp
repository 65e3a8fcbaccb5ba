#include "batten/apps/commands/shapes/make_shape.h"

#include <algorithm>
#include <optional>

#include "batten/apps/commands/shapes/make_session.h"
#include "batten/core/errors.h"
#include "batten/core/words.h"
#include "batten/fem/assembly.h"
#include "batten/skinning/model/model_projector.h"
#include "batten/skinning/surfaces/skin_network.h"

namespace batten {
namespace {

/// Half of the tolerance is the lines' own deviation from their curves.
constexpr double kMostGap = 0.7;
constexpr int kMostRounds = 8;

/// Triangles that a sculpted shape may have after it was refined.
int most_when_refined(const ModelLayout& layout) {
  constexpr int usual = 20'000, times = 4;
  return std::max(usual, times * layout.mesh()->triangle_count());
}

/// Degrees between the surface's normal at a place and a direction, either sign.
double turned(const Surface& surface, const Location& where, const Vec3& direction) {
  const Vec3 n = surface.jet(where).normal();
  return std::min(degrees_between(n, direction), degrees_between(n, -direction));
}

double widest_gap(const std::vector<SkinnedRegion>& regions) {
  double gap = 0;
  for (const SkinnedRegion& region : regions)
    for (const EmbeddedLine& line : region.embedded)
      gap = std::max(gap, line_gap(region.surface, line));
  return gap;
}

// Halves at the gaps of a shape on the layout. False when there is nothing to halve, or the mesh
// would have more than `most` triangles.
bool halve_at_gaps(ModelLayout& layout, const std::vector<SkinnedRegion>& regions, int most) {
  std::vector<char> marks(static_cast<size_t>(layout.mesh()->triangle_count()), 0);
  for (size_t r = 0; r < regions.size(); ++r)
    mark_gaps(regions[r], 0.5 * layout.tolerance(),
              marks.data() + layout.first_triangle(static_cast<int>(r)));
  const auto more = std::count(marks.begin(), marks.end(), 1);
  return layout.mesh()->triangle_count() + more <= most && layout.refine(marks);
}

double bending_energy(const ModelLayout& layout, const Points& dofs, const Scene& scene) {
  SurfaceStiffness bends = scene.skin.material;
  bends.alpha.setZero();
  const SurfaceAssembler assembler(*layout.mesh(), layout.element(), layout.trim());
  SparseMatrix K = assembler.pattern();
  auto materials = layout.on_regions({bends});
  materials.resize(static_cast<size_t>(layout.mesh()->triangle_count()), materials[0]);
  assembler.stiffness(materials, K);
  const Points q = dofs - layout.position_dofs() * layout.origin().transpose();
  const double energy = q.cwiseProduct(Points(K.selfadjointView<Eigen::Lower>() * q)).sum();
  return std::max(0.0, energy) / (layout.size() * layout.size());
}

void take_dofs(MadeShape& shape, const Points& dofs, const Scene& scene) {
  const ModelLayout& layout = *shape.layout;
  shape.dofs = shape.unloaded = dofs;
  shape.energy = {};
  shape.energy.bending = bending_energy(layout, dofs, scene);
  for (int r = 0; r < layout.region_count(); ++r)
    shape.regions[static_cast<size_t>(r)] = layout.skinned(r, dofs);
}

// Makes the shape fair where the scene asks for that: the whole shape, or where something acts what
// a session bends.
void fair(MadeShape& shape, const Scene& scene, const MadeModel& made, const Progress& progress) {
  if (!asks_for_shape(scene, made) || !shape.layout) return;
  FairShape faired = fair_scene(scene, made, shape.layout, shape.unloaded, progress);
  if (faired.rest && scene.is_sculpted()) {
    SessionStart start;
    SculptingSession session = make_session(*faired.layout, scene, made, Expected::one_factor,
                                            progress, &start, faired.rest);
    const Answer answer = session.settle();
    shape = shape_of(session, scene, start.unloaded, answer);
  } else if (faired.dofs.rows() > 0) {
    shape.layout = faired.layout;
    take_dofs(shape, faired.dofs, scene);
    shape.max_constraint_residual =
        shape.layout->line_constraints().max_residual(shape.dofs) / shape.layout->size();
  }
  shape.fairing = std::move(*faired.fairing);
}

// The shape that a network was skinned with.
MadeShape shape_at_rest(const MadeModel& made, const Scene& scene) {
  MadeShape shape;
  shape.layout = made.model.layout;
  shape.dofs = shape.unloaded = made.model.dofs;
  for (const SkinnedRegion* region : made.model.skinned()) shape.regions.push_back(*region);
  if (!shape.layout) return shape;
  shape.energy.bending = bending_energy(*shape.layout, shape.dofs, scene);
  return shape;
}

}  // namespace

std::vector<const SkinnedRegion*> pointers(const std::vector<SkinnedRegion>& regions) {
  std::vector<const SkinnedRegion*> all;
  for (const SkinnedRegion& region : regions) all.push_back(&region);
  return all;
}

MadeShape shape_of(const SculptingSession& session, const Scene& scene, const Points& unloaded,
                   const Answer& answer) {
  MadeShape shape;
  shape.layout = std::make_shared<const ModelLayout>(session.layout());
  shape.dofs = session.dofs();
  shape.unloaded = unloaded;
  shape.regions = session.regions();
  shape.energy = session.energy();
  shape.iterations = answer.iterations;
  shape.last_change = answer.change;
  shape.max_constraint_residual = session.residual();
  shape.reactions = session.reactions();
  shape.scans = session.scan_distances(unloaded);
  shape.joins_planned = answer.joins_planned;
  std::optional<ModelProjector> projector;
  for (const auto& c : scene.constraints) {
    if (c.type != SceneConstraint::Type::Normal) continue;
    // Where make_session() put it: the mesh may be finer by now.
    if (!projector) projector.emplace(*shape.layout, unloaded);
    const ModelPoint at = projector->nearest_inside(c.at).at;
    const Surface& surface = shape.regions[at.region].surface;
    const double degrees = turned(surface, surface.locate(at.uv), c.goal);
    if (!(degrees <= shape.max_normal_constraint_deg)) shape.max_normal_constraint_deg = degrees;
  }
  return shape;
}

namespace {

// The shape that a session settles in.
MadeShape settled_shape(const ModelLayout& layout, const Scene& scene, const MadeModel& made,
                        const Progress& progress) {
  SessionStart start;
  SculptingSession session =
      make_session(layout, scene, made, Expected::one_factor, progress, &start);
  const Answer answer = session.settle();
  return shape_of(session, scene, start.unloaded, answer);
}

// The same where triangles are halved until gaps are closed.
MadeShape settled_refined_shape(const MadeModel& made, const Scene& scene,
                                const Progress& progress) {
  const bool held = scene.skin.hold == SceneSkin::Hold::Lines;
  ModelLayout layout = *made.model.layout;
  const int most = most_when_refined(layout);
  for (int round = 0;; ++round) {
    MadeShape shape = settled_shape(layout, scene, made, progress);
    if (!held || round == kMostRounds) return shape;
    if (widest_gap(shape.regions) <= kMostGap * layout.tolerance()) return shape;
    if (!halve_at_gaps(layout, shape.regions, most)) return shape;
  }
}

}  // namespace

MadeShape make_shape(const ModelLayout& layout, const Scene& scene, const MadeModel& made,
                     const Progress& progress) {
  MadeShape shape = settled_shape(layout, scene, made, progress);
  fair(shape, scene, made, progress);
  return shape;
}

MadeShape make_refined_shape(const MadeModel& made, const Scene& scene, const Progress& progress) {
  const bool at_rest = made.network && (!scene.is_sculpted() || !made.model.layout);
  MadeShape shape =
      at_rest ? shape_at_rest(made, scene) : settled_refined_shape(made, scene, progress);
  fair(shape, scene, made, progress);
  return shape;
}

ModelLayout refined_for_lines(const MadeModel& made, const Scene& scene, const Progress& progress) {
  ModelLayout layout = *made.model.layout;
  const bool embeds = std::any_of(layout.lines().begin(), layout.lines().end(), [](const auto& l) {
    return std::any_of(l.sides.begin(), l.sides.end(), [](const auto& s) { return s.embedded; });
  });
  if (scene.skin.hold != SceneSkin::Hold::Lines || !embeds) return layout;
  const int most = most_when_refined(layout);
  for (int round = 0; round < kMostRounds; ++round) {
    SculptingSession session = make_session(layout, scene, made, Expected::one_factor, progress);
    try {
      session.settle();
    } catch (const NoSolutionError&) {
      return layout;
    }
    const auto regions = session.regions();
    if (widest_gap(regions) <= kMostGap * layout.tolerance()) return layout;
    if (!halve_at_gaps(layout, regions, most)) return layout;
  }
  return layout;
}

SculptModel sculpt_model(MadeModel made, const Scene& scene, const Progress& progress) {
  if (!made.model.layout) throw InputError(scene.at({}) + "no region could be skinned");
  SculptModel model;
  model.layout = std::make_shared<const ModelLayout>(refined_for_lines(made, scene, progress));
  if (asks_for_shape(scene, made)) {
    const Points bent = bent_shape(*model.layout, scene, progress);
    model.fair = fair_scene(scene, made, model.layout, bent, progress);
  }
  if (model.fair.layout) model.layout = model.fair.layout;
  model.made = std::move(made);
  return model;
}

void take_shape(MadeModel& made, const MadeShape& shape, const Progress& progress) {
  if (!shape.layout) return;
  // A network at rest was measured when it was skinned.
  if (made.network && shape.layout == made.model.layout && !shape.fairing.surface &&
      !shape.fairing.lofted && !shape.fairing.fit)
    return;
  // A shape that was given may be larger than what its lines mean.
  if (shape.fairing.fit)
    for (ModelRegion& region : made.model.regions) region.plain_area = 0;
  reshape(made.model, shape.layout, shape.dofs, shape.regions, progress);
}

}  // namespace batten
