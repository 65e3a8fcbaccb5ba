// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/surfaces/skin_network.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/core/progress.h"
#include "batten/skinning/facets/facets.h"
#include "batten/skinning/model/model_shapes.h"
#include "batten/skinning/surfaces/layout_candidate.h"
#include "batten/skinning/surfaces/model_joins.h"
#include "batten/skinning/surfaces/region_maker.h"
#include "batten/skinning/surfaces/surface_defects.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

// Measurement of a model that has a shape.

/// Computes the quality and area of the regions, the angles of the joins, the volumes of the
/// shells, and the defects of a model with layout and shape. Joins that its layout has rejected
/// become creases.
void measure(SurfaceModel& model, const Progress& progress);

namespace {

class ModelMaker {
 public:
  ModelMaker(const CurveNetwork& network, const FoundRegions& found, const ModelOptions& options,
             const Progress& progress)
      : network_(network),
        options_(options),
        progress_(progress),
        regions_(network, found, options, progress, model_) {}

  SurfaceModel make() {
    std::vector<int> all(model_.regions.size());
    std::iota(all.begin(), all.end(), 0);
    // 1. Orient: done by the constructor of regions_.
    // 2. Lay out and solve each region. The shapes then decide the side of the normals.
    regions_.refine_for_rest_shapes({all.begin(), all.end()});
    regions_.lay_out(all, 0, 0.4);
    regions_.orient_normals();
    progress_.update("joining", 0);
    // 3. Classify edges as creases or smooth joins.
    JoinClassification classification =
        classify_joins(network_, regions_, options_, model_.regions);
    if (drop_misleading_rest_shapes(classification.joins))
      classification = classify_joins(network_, regions_, options_, model_.regions);
    model_.joins = std::move(classification.joins);
    join_lines_ = std::move(classification.join_lines);
    join_of_ = std::move(classification.join_of);
    tessellated_.resize(model_.regions.size());
    // 4. and 5. Solve joined regions together, and measure.
    join();
    return std::move(model_);
  }

 private:
  ModelJoin& join_of(size_t join_line) { return model_.joins[join_of_[join_line]]; }

  // Rest shapes follow from the boundary curves alone. If the shape of least energy continues the
  // given surfaces beside a region better than its rest shape, it gets none. Returns true if there
  // are any.
  bool drop_misleading_rest_shapes(const std::vector<ModelJoin>& joins) {
    std::map<int, std::vector<const ModelJoin*>> of_region;
    for (const ModelJoin& join : joins)
      if (join.neighbour) of_region[join.regions[0]].push_back(&join);
    bool any = false;
    for (const auto& [region, beside_it] : of_region)
      any = regions_.drop_rest_shape_if_better(region, [&](const SkinnedRegion& made) {
        double sum = 0;
        for (const ModelJoin* join : beside_it)
          if (const auto side = side_of(made, 0, join->line))
            sum += network_.edges()[join->edge].length *
                   measure_join({&made}, {join->line, {*side, beside(*side, join->neighbour)}})
                       .mean_deg;
        return sum;
      }) || any;
    return any;
  }

  // Solves the groups of regions that smooth joins connect, and halves edges along joins above the
  // tolerance. Starts again if a join turns out to be worse than a crease.
  void join() {
    std::vector<JoinPlan> plans;
    constexpr int kMaxRounds = 3;
    int round = 0;
    const auto is_final = [&] {
      if (exclude_broken()) return false;
      if (round == kMaxRounds || !repair_spoiled(plans)) return true;
      ++round;
      return false;
    };
    do {
      do plans = joined();
      while (!is_final());
      finish(plans);
    } while (!is_final());
    report_joins(plans);
    for (ModelRegion& region : model_.regions)
      if (region.layout_index >= 0) {
        const auto& more = model_.layout->region(region.layout_index).warnings();
        region.warnings.insert(region.warnings.end(), more.begin(), more.end());
      }
    if (model_.layout) measure(model_, progress_);
  }

  std::vector<JoinPlan> joined() {
    dofs_.assign(model_.regions.size(), {});
    std::vector<JoinPlan> plans;
    for (int round = 0;; ++round) {
      progress_.update("joining", std::min(0.9, (round + 0.2) / (options_.max_join_rounds + 1)));
      plans = solve_groups(dofs_);
      assign_shapes(dofs_);
      const Round left = examine(plans, round < options_.max_join_rounds);
      if (left.halved.empty() && !left.rejected_any) break;
      for (const int a : left.halved) regions_.halve(a);
      regions_.lay_out({left.again.begin(), left.again.end()}, 0.5, 0.9);
      find_sides_again();
    }
    return plans;
  }

