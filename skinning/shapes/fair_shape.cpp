// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/shapes/fair_shape.h"

#include <algorithm>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/skinning/model/model_shapes.h"

namespace batten {
namespace {

FairShape lofted_shape(std::shared_ptr<const ModelLayout> layout,
                       const std::vector<std::string>& sections) {
  FairShape shape;
  shape.fairing = std::make_shared<FairingSummary>();
  shape.fairing->lofted = true;
  const double most = 2 * layout->tolerance();
  LoftedModel loft = loft_model(std::move(layout), sections, most);
  shape.layout = std::move(loft.layout);
  shape.dofs = std::move(loft.dofs);
  shape.rest = [sections](const RestShapeInput& task) { return loft_shape(task.layout, sections); };
  return shape;
}

/// The rest shape of a session is the fitted shape at first; under other line constraints, the
/// shape of least bending relative to it.
FairShape fitted_shape(std::shared_ptr<const ModelLayout> layout, const Points& bent,
                       const FairShapeOptions& options, const Progress& progress) {
  if (!options.target) throw InputError("found no target, expected one to fit the shape to");
  FairShape shape;
  shape.fairing = std::make_shared<FairingSummary>();
  ModelFit fit = fit_model(std::move(layout), bent, *options.target, options.fit, progress);
  shape.layout = fit.layout;
  shape.dofs = fit.dofs;
  shape.rest = [first = fit.dofs](const RestShapeInput& task) -> Points {
    return task.near.rows() > 0 || task.bent.rows() != first.rows() ? task.near : first;
  };
  shape.fairing->fit = std::move(fit);
  return shape;
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

// For each region of the layout, true if it continues a given surface.
std::vector<char> regions_with_neighbours(const ModelLayout& layout) {
  std::vector<char> has(static_cast<size_t>(layout.region_count()), 0);
  for (const JoinPlan& plan : layout.join_plans())
    if (!plan.rejected() && plan.join_line.neighbour()) has[plan.join_line.sides[0].region] = 1;
  return has;
}

// True if the region has no inner curves and holes. These define the shape themselves, and minimum
// variation of the outline would contradict them.
bool has_outline_only(const RegionLayout& region) {
  const auto inner = [](const EdgeAlignedLine& aligned_line) {
    return aligned_line.line.role != CharacterLine::Role::Outline;
  };
  const auto embeds_inner = [](const EmbeddedLine& line) {
    return line.line.role != CharacterLine::Role::Outline;
  };
  return std::none_of(region.embedded().begin(), region.embedded().end(), embeds_inner) &&
         std::none_of(region.edge_aligned().begin(), region.edge_aligned().end(), inner);
}

// Regions that are faired without a request, as flags per region of the layout; empty: none.
std::vector<char> automatically_faired_regions(const ModelLayout& layout) {
  if (layout.element() != TriangleElement::HCT) return {};
  constexpr int max_triangles = 3'000;  // of the model: about a second
  if (layout.mesh()->triangle_count() > max_triangles) return {};
  std::vector<char> only(static_cast<size_t>(layout.region_count()), 0);
  const std::vector<char> continues = regions_with_neighbours(layout);
  parallel_for(layout.region_count(), [&](int r) {
    const RegionLayout& region = layout.region(r);
    only[r] = has_outline_only(region) &&
              (continues[r] || (region.embedded().empty() && has_many_sides(region)));
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

// Excludes regions at smooth joins that fairing opened beyond the tolerance. Returns true if there
// are any.
bool exclude_regions_at_opened_joins(const SurfaceModel& model, const FairingResult& faired,
                                     double tolerance_deg, std::vector<char>& only) {
  const ModelLayout& layout = *faired.layout;
  std::vector<SkinnedRegion> regions;
  std::vector<const SkinnedRegion*> pointers;
  for (int r = 0; r < layout.region_count(); ++r)
    regions.push_back(layout.skinned(r, faired.surface.dofs));
  for (const SkinnedRegion& region : regions) pointers.push_back(&region);
  const auto was_within = [&](const std::string& line) {
    return std::none_of(model.joins.begin(), model.joins.end(), [&](const ModelJoin& join) {
      return join.line == line && join.max_inside_deg > tolerance_deg;
    });
  };
  bool any = false;
  for (const JoinPlan& plan : layout.join_plans()) {
    if (plan.rejected() || !was_within(plan.join_line.name)) continue;
    if (measure_join(pointers, plan.join_line, {plan.ends[0].open, plan.ends[1].open})
            .max_inside_deg <= tolerance_deg)
      continue;
    for (const JoinSide& side : plan.join_line.sides)
      if (std::exchange(only[static_cast<size_t>(side.region)], 0)) any = true;
  }
  return any;
}

FairShape minimum_variation_shape(const SurfaceModel& model,
                                  std::shared_ptr<const ModelLayout> layout, const Points& bent,
                                  const FairShapeOptions& given, const Progress& progress) {
  FairShape shape;
  shape.layout = layout;
  shape.fairing = std::make_shared<FairingSummary>();
  const double join_tolerance = given.join_tolerance_deg;
  const MinimumVariationOptions& options = given.variation;
  std::vector<char> only;
  if (given.shape == FairShapeOptions::Shape::Automatic)
    only = automatically_faired_regions(*layout);
  shape.fairing->requested = only.empty();
  try {
    FairingResult faired = fair_model(model, layout, bent, join_tolerance, options, progress, only);
    while (!only.empty() &&
           (!faired.surface.converged || exclude_displaced_regions(faired, bent, only) ||
            exclude_regions_at_opened_joins(model, faired, join_tolerance, only))) {
      if (!faired.surface.converged || std::find(only.begin(), only.end(), 1) == only.end())
        return shape;
      faired = fair_model(model, layout, bent, join_tolerance, options, progress, only);
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

bool has_fair_shape(const FairShapeOptions& options, const ModelLayout* layout) {
  using Shape = FairShapeOptions::Shape;
  if (options.shape != Shape::Automatic) return options.shape != Shape::MinimumBending;
  return layout && !automatically_faired_regions(*layout).empty();
}

FairShape compute_fair_shape(const SurfaceModel& model, std::shared_ptr<const ModelLayout> layout,
                             const Points& bent, const FairShapeOptions& options,
                             const Progress& progress) {
  using Shape = FairShapeOptions::Shape;
  switch (options.shape) {
    case Shape::MinimumBending: {
      FairShape shape;
      shape.layout = std::move(layout);
      shape.dofs = bent;
      shape.fairing = std::make_shared<FairingSummary>();
      shape.fairing->requested = false;
      return shape;
    }
    case Shape::Target:
      return fitted_shape(std::move(layout), bent, options, progress);
    case Shape::Loft:
      return lofted_shape(std::move(layout), options.sections);
    default:
      return minimum_variation_shape(model, std::move(layout), bent, options, progress);
  }
}

}  // namespace batten
