#include "batten/skinning/surfaces/fair_model.h"

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "batten/core/errors.h"
#include "batten/skinning/surfaces/embedded_joins.h"
#include "batten/skinning/surfaces/skin_network.h"

namespace batten {
namespace {

using DefectKey = std::pair<SurfaceDefect::Kind, std::vector<int>>;

DefectKey key_of(const SurfaceDefect& defect) {
  std::vector<int> regions = defect.regions;
  std::sort(regions.begin(), regions.end());
  return {defect.kind, std::move(regions)};
}

class ModelFairing {
 public:
  ModelFairing(const SurfaceModel& model, std::shared_ptr<const ModelLayout> layout,
               const Points& start, double max_join_angle_deg, std::vector<char> only)
      : model_(model),
        layout_(std::move(layout)),
        start_(start),
        max_join_angle_deg_(max_join_angle_deg),
        only_(std::move(only)) {
    if (only_.empty()) only_.assign(static_cast<size_t>(layout_->region_count()), 1);
    const bool measured =
        model_.layout == layout_ && model_.dofs.rows() == start.rows() && model_.dofs == start;
    if (!measured) take(start);
    for (const SurfaceDefect& defect : model_.defects) {
      had_.insert(key_of(defect));
      if (defect.kind == SurfaceDefect::Kind::Jacobian)
        keep(defect, "its bending shape turns over");
    }
  }

  FairingResult run(MinimumVariationOptions options, const Progress& progress) {
    for (int rounds = 0, kept_more = 0;;) {
      options.frozen = frozen();
      if (std::find(options.frozen.begin(), options.frozen.end(), 0) == options.frozen.end())
        throw NoSolutionError(faired_.unchanged_regions.empty()
                                  ? "no region is to be faired"
                                  : faired_.unchanged_regions.front().why);
      if (std::find(options.frozen.begin(), options.frozen.end(), 1) == options.frozen.end())
        options.frozen.clear();
      bool spoiled = false, others_kept = false;
      try {
        take(fair_shape(*layout_, start_, layout_->line_constraints(), options, progress));
        faired_.layout = layout_;
        others_kept = keep_spoiled();
        spoiled = others_kept || (good_ && !(misfit() < good_misfit_));
      } catch (const CancelledError&) {
        throw;
      } catch (const Error&) {  // of a step, or of facets that cannot be made any more
        spoiled = good_ || keep_all_defective();
        if (!spoiled) throw;
      }
      if (spoiled && !good_) continue;
      constexpr int kMaxRounds = 3, kMaxKeptMore = 3;
      if (others_kept && kept_more++ < kMaxKeptMore) continue;
      if (spoiled ? !undo_refinement() : rounds++ >= kMaxRounds || !continue_fairing())
        return std::move(faired_);
      options.starts = {faired_.surface.dofs};
    }
  }

 private:
  void take(MinimumVariationSurface surface) {
    const MinimumVariationSurface& before = faired_.surface;
    surface.iterations += before.iterations;
    surface.factorizations += before.factorizations;
    if (before.iterations > 0) surface.start_functional = before.start_functional;
    faired_.surface = std::move(surface);
    take(faired_.surface.dofs);
  }

  void take(const Points& dofs) {
    std::vector<SkinnedRegion> regions;
    for (int r = 0; r < layout_->region_count(); ++r) regions.push_back(layout_->skinned(r, dofs));
    reshape(model_, layout_, dofs, std::move(regions));
  }

  // Whether any of its regions was not kept before.
  bool keep(const SurfaceDefect& defect, const std::string& why) {
    bool any = false;
    for (const int r : defect.regions) {
      const int own = model_.regions[r].layout_index;
      const bool known = !moves(own);
      if (!known) faired_.unchanged_regions.push_back({own, why});
      any = any || !known;
    }
    return any;
  }

  // Curvature may be too large there for any step.
  bool keep_all_defective() {
    if (tried_flawed_) return false;
    tried_flawed_ = true;
    bool any = false;
    for (const SurfaceDefect& defect : model_.defects)
      any = keep(defect, "its bending shape is wrong: " + defect.text) || any;
    return any;
  }

  bool keep_spoiled() {
    bool any = false;
    for (const SurfaceDefect& defect : model_.defects)
      if (!had_.count(key_of(defect)))
        any = keep(defect, "it would come out wrong: " + defect.text) || any;
    return any;
  }