  // Remaining work after a round.
  struct Round {
    std::set<int> halved, again;  // edges to halve, and the regions next to them
    bool rejected_any = false;    // a join was rejected
  };

  Round examine(const std::vector<JoinPlan>& plans, bool may_halve) {
    Round left;
    std::vector<JoinQuality> angles(join_lines_.size());
    parallel_for(isize(angles), [&](int s) {
      if (!plans[s].rejected())
        angles[s] = angle_of(model_.regions, join_lines_[s],
                             {plans[s].ends[0].open, plans[s].ends[1].open});
    });
    for (size_t s = 0; s < join_lines_.size(); ++s) {
      if (plans[s].rejected()) continue;
      ModelJoin& join = join_of(s);
      const JoinQuality& angle = angles[s];
      join.max_deg = angle.max_deg;
      join.max_inside_deg = angle.max_inside_deg;
      if (angle.max_inside_deg <= options_.join_tolerance_deg) continue;
      if (!plans[s].at.empty()) {
        // Vertices on an embedded line do not belong to its region's mesh: halving would not help.
        constexpr double kBetterACrease = 2;  // degrees; finer meshes cannot repair more
        if (angle.max_inside_deg <= kBetterACrease) continue;
        reject_embedded(join.edge, angle.max_inside_deg);
        left.rejected_any = true;
      } else if (may_halve) {
        left.halved.insert(join.edge);
        for (const int r : join.regions) left.again.insert(r);
      }
    }
    return left;
  }

  void reject_embedded(int edge, double degrees) {
    rejected_[edge] = "it is embedded in one of its faces, which would leave an angle of " +
                      format_number(degrees) + " degrees";
  }

  // A new layout of a region may carry a line differently (embedded or edge-aligned).
  void find_sides_again() {
    for (size_t s = 0; s < join_lines_.size(); ++s) {
      const int edge = join_of(s).edge;
      for (size_t k = 0; k < regions_.sides(edge).size(); ++k)
        if (const auto side = regions_.side_of(regions_.sides(edge)[k], edge))
          join_lines_[s].sides[k] = *side;
      if (const auto& neighbour = join_of(s).neighbour)
        join_lines_[s].sides[1] = beside(join_lines_[s].sides[0], neighbour);
    }
  }

  // Stores the final state of the joins. Nodes at which smooth lines end without a common tangent
  // plane give a warning.
  void report_joins(const std::vector<JoinPlan>& plans) {
    struct NoPlane {
      std::vector<std::string> lines;
      double apart = 0;        // degrees
      bool requested = false;  // the user specified that one of them is smooth
    };
    std::map<int, NoPlane> without_plane;
    for (size_t s = 0; s < plans.size(); ++s) {
      ModelJoin& join = join_of(s);
      join.why = plans[s].rejection_reason;
      if (plans[s].rejected()) continue;
      join.kind = ModelJoin::Kind::Smooth;
      join.one_domain = plans[s].constant();
      for (size_t e = 0; e < 2; ++e) {
        const JoinEnd& end = plans[s].ends[e];
        join.open[e] = end.open;
        if (!end.open) continue;
        const NetworkEdge& edge = network_.edges()[join.edge];
        if (end.creased) {
          model_.warnings.push_back("edge '" + edge.name + "' ends as a crease at " +
                                    format_point(network_.nodes()[edge.nodes[e]].position) +
                                    ": it is embedded in one of its faces, which leaves an angle "
                                    "of " +
                                    format_number(end.plane_angle_deg) + " degrees");
          continue;
        }
        auto& at_node = without_plane[edge.nodes[e]];
        at_node.lines.push_back("'" + edge.name + "'");
        at_node.apart = std::max(at_node.apart, end.plane_angle_deg);
        at_node.requested = at_node.requested || join.requested;
      }
    }
    for (const auto& [node, found] : without_plane) {
      // The curves form a cone-like point there.
      if (!found.requested && found.apart > options_.crease_angle_deg) continue;
      std::string names;
      for (const std::string& name : found.lines) names += (names.empty() ? "" : ", ") + name;
      model_.warnings.push_back(
          "no common tangent plane at " + format_point(network_.nodes()[node].position) +
          ": curves that meet there deviate from it by up to " + format_number(found.apart) +
          " degrees; these edges end as creases: " + names);
    }
  }

