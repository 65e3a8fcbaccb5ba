#include "batten/apps/commands/shapes/solved_shape.h"

#include <algorithm>
#include <optional>

#include "batten/apps/commands/shapes/make_session.h"
#include "batten/apps/commands/shapes/scene_target.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/fem/surface_assembler.h"
#include "batten/sculpting/statics/static_sculpt.h"
#include "batten/skinning/model/model_projector.h"
#include "batten/skinning/model/model_shapes.h"
#include "batten/skinning/surfaces/skin_network.h"

namespace batten {
namespace {

/// Target gap relative to the tolerance; the rest is left to the deviation of lines from their
/// curves.
constexpr double kMaxGap = 0.7;
constexpr int kMaxRounds = 8;

/// Maximum number of triangles of a sculpted shape after refinement.
int max_refined_triangles(const ModelLayout& layout) {
  constexpr int usual = 20'000, times = 4;
  return std::max(usual, times * layout.mesh()->triangle_count());
}

/// Angle in degrees between the surface normal at a location and a direction, regardless of sign.
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

// Bisects triangles at gaps. Returns false if there are none, or if the mesh would exceed `most`
// triangles.
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
  const double energy = 0.5 * q.cwiseProduct(Points(K.selfadjointView<Eigen::Lower>() * q)).sum();
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
    for (ModelRegion& region : made.model.regions) region.filling_area = 0;
  reshape(made.model, shape.layout, shape.dofs, shape.regions, progress);
}

namespace {

std::vector<std::string> section_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const LocatedString& section : scene.skin.sections) names.push_back(section.text);
  return names;
}

FairShape lofted(const Scene& scene, const BuiltModel& made,
                 std::shared_ptr<const ModelLayout> layout) {
  const std::vector<std::string> sections =
      made.sections.empty() ? section_names(scene) : made.sections;
  FairShape shape;
  shape.fairing = std::make_shared<FairingSummary>();
  shape.fairing->lofted = true;
  try {
    const double most = 2 * layout->tolerance();
    LoftedModel loft = loft_model(std::move(layout), sections, most);
    shape.layout = std::move(loft.layout);
    shape.dofs = std::move(loft.dofs);
  } catch (const InputError& e) {
    if (scene.skin.sections.empty()) throw;
    throw InputError(scene.at(scene.skin.sections.front().location) + e.what());
  }
  shape.rest = [sections](const RestShapeInput& task) { return loft_shape(task.layout, sections); };
  return shape;
}

/// The rest shape of a session is the fitted shape at first; under other line constraints, the
/// shape of least bending relative to it.
FairShape fitted_shape(const Scene& scene, std::shared_ptr<const ModelLayout> layout,
                       const Points& bent, const Progress& progress) {
  FairShape shape;
  shape.fairing = std::make_shared<FairingSummary>();
  const double size = layout->size();
  ModelFitOptions options;
  options.tolerance = target_tolerance(scene, size);
  const TargetParts target = target_of(scene, size, progress);
  options.parts = target.parts;
  ModelFit fit = fit_model(std::move(layout), bent, *target.whole, options, progress);
  shape.layout = fit.layout;
  shape.dofs = fit.dofs;
  shape.rest = [first = fit.dofs](const RestShapeInput& task) -> Points {
    return task.near.rows() > 0 || task.bent.rows() != first.rows() ? task.near : first;
  };
  shape.fairing->fit = std::move(fit);
  return shape;
}

MinimumVariationOptions variation_options(const Scene& scene) {
  MinimumVariationOptions options;
  options.strength = scene.skin.strength;
  if (scene.skin.max_displacement > 0) options.largest_move = scene.skin.max_displacement;
  return options;
}

/// Rest shapes of a session; the first one is known.
class FairRestShape {
 public:
  FairRestShape(Points first, MinimumVariationOptions options, std::vector<char> only,
                std::shared_ptr<FairingSummary> done)
      : first_(std::move(first)),
        options_(std::move(options)),
        only_(std::move(only)),
        done_(std::move(done)) {}

  Points operator()(const RestShapeInput& task) {
    const bool first = task.near.rows() == 0 && task.bent.rows() == first_.rows();
    if (first && !std::exchange(first_used_, true)) return first_;
    MinimumVariationOptions options = options_;
    if (task.near.rows() > 0) options.starts = {task.near};
    options.frozen.assign(task.layout.mesh()->triangle_count(), 0);
    const auto keep = [&](int region) {
      std::fill_n(options.frozen.begin() + task.layout.first_triangle(region),
                  task.layout.region(region).mesh()->triangle_count(), 1);
    };
    for (const UnchangedRegion& unchanged_regions : done_->unchanged_regions)
      keep(unchanged_regions.region);
    for (int r = 0; r < isize(only_); ++r)
      if (!only_[r]) keep(r);
    try {
      done_->surface = fair_shape(task.layout, task.bent, task.rows, options, task.progress);
      done_->failure_reason.clear();
      return done_->surface->dofs;
    } catch (const NoSolutionError& e) {
      // The shape of least bending relative to the last solution is nearer to it than the flat one.
      done_->failure_reason = e.what();
      return task.near;
    }
  }

 private:
  Points first_;
  MinimumVariationOptions options_;
  std::vector<char> only_;  // per region: true if it is faired; empty: all
  std::shared_ptr<FairingSummary> done_;
  bool first_used_ = false;
};