  // Marks the triangles along smooth joins that are above the tolerance.
  void mark_joins(std::vector<char>& marks) const {
    for (const ModelJoin& join : model_.joins) {
      const JoinPlan* plan = layout_->join_plan(join.line);
      if (!plan || !moves(*plan) || !(join.max_inside_deg > max_join_angle_deg_)) continue;
      for (const JoinSide& side : plan->join_line.sides) mark_along(*layout_, side, marks);
    }
  }

  bool moves(int region) const {
    return only_[region] &&
           std::none_of(faired_.unchanged_regions.begin(), faired_.unchanged_regions.end(),
                        [&](const UnchangedRegion& unchanged_regions) {
                          return unchanged_regions.region == region;
                        });
  }
  // Whether a region beside the join is faired.
  bool moves(const JoinPlan& plan) const {
    const auto& sides = plan.join_line.sides;
    return moves(sides[0].region) || moves(sides[1].region);
  }

  // How far the shape is from its lines and joins, beyond and over what is allowed, in all.
  double misfit() const {
    double sum = 0;
    for (const ModelJoin& join : model_.joins)
      if (const JoinPlan* plan = layout_->join_plan(join.line); plan && moves(*plan))
        sum += std::max(0.0, join.max_inside_deg / max_join_angle_deg_ - 1);
    for (const ModelRegion& region : model_.regions)
      if (close_gaps_ && region.layout_index >= 0)
        sum += std::max(0.0, region.quality.max_line_gap / layout_->tolerance() - 1);
    return sum;
  }

  // Remembers this shape and goes over to a finer layout. False where there is nothing to halve.
  bool continue_fairing() {
    good_ = {faired_, start_};
    good_misfit_ = misfit();
    return refine();
  }
  // Finer meshes spoiled it: back to the shape before. True for another try, with gaps as they are.
  bool undo_refinement() {
    layout_ = good_->first.layout;
    faired_ = good_->first;
    start_ = good_->second;
    take(faired_.surface.dofs);
    if (!std::exchange(close_gaps_, false)) return false;
    good_misfit_ = misfit();
    return refine();
  }

  // Goes over to a finer layout where the shape left its lines or joins. False when it did not.
  bool refine() {
    std::vector<char> marks(layout_->mesh()->triangle_count(), 0);
    mark_joins(marks);
    for (const ModelRegion& region : model_.regions)
      if (close_gaps_ && region.layout_index >= 0 &&
          region.quality.max_line_gap > layout_->tolerance())
        mark_gaps(*region.skinned, 0.5 * layout_->tolerance(),
                  marks.data() + layout_->first_triangle(region.layout_index));
    auto finer = std::make_shared<ModelLayout>(*layout_);
    if (!finer->refine(marks)) return false;
    start_ = interpolate_onto(*layout_, start_, *finer);
    faired_.surface.dofs = interpolate_onto(*layout_, faired_.surface.dofs, *finer);
    finer->plan_joins(faired_.surface.dofs);
    layout_ = std::move(finer);
    return true;
  }

  std::vector<char> frozen() const {
    std::vector<char> triangles(layout_->mesh()->triangle_count(), 0);
    for (int r = 0; r < layout_->region_count(); ++r)
      if (!moves(r))
        std::fill_n(triangles.begin() + layout_->first_triangle(r),
                    layout_->region(r).mesh()->triangle_count(), 1);
    return triangles;
  }

  SurfaceModel model_;
  std::shared_ptr<const ModelLayout> layout_;
  Points start_;
  double max_join_angle_deg_;
  std::vector<char> only_;  // by region: those to be faired
  FairingResult faired_;
  std::set<DefectKey> had_;
  bool tried_flawed_ = false, close_gaps_ = true;
  std::optional<std::pair<FairingResult, Points>> good_;  // and the start on its mesh
  double good_misfit_ = 0;
};

}  // namespace

FairingResult fair_model(const SurfaceModel& model, std::shared_ptr<const ModelLayout> layout,
                         const Points& start, double max_join_angle_deg,
                         const MinimumVariationOptions& options, const Progress& progress,
                         const std::vector<char>& only) {
  return ModelFairing(model, std::move(layout), start, max_join_angle_deg, only)
      .run(options, progress);
}

}  // namespace batten