  // Plans the join lines that are not rejected and solves each group. If that fails, rejects some
  // of them and starts again.
  std::vector<JoinPlan> solve_groups(std::vector<Points>& dofs) {
    for (;;) {
      dofs = regions_.initial_shapes();
      std::vector<JoinPlan> plans = plan_all();
      bool all = true;
      for (const RegionGroup& group : join_groups(regions_.layouts(), plans))
        all = solve_group(group, plans, dofs) && all;
      if (all) return plans;
    }
  }

  std::vector<JoinPlan> plan_all() {
    std::vector<JoinPlan> plans(join_lines_.size());
    std::vector<JoinLine> possible;
    std::vector<size_t> index;
    for (size_t s = 0; s < join_lines_.size(); ++s) {
      plans[s].join_line = join_lines_[s];
      if (const auto it = rejected_.find(join_of(s).edge); it != rejected_.end()) {
        plans[s].rejection_reason = it->second;
        continue;
      }
      possible.push_back(join_lines_[s]);
      index.push_back(s);
    }
    std::vector<const RegionLayout*> layouts;
    for (const auto& layout : regions_.layouts()) layouts.push_back(layout.get());
    std::vector<JoinPlan> planned =
        plan_joins(layouts, regions_.initial_shapes(), possible, options_.join_tolerance_deg);
    for (size_t i = 0; i < planned.size(); ++i) plans[index[i]] = std::move(planned[i]);
    return plans;
  }

  // Solves one group. If that fails, rejects some of its joins and returns false.
  bool solve_group(const RegionGroup& group, const std::vector<JoinPlan>& plans,
                   std::vector<Points>& dofs) {
    if (group.plans.empty()) return true;  // a region without joins: its initial shape
    auto& [before, shapes] = solved_[group.regions.front()];
    if (!is_same_problem(before, group)) {
      const ModelLayout layout(regions_.metadata(), group.layouts, group.plans);
      Points all;
      try {
        std::vector<const Points*> rest_shapes;
        for (const int r : group.regions) rest_shapes.push_back(&regions_.rest_shapes()[r]);
        all = layout.minimize_energy(options_.material, rest_dofs(layout, rest_shapes));
      } catch (const CancelledError&) {
        throw;
      } catch (const std::runtime_error& e) {
        reject(plans, group, e.what());
        return false;
      }
      shapes.clear();
      for (int r = 0; r < layout.region_count(); ++r) shapes.push_back(layout.region_dofs(r, all));
      before = group;
    }
    for (size_t i = 0; i < shapes.size(); ++i) dofs[group.regions[i]] = shapes[i];
    return true;
  }

  // Rejects the joins of a group on embedded lines or, if there are none, all of its joins.
  void reject(const std::vector<JoinPlan>& plans, const RegionGroup& group,
              const std::string& why) {
    const bool embedded = std::any_of(group.joins.begin(), group.joins.end(),
                                      [&](size_t s) { return !plans[s].at.empty(); });
    for (const size_t s : group.joins)
      if (plans[s].at.empty() != embedded) rejected_[join_of(s).edge] = why;
  }

  // Excludes regions that cannot be tessellated, because they would invalidate all output files.
  // Returns true if there are any.
  bool exclude_broken() {
    bool any = false;
    std::vector<std::string> why(model_.regions.size());
    parallel_for(isize(why), [&](int r) {
      const auto& made = model_.regions[r].skinned;
      if (!made || made->surface.shared_mesh() == tessellated_[r]) return;
      why[r] = facet_error(*made);
      if (why[r].empty()) tessellated_[r] = made->surface.shared_mesh();
    });
    for (size_t r = 0; r < why.size(); ++r) {
      if (why[r].empty()) continue;
      regions_.exclude(static_cast<int>(r), why[r]);
      for (size_t s = 0; s < join_lines_.size(); ++s)
        for (const JoinSide& side : join_lines_[s].sides)
          if (side.region == static_cast<int>(r))
            rejected_[join_of(s).edge] = "one of its faces could not be skinned";
      any = true;
    }
    return any;
  }