// True if the region has no inner curves and holes. These define the shape themselves, and minimum
// variation of the outline would contradict them.
bool has_outline_only(const RegionLayout& region) {
  const auto inner = [](const EdgeAlignedLine& aligned_line) {
    return aligned_line.line.role != CharacterLine::Role::Outline;
  };
  return region.embedded().empty() &&
         std::none_of(region.edge_aligned().begin(), region.edge_aligned().end(), inner);
}

// Regions that are faired without a request, as flags per region of the layout; empty: none.
std::vector<char> automatically_faired_regions(const Scene& scene, const ModelLayout& layout) {
  const SceneSkin& skin = scene.skin;
  if (skin.fair != SceneSkin::Fair::Auto || skin.boundary != SceneSkin::FixedBoundary::Lines ||
      skin.options.element != TriangleElement::HCT || !skin.isotropic_alpha || !skin.isotropic_beta)
    return {};
  constexpr int max_triangles = 3'000;  // of the model: about a second
  if (layout.mesh()->triangle_count() > max_triangles) return {};
  std::vector<char> only(static_cast<size_t>(layout.region_count()), 0);
  parallel_for(layout.region_count(), [&](int r) {
    const RegionLayout& region = layout.region(r);
    only[r] = has_outline_only(region) && has_many_sides(region);
  });
  if (std::find(only.begin(), only.end(), 1) == only.end()) only.clear();
  return only;
}

// Excludes regions that fairing moved by more than a fraction of their size. Returns true if there
// are any.
bool exclude_displaced_regions(const FairingResult& faired, const Points& start,
                               std::vector<char>& only) {
  constexpr double most = 0.15;
  if (start.rows() != faired.surface.dofs.rows()) return false;  // on another mesh
  const ModelLayout& layout = *faired.layout;
  bool any = false;
  for (int r = 0; r < layout.region_count(); ++r) {
    if (!only[r]) continue;
    const Points before = layout.region_dofs(r, start),
                 after = layout.region_dofs(r, faired.surface.dofs);
    const int vertices = layout.region(r).mesh()->vertex_count();
    double far = 0;
    const DofMap map(*layout.region(r).mesh());
    for (int v = 0; v < vertices; ++v)
      far = std::max(far, (after.row(map.vertex(v)) - before.row(map.vertex(v))).norm());
    if (!(far > most * layout.region(r).size())) continue;
    only[r] = 0;
    any = true;
  }
  return any;
}

FairShape minimum_variation_shape(const Scene& scene, const BuiltModel& made,
                                  std::shared_ptr<const ModelLayout> layout, const Points& bent,
                                  const Progress& progress) {
  FairShape shape;
  shape.layout = layout;
  shape.fairing = std::make_shared<FairingSummary>();
  const double join_tolerance = scene.network.join_tolerance;
  const MinimumVariationOptions options = variation_options(scene);
  std::vector<char> only = automatically_faired_regions(scene, *layout);
  shape.fairing->requested = only.empty();
  try {
    FairingResult faired =
        fair_model(made.model, layout, bent, join_tolerance, options, progress, only);
    while (!only.empty() &&
           (!faired.surface.converged || exclude_displaced_regions(faired, bent, only))) {
      if (!faired.surface.converged || std::find(only.begin(), only.end(), 1) == only.end())
        return shape;
      faired = fair_model(made.model, layout, bent, join_tolerance, options, progress, only);
    }
    shape.fairing->regions = only.empty()
                                 ? faired.layout->region_count()
                                 : static_cast<int>(std::count(only.begin(), only.end(), 1));
    shape.fairing->regions -= isize(faired.unchanged_regions);
    shape.layout = faired.layout;
    shape.dofs = faired.surface.dofs;
    shape.fairing->surface = std::move(faired.surface);
    shape.fairing->unchanged_regions = std::move(faired.unchanged_regions);
  } catch (const CancelledError&) {
    throw;
  } catch (const Error& e) {
    if (!shape.fairing->requested) return shape;
    shape.fairing->surface.emplace();
    shape.fairing->failure_reason = e.what();
    return shape;
  }
  shape.rest = FairRestShape(shape.dofs, options, std::move(only), shape.fairing);
  return shape;
}

bool is_loft(const Scene& scene, const BuiltModel& made) {
  return scene.skin.fair == SceneSkin::Fair::Loft ||
         (scene.skin.fair == SceneSkin::Fair::Auto && !made.sections.empty());
}

}  // namespace

bool requests_fair_shape(const Scene& scene, const BuiltModel& made) {
  return is_loft(scene, made) || scene.skin.is_faired() || !scene.targets.empty() ||
         (made.model.layout && !automatically_faired_regions(scene, *made.model.layout).empty());
}

FairShape compute_fair_shape(const Scene& scene, const BuiltModel& made,
                             std::shared_ptr<const ModelLayout> layout, const Points& bent,
                             const Progress& progress) {
  if (!scene.targets.empty()) return fitted_shape(scene, std::move(layout), bent, progress);
  if (is_loft(scene, made)) return lofted(scene, made, std::move(layout));
  return minimum_variation_shape(scene, made, std::move(layout), bent, progress);
}

Points min_bending_shape(const ModelLayout& layout, const Scene& scene, const Progress& progress) {
  StaticTask lines;
  lines.material = scene.skin.material;
  lines.units = scene.skin.units;
  lines.fix_corners_only = scene.skin.boundary == SceneSkin::FixedBoundary::Corners;
  return sculpt(layout, lines, progress).dofs;
}

}  // namespace batten
