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

using FlawKey = std::pair<SurfaceFlaw::Kind, std::vector<int>>;

FlawKey key_of(const SurfaceFlaw& flaw) {
  std::vector<int> regions = flaw.regions;
  std::sort(regions.begin(), regions.end());
  return {flaw.kind, std::move(regions)};
}

class ModelFairing {
 public:
  ModelFairing(const SurfaceModel& model, std::shared_ptr<const ModelLayout> layout,
               const Points& start, double most_join_deg, std::vector<char> only)
      : model_(model),
        layout_(std::move(layout)),
        start_(start),
        most_join_deg_(most_join_deg),
        only_(std::move(only)) {
    if (only_.empty()) only_.assign(static_cast<size_t>(layout_->region_count()), 1);
    const bool measured =
        model_.layout == layout_ && model_.dofs.rows() == start.rows() && model_.dofs == start;
    if (!measured) take(start);
    for (const SurfaceFlaw& flaw : model_.flaws) {
      had_.insert(key_of(flaw));
      if (flaw.kind == SurfaceFlaw::Kind::Jacobian) keep(flaw, "its bending shape turns over");
    }
  }

  FairedModel run(VariationOptions options, const Progress& progress) {
    for (int rounds = 0, kept_more = 0;;) {
      options.still = still();
      if (std::find(options.still.begin(), options.still.end(), 0) == options.still.end())
        throw NoSolutionError(faired_.kept.empty() ? "no region is to be faired"
                                                   : faired_.kept.front().why);
      if (std::find(options.still.begin(), options.still.end(), 1) == options.still.end())
        options.still.clear();
      bool spoiled = false, others_kept = false;
      try {
        take(fair_shape(*layout_, start_, layout_->line_constraints(), options, progress));
        faired_.layout = layout_;
        others_kept = keep_spoiled();
        spoiled = others_kept || (good_ && !(misfit() < good_misfit_));
      } catch (const CancelledError&) {
        throw;
      } catch (const Error&) {  // of a step, or of facets that cannot be made any more
        spoiled = good_ || keep_all_flawed();
        if (!spoiled) throw;
      }
      if (spoiled && !good_) continue;
      constexpr int most_rounds = 3, most_kept_more = 3;
      if (others_kept && kept_more++ < most_kept_more) continue;
      if (spoiled ? !go_back() : rounds++ >= most_rounds || !go_on()) return std::move(faired_);
      options.starts = {faired_.surface.dofs};
    }
  }

 private:
  void take(VariationSurface surface) {
    const VariationSurface& before = faired_.surface;
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
  bool keep(const SurfaceFlaw& flaw, const std::string& why) {
    bool any = false;
    for (const int r : flaw.regions) {
      const int own = model_.regions[r].in_layout;
      const bool known = !moves(own);
      if (!known) faired_.kept.push_back({own, why});
      any = any || !known;
    }
    return any;
  }

  // Curvature may be too large there for any step.
  bool keep_all_flawed() {
    if (tried_flawed_) return false;
    tried_flawed_ = true;
    bool any = false;
    for (const SurfaceFlaw& flaw : model_.flaws)
      any = keep(flaw, "its bending shape is wrong: " + flaw.text) || any;
    return any;
  }

  bool keep_spoiled() {
    bool any = false;
    for (const SurfaceFlaw& flaw : model_.flaws)
      if (!had_.count(key_of(flaw)))
        any = keep(flaw, "it would come out wrong: " + flaw.text) || any;
    return any;
  }

  // Marks the triangles along smooth joins that are above the tolerance.
  void mark_joins(std::vector<char>& marks) const {
    for (const ModelJoin& join : model_.joins) {
      const JoinPlan* plan = layout_->join_plan(join.line);
      if (!plan || !moves(*plan) || !(join.max_inside_deg > most_join_deg_)) continue;
      for (const JoinSide& side : plan->join_line.sides) mark_along(*layout_, side, marks);
    }
  }

  bool moves(int region) const {
    return only_[region] &&
           std::none_of(faired_.kept.begin(), faired_.kept.end(),
                        [&](const KeptRegion& kept) { return kept.region == region; });
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
        sum += std::max(0.0, join.max_inside_deg / most_join_deg_ - 1);
    for (const ModelRegion& region : model_.regions)
      if (close_gaps_ && region.in_layout >= 0)
        sum += std::max(0.0, region.quality.max_line_gap / layout_->tolerance() - 1);
    return sum;
  }

  // Remembers this shape and goes over to a finer layout. False where there is nothing to halve.
  bool go_on() {
    good_ = {faired_, start_};
    good_misfit_ = misfit();
    return refine();
  }
  // Finer meshes spoiled it: back to the shape before. True for another try, with gaps as they are.
  bool go_back() {
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
      if (close_gaps_ && region.in_layout >= 0 &&
          region.quality.max_line_gap > layout_->tolerance())
        mark_gaps(*region.skinned, 0.5 * layout_->tolerance(),
                  marks.data() + layout_->first_triangle(region.in_layout));
    auto finer = std::make_shared<ModelLayout>(*layout_);
    if (!finer->refine(marks)) return false;
    start_ = carried_over(*layout_, start_, *finer);
    faired_.surface.dofs = carried_over(*layout_, faired_.surface.dofs, *finer);
    finer->plan_joins(faired_.surface.dofs);
    layout_ = std::move(finer);
    return true;
  }

  std::vector<char> still() const {
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
  double most_join_deg_;
  std::vector<char> only_;  // by region: those to be faired
  FairedModel faired_;
  std::set<FlawKey> had_;
  bool tried_flawed_ = false, close_gaps_ = true;
  std::optional<std::pair<FairedModel, Points>> good_;  // and the start on its mesh
  double good_misfit_ = 0;
};

}  // namespace

FairedModel fair_model(const SurfaceModel& model, std::shared_ptr<const ModelLayout> layout,
                       const Points& start, double most_join_deg, const VariationOptions& options,
                       const Progress& progress, const std::vector<char>& only) {
  return ModelFairing(model, std::move(layout), start, most_join_deg, only).run(options, progress);
}

}  // namespace batten
