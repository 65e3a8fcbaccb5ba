#include "batten/apps/commands/shapes/solved_shape.h"

#include <algorithm>
#include <optional>

#include "batten/apps/commands/shapes/make_session.h"
#include "batten/core/errors.h"
#include "batten/core/format.h"
#include "batten/fem/surface_assembler.h"
#include "batten/skinning/model/model_projector.h"
#include "batten/skinning/surfaces/skin_network.h"

namespace batten {
namespace {

/// Half of the tolerance is the lines' own deviation from their curves.
constexpr double kMaxGap = 0.7;
constexpr int kMaxRounds = 8;

/// Triangles that a sculpted shape may have after it was refined.
int max_refined_triangles(const ModelLayout& layout) {
  constexpr int usual = 20'000, times = 4;
  return std::max(usual, times * layout.mesh()->triangle_count());
}

/// Degrees between the surface's normal at a place and a direction, either sign.
double normal_deviation_degrees(const Surface& surface, const Location& where,
                                const Vec3& direction) {
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
  auto materials = layout.scale_to_regions({bends});
  materials.resize(static_cast<size_t>(layout.mesh()->triangle_count()), materials[0]);
  assembler.stiffness(materials, K);
  const Points q = dofs - layout.position_dofs() * layout.origin().transpose();
  const double energy = q.cwiseProduct(Points(K.selfadjointView<Eigen::Lower>() * q)).sum();
  return std::max(0.0, energy) / (layout.size() * layout.size());
}

void set_dofs(SolvedShape& shape, const Points& dofs, const Scene& scene) {
  const ModelLayout& layout = *shape.layout;
  shape.dofs = shape.unloaded = dofs;
  shape.energy = {};
  shape.energy.bending = bending_energy(layout, dofs, scene);
  for (int r = 0; r < layout.region_count(); ++r)
    shape.regions[static_cast<size_t>(r)] = layout.skinned(r, dofs);
}

// Makes the shape fair where the scene asks for that: the whole shape, or where something acts what
// a session bends.
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

// The shape that a network was skinned with.
SolvedShape initial_shape(const BuiltModel& made, const Scene& scene) {
  SolvedShape shape;
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
    // Where make_session() put it: the mesh may be finer by now.
    if (!projector) projector.emplace(*shape.layout, unloaded);
    const ModelPoint at = projector->nearest_inside(c.at).at;
    const Surface& surface = shape.regions[at.region].surface;
    const double degrees = normal_deviation_degrees(surface, surface.locate(at.uv), c.goal);
    if (!(degrees <= shape.max_normal_constraint_deg)) shape.max_normal_constraint_deg = degrees;
  }
  return shape;
}

namespace {

// The shape that a session settles in.
SolvedShape equilibrium_shape(const ModelLayout& layout, const Scene& scene, const BuiltModel& made,
                              const Progress& progress) {
  SessionReference start;
  SculptingSession session = make_session(layout, scene, made, FactorReuse::once, progress, &start);
  const SolveReport report = session.solve_to_equilibrium();
  return shape_of(session, scene, start.unloaded, report);
}

// The same where triangles are halved until gaps are closed.
SolvedShape refined_equilibrium_shape(const BuiltModel& made, const Scene& scene,
                                      const Progress& progress) {
  const bool lines_are_constrained = scene.skin.boundary == SceneSkin::FixedBoundary::Lines;
  ModelLayout layout = *made.model.layout;
  const int most = max_refined_triangles(layout);
  for (int round = 0;; ++round) {
    SolvedShape shape = equilibrium_shape(layout, scene, made, progress);
    if (!lines_are_constrained || round == kMaxRounds) return shape;
    if (widest_gap(shape.regions) <= kMaxGap * layout.tolerance()) return shape;
    if (!halve_at_gaps(layout, shape.regions, most)) return shape;
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
  const int most = max_refined_triangles(layout);
  for (int round = 0; round < kMaxRounds; ++round) {
    SculptingSession session = make_session(layout, scene, made, FactorReuse::once, progress);
    try {
      session.solve_to_equilibrium();
    } catch (const NoSolutionError&) {
      return layout;
    }
    const auto regions = session.regions();
    if (widest_gap(regions) <= kMaxGap * layout.tolerance()) return layout;
    if (!halve_at_gaps(layout, regions, most)) return layout;
  }
  return layout;
}

SculptModel sculpt_model(BuiltModel made, const Scene& scene, const Progress& progress) {
  if (!made.model.layout) throw InputError(scene.at({}) + "no region could be skinned");
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
  // A network at rest was measured when it was skinned.
  if (made.network && shape.layout == made.model.layout && !shape.fairing.surface &&
      !shape.fairing.lofted && !shape.fairing.fit)
    return;
  // A shape that was given may be larger than what its lines mean.
  if (shape.fairing.fit)
    for (ModelRegion& region : made.model.regions) region.filling_area = 0;
  reshape(made.model, shape.layout, shape.dofs, shape.regions, progress);
}

}  // namespace batten