  // Repairs regions that are valid on their own, but inverted or sagging when solved with their
  // neighbours: they are laid out in another way, or else their joins are rejected. Returns true if
  // there are any.
  bool repair_spoiled(const std::vector<JoinPlan>& plans) {
    std::vector<char> spoiled(model_.regions.size(), 0);
    parallel_for(isize(model_.regions), [&](int r) {
      const ModelRegion& region = model_.regions[r];
      if (!region.skinned) return;
      const double expected = region.expected_area;
      spoiled[r] = is_inverted_or_sagging(*region.skinned, expected) &&
                   !is_inverted_or_sagging(
                       regions_.layouts()[r]->region(regions_.initial_shapes()[r]), expected);
    });
    bool any = false;
    for (size_t r = 0; r < spoiled.size(); ++r)
      if (spoiled[r] && (regions_.lay_out_without_rest_shape(static_cast<int>(r)) ||
                         regions_.lay_out_alternative(static_cast<int>(r)))) {
        spoiled[r] = 0;
        any = true;
      }
    if (any) find_sides_again();
    for (size_t s = 0; s < plans.size(); ++s) {
      if (plans[s].rejected()) continue;
      for (const JoinSide& side : join_lines_[s].sides) {
        if (!spoiled[side.region]) continue;
        rejected_[join_of(s).edge] =
            "face '" + model_.regions[side.region].plan.name + "' would be inverted or bulge";
        any = true;
      }
    }
    return any;
  }

  void assign_shapes(const std::vector<Points>& dofs) {
    for (size_t r = 0; r < dofs.size(); ++r)
      if (const auto& layout = regions_.layouts()[r])
        model_.regions[r].skinned = layout->region(dofs[r]);
  }

  // Makes the layout and shape of the model. Joins on embedded lines may be rejected meanwhile.
  void finish(std::vector<JoinPlan>& plans) {
    std::map<int, int> number;
    std::vector<std::shared_ptr<const RegionLayout>> made;
    std::vector<Points> shapes;
    for (size_t r = 0; r < dofs_.size(); ++r) {
      const auto& layout = regions_.layouts()[r];
      if (!layout) continue;
      ModelRegion& region = model_.regions[r];
      region.layout_index = number[static_cast<int>(r)] = isize(made);
      made.push_back(layout);
      shapes.push_back(dofs_[r]);
    }
    if (made.empty()) return;
    std::vector<JoinPlan> joined;
    for (const JoinPlan& plan : plans)
      if (!plan.rejected()) joined.push_back(renumbered(plan, number));
    model_.layout = std::make_shared<const ModelLayout>(regions_.metadata(), std::move(made),
                                                        std::move(joined));
    model_.dofs = model_.layout->all_dofs(shapes);
    JoinedModel refined = refine_embedded_joins({model_.layout, model_.dofs}, options_.material,
                                                options_.join_tolerance_deg, progress_);
    model_.layout = std::move(refined.layout);
    model_.dofs = std::move(refined.dofs);
    // Of the joins that were not rejected before.
    const auto& of_layout = model_.layout->join_plans();
    size_t next = 0;
    for (size_t s = 0; s < plans.size(); ++s) {
      if (plans[s].rejected()) continue;
      const JoinPlan& plan = of_layout[next++];
      if (plan.rejected())
        rejected_[join_of(s).edge] = plans[s].rejection_reason = plan.rejection_reason;
      for (size_t e = 0; e < 2 && !plan.rejected(); ++e)
        if (plan.ends[e].creased) plans[s].ends[e] = plan.ends[e];
    }
    for (ModelRegion& region : model_.regions)
      if (region.layout_index >= 0)
        region.skinned = model_.layout->skinned(region.layout_index, model_.dofs);
  }

  const CurveNetwork& network_;
  const ModelOptions& options_;
  const Progress& progress_;
  SurfaceModel model_;
  RegionMaker regions_;
  std::vector<Points> dofs_;  // by region
  // By region: last mesh that was tessellated.
  std::vector<std::shared_ptr<const ParametricMesh>> tessellated_;
  // Solved groups and their shapes, by their first region; reused if nothing has changed.
  std::map<int, std::pair<RegionGroup, std::vector<Points>>> solved_;
  std::vector<JoinLine> join_lines_;
  std::vector<int> join_of_;             // for each join line, its index in model_.joins
  std::map<int, std::string> rejected_;  // rejected joins by network edge, with the reason
};

}  // namespace

