#include "batten/apps/commands/shapes/fair_shape.h"

#include <algorithm>

#include "batten/apps/commands/shapes/scene_target.h"
#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/core/parallel.h"
#include "batten/sculpting/statics/static_sculpt.h"
#include "batten/skinning/model/loft_shape.h"
#include "batten/skinning/model/rest_shape.h"
#include "batten/skinning/surfaces/skin_network.h"

namespace batten {
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

/// The first rest shape of a session is the fitted one; under other rows, what bends least from it.
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

/// Rest shapes of a session: the first is known.
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
      // What bends least from the last one that could be made is nearer to it than nothing.
      done_->failure_reason = e.what();
      return task.near;
    }
  }

 private:
  Points first_;
  MinimumVariationOptions options_;
  std::vector<char> only_;  // by region: those that are faired; empty: all
  std::shared_ptr<FairingSummary> done_;
  bool first_used_ = false;
};

// Inner curves and holes say what least variation of the outline alone would say otherwise.
bool has_outline_only(const RegionLayout& region) {
  const auto inner = [](const EdgeAlignedLine& aligned_line) {
    return aligned_line.line.role != CharacterLine::Role::Outline;
  };
  return region.embedded().empty() &&
         std::none_of(region.edge_aligned().begin(), region.edge_aligned().end(), inner);
}

// Regions that vary least without being asked for, by region of the layout; none: no regions.
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

// Takes out the regions that fairing moved by more than a share of their size. Whether there are any.
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

}  // namespace

namespace {

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