void reshape(SurfaceModel& model, std::shared_ptr<const ModelLayout> layout, Points dofs,
             std::vector<SkinnedRegion> made, const Progress& progress) {
  for (ModelRegion& region : model.regions)
    if (region.layout_index >= 0) region.skinned = std::move(made[region.layout_index]);
  model.layout = std::move(layout);
  model.dofs = std::move(dofs);
  measure(model, progress);
}

SurfaceModel skin_network(const CurveNetwork& network, const FoundRegions& found,
                          const ModelOptions& options, const Progress& progress) {
  const ProgressScope scope(progress);
  return ModelMaker(network, found, options, progress).make();
}

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
        keep(defect, "its minimum-bending shape is inverted");
    }
  }

  FairingResult run(MinimumVariationOptions options, const Progress& progress) {
    for (int rounds = 0, kept_more = 0;;) {
      options.frozen = frozen();
      if (std::find(options.frozen.begin(), options.frozen.end(), 0) == options.frozen.end())
        throw NoSolutionError(faired_.unchanged_regions.empty()
                                  ? "no face is to be faired"
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
      } catch (const Error&) {  // from a step, or from tessellation
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

  // Fixes the regions of a defect. Returns true if one of them was not fixed before.
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

  // Fixes all regions with defects: their curvature may be too large for any step.
  bool keep_all_defective() {
    if (tried_flawed_) return false;
    tried_flawed_ = true;
    bool any = false;
    for (const SurfaceDefect& defect : model_.defects)
      any = keep(defect, "its minimum-bending shape has a defect: " + defect.text) || any;
    return any;
  }

  bool keep_spoiled() {
    bool any = false;
    for (const SurfaceDefect& defect : model_.defects)
      if (!had_.count(key_of(defect)))
        any = keep(defect, "fairing would cause a defect: " + defect.text) || any;
    return any;
  }

  // Marks the triangles along smooth joins above the tolerance.
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
  // True if a region next to the join is faired.
  bool moves(const JoinPlan& plan) const {
    const auto& sides = plan.join_line.sides;
    return moves(sides[0].region) || moves(sides[1].region);
  }

  // Sum of the relative amounts by which joins and line gaps exceed their tolerances.
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

  // Stores the current result and refines. Returns false if there is nothing to refine.
  bool continue_fairing() {
    good_ = {faired_, start_};
    good_misfit_ = misfit();
    return refine();
  }
  // Undoes a refinement that made the result worse. Returns true to try again without closing gaps.
  bool undo_refinement() {
    layout_ = good_->first.layout;
    faired_ = good_->first;
    start_ = good_->second;
    take(faired_.surface.dofs);
    if (!std::exchange(close_gaps_, false)) return false;
    good_misfit_ = misfit();
    return refine();
  }

  // Refines the layout where joins or line gaps exceed their tolerances. Returns false if none do.
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
  std::vector<char> only_;  // by region: true if it is to be faired
  FairingResult faired_;
  std::set<DefectKey> had_;
  bool tried_flawed_ = false, close_gaps_ = true;
  // Last good result, with the start on its mesh.
  std::optional<std::pair<FairingResult, Points>> good_;
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

namespace {

void take_quality(ModelJoin& join, const JoinQuality& quality) {
  join.max_deg = quality.max_deg;
  join.max_inside_deg = quality.max_inside_deg;
  join.max_gap = quality.max_gap;
  join.mean_deg = quality.mean_deg;
  join.median_curvature_jump = quality.median_curvature_jump;
  join.max_curvature_jump = quality.max_curvature_jump;
}

void measure_joins(SurfaceModel& model, const std::vector<const SkinnedRegion*>& made) {
  // By line name; of two plans, the one that is not rejected.
  std::map<std::string, const JoinPlan*> plans;
  for (const JoinPlan& plan : model.layout->join_plans()) {
    const JoinPlan*& of_line = plans[plan.join_line.name];
    if (!of_line || of_line->rejected()) of_line = &plan;
  }
  parallel_for(isize(model.joins), [&](int j) {
    ModelJoin& join = model.joins[j];
    if (join.kind == ModelJoin::Kind::Smooth) {
      const auto found = plans.find(join.line);
      const JoinPlan* plan = found == plans.end() ? nullptr : found->second;
      if (plan && !plan->rejected()) {
        take_quality(join,
                     measure_join(made, plan->join_line, {plan->ends[0].open, plan->ends[1].open}));
        join.open = {plan->ends[0].open, plan->ends[1].open};
        join.curvature = is_curvature_continuous(*model.layout, *plan);
        return;
      }
      join.kind = join.neighbour ? ModelJoin::Kind::FreeEdge : ModelJoin::Kind::Crease;
      if (plan) join.why = plan->rejection_reason;
    }
    if (join.kind != ModelJoin::Kind::Crease && !join.neighbour) return;
    std::array<std::optional<JoinSide>, 2> sides;
    for (size_t k = 0; k < join.regions.size(); ++k) {
      const int r = model.regions[join.regions[k]].layout_index;
      if (r >= 0) sides[k] = side_of(*made[r], r, join.line);
    }
    if (join.neighbour && sides[0]) sides[1] = beside(*sides[0], join.neighbour);
    take_quality(join, sides[0] && sides[1]
                           ? measure_join(made, {join.line, {*sides[0], *sides[1]}})
                           : JoinQuality{});
    join.max_inside_deg = 0;
  });
  model.max_join_deg = 0;
  for (const ModelJoin& join : model.joins)
    if (join.kind == ModelJoin::Kind::Smooth)
      model.max_join_deg = std::max(model.max_join_deg, join.max_inside_deg);
}

// Area, volume and normal side of a shell; the volume only if it is closed and all its regions are
// skinned.
void measure_shell(const SurfaceModel& model, ModelShell& shell) {
  shell.area = shell.volume = 0;
  for (const int r : shell.regions) {
    const ModelRegion& region = model.regions[r];
    shell.closed = shell.closed && region.skinned;
    if (region.skinned) shell.area += region.quality.area;
  }
  shell.normals = {};
  if (!shell.orientable) return;
  std::vector<const SkinnedRegion*> made;
  for (const int r : shell.regions)
    if (model.regions[r].skinned) made.push_back(&*model.regions[r].skinned);
  shell.normals = normal_side(side_integrals(made), shell.closed);
  if (!shell.closed) return;
  std::vector<double> under(shell.regions.size());
  parallel_for(isize(under), [&](int k) {
    under[k] = cone_volume(*model.regions[shell.regions[k]].skinned, model.layout->origin());
  });
  for (const double volume : under) shell.volume += volume;
}

// True if two regions meet at a crease that the user specified: it may be a knife edge.
bool has_requested_crease(const SurfaceModel& model, const std::vector<int>& regions) {
  return std::any_of(model.joins.begin(), model.joins.end(), [&](const ModelJoin& join) {
    return join.requested && join.kind == ModelJoin::Kind::Crease &&
           std::is_permutation(join.regions.begin(), join.regions.end(), regions.begin(),
                               regions.end());
  });
}

}  // namespace

void measure(SurfaceModel& model, const Progress& progress) {
  progress.update("measuring", 0);
  const int n = isize(model.regions);
  parallel_for(n, [&](int r) {
    ModelRegion& region = model.regions[r];
    if (!region.skinned) return;
    region.quality = measure(*region.skinned);
    region.shape =
        fit_primitive(*region.skinned, primitive_tolerance(*region.skinned, model.layout->size()));
  });
  std::vector<SkinQuality> qualities;
  std::vector<double> expected_areas;
  std::vector<int> index;
  model.area = 0;
  for (int r = 0; r < n; ++r) {
    const ModelRegion& region = model.regions[r];
    if (!region.skinned) continue;
    qualities.push_back(region.quality);
    expected_areas.push_back(region.expected_area);
    index.push_back(r);
    model.area += region.quality.area;
  }
  const std::vector<const SkinnedRegion*> made = model.skinned();
  measure_joins(model, made);
  for (ModelShell& shell : model.shells) measure_shell(model, shell);
  progress.update("measuring", 0.5);
  model.defects = find_defects(made, qualities, expected_areas);
  for (SurfaceDefect& defect : model.defects)
    for (int& r : defect.regions) r = index[r];
  std::erase_if(model.defects, [&](const SurfaceDefect& defect) {
    return defect.kind == SurfaceDefect::Kind::Fold && defect.regions.size() == 2 &&
           has_requested_crease(model, defect.regions);
  });
  progress.update("measuring", 1);
}

}  // namespace batten
