#include "batten/skinning/target/fit_model.h"

#include <algorithm>
#include <string>

#include "batten/core/errors.h"
#include "batten/skinning/region/quality.h"
#include "batten/skinning/surfaces/embedded_joins.h"
#include "batten/skinning/target/acceleration.h"
#include "batten/skinning/target/fit_rounds.h"
#include "batten/skinning/target/region_parts.h"

namespace batten {
namespace {

// ε: from the first one by tens to the one that spreads parameters evenly, at last so little that it pulls nothing.
constexpr double kFirst = 100, kSpreading = 1e-3, kLast = 1e-5;

class Fitting {
 public:
  Fitting(std::shared_ptr<const ModelLayout> layout, const Points& start,
          const TargetSurface& target, const ModelFitOptions& options, const Progress& progress)
      : target_(target), options_(options), progress_(progress) {
    if (!(options.tolerance >= 0))
      throw InputError("tolerance of the target " + std::to_string(options.tolerance) +
                       ", expected 0 or more");
    fit_.layout = start_layout_ = std::move(layout);
    fit_.dofs = start_ = start;
    tolerance_ = options.tolerance > 0 ? options.tolerance : 1e-4 * fit_.layout->size();
  }

  ModelFit run() {
    fit_.before = measured(false);
    int points = 0;
    for (const Distances& region : fit_.before.regions) points += region.points;
    if (points == 0) throw InputError("no point of the target is near to the surface");
    of_region_ = parts_of_regions(*fit_.layout, options_.parts, tolerance_);
    choose_maps();
    for (auto& part : of_region_)
      if (!part) part = &target_;
    sides_ = target_sides(*fit_.layout, fit_.dofs, of_region_);
    on_first_mesh();
    // The largest distance may stay for a while where others fall.
    constexpr int most_idle = 2;
    ModelFit best = fit_;
    double least = misses(), now = least;
    for (int idle = 0; idle < most_idle && now > 1 && fit_.halvings < options_.most_halvings;) {
      if (!halve()) break;
      constexpr double least_gain = 0.9;
      now = misses();
      idle = now < least_gain * least ? 0 : idle + 1;
      if (now >= least) continue;
      least = now;
      best = fit_;
    }
    fit_ = std::move(best);
    if (fit_.after.there() > fit_.before.there()) go_back();
    if (fit_.after.back.points == 0) fit_.after.back = way_back(*fit_.layout, fit_.dofs, target_);
    fit_.reached = fit_.after.largest() <= tolerance_;
    return std::move(fit_);
  }

 private:
  /// Nearest points lead to what is near, and spread better where corners are sharp: maps are for regions that
  /// their lines say little of.
  void choose_maps() {
    maps_ = maps_of_regions(*fit_.layout, fit_.dofs, of_region_, tolerance_);
    constexpr double far = 0.1;  // of the region's size
    for (int r = 0; r < count_of(maps_); ++r) {
      const RegionLayout& region = fit_.layout->region(r);
      const Distances& before = fit_.before.regions[r];
      if (!region.convex() && before.largest < far * region.size() &&
          before.beyond <= before.points)
        maps_[r] = {};
    }
  }

  /// The first shape: the fairest one that is clearly within the tolerance, or the nearest one.
  void on_first_mesh() {
    FitRounds rounds(fit_.layout, of_region_, target_);
    const bool all = std::all_of(maps_.begin(), maps_.end(), [](const auto& map) { return !!map; });
    for (double epsilon = all ? 1 : kFirst; epsilon > 0.5; epsilon /= 10) {
      rounds.prepare(epsilon);
      fit_.dofs = rounds.round(fit_.dofs, sides_, maps_);
      ++fit_.rounds;
    }
    const auto sides = target_sides(*fit_.layout, fit_.dofs, of_region_);
    for (size_t r = 0; r < maps_.size(); ++r)
      if (maps_[r]) sides_[r] = sides[r];
    constexpr std::pair<double, int> fair[] = {{1, 4}, {0.03, 4}, {kSpreading, 8}};  // ε, rounds
    for (const auto& [epsilon, most] : fair) {
      settle(rounds, epsilon, most);
      if (clearly_near(rounds)) return finish(rounds);
    }
    settle_firmly(rounds);
    finish(rounds);
  }

  bool clearly_near(FitRounds& rounds) {
    constexpr double clearly = 0.5;  // of the tolerance
    return measured(false).there() <= clearly * tolerance_ && !rounds.hold_folds(fit_.dofs, sides_);
  }

  void on_finer_mesh() {
    FitRounds rounds(fit_.layout, of_region_, target_);
    settle_firmly(rounds);
    finish(rounds);
  }

  /// Without bending but where the surface would turn over.
  void settle_firmly(FitRounds& rounds) {
    const Points even = fit_.dofs;
    settle(rounds, kLast, options_.most_rounds);
    constexpr int most_holds = 2;
    for (int hold = 0; hold < most_holds && rounds.hold_folds(fit_.dofs, sides_); ++hold) {
      fit_.dofs = even;
      settle(rounds, kLast, options_.most_rounds);
    }
  }

  void finish(FitRounds& rounds) {
    replan_joins(rounds);
    fit_.after = measured(true);
  }

  /// To the target and back, or there only, which is faster far away from it; the largest distance of each
  /// triangle is kept.
  TargetDistances measured(bool both) {
    progress_.at("measure the fit", 0);
    TargetDistances result = target_distances(*fit_.layout, fit_.dofs, target_, &largest_of_);
    // What is much too far away one way needs no other one.
    constexpr double near = 4;  // times the tolerance
    if (both && result.there() <= near * tolerance_)
      result.back = way_back(*fit_.layout, fit_.dofs, target_, &largest_of_);
    return result;
  }

  void settle(FitRounds& rounds, double epsilon, int most_rounds) {
    rounds.prepare(epsilon_ = epsilon);
    Acceleration faster(rounds.mass());
    for (int round = 0; round < most_rounds; ++round) {
      progress_.at("fit to the target", double(round) / most_rounds);
      fit_.dofs = faster.next(fit_.dofs, rounds.round(fit_.dofs, sides_));
      ++fit_.rounds;
      if (rounds.largest_move() < 0.1 * tolerance_) break;
    }
  }

  /// Smooth joins hold the tangent planes that a shape had: they are planned again from the fitted one.
  void replan_joins(FitRounds& rounds) {
    constexpr int most = 4;
    for (int again = 0; again < most && !fit_.layout->join_plans().empty(); ++again) {
      auto planned = std::make_shared<ModelLayout>(*fit_.layout);
      planned->plan_joins(fit_.dofs);
      fit_.layout = std::move(planned);
      rounds.take(fit_.layout);
      rounds.prepare(epsilon_);
      for (int round = 0; round < 3; ++round, ++fit_.rounds)
        fit_.dofs = rounds.round(fit_.dofs, sides_);
      if (fit_.layout->join_misfit(fit_.dofs) < 1e-3) break;
    }
  }

  /// Over what is promised: the distance, and the widest gap at an embedded line.
  double misses() const {
    double gap = 0;
    for (int r = 0; r < fit_.layout->region_count(); ++r) {
      if (fit_.layout->region(r).embedded().empty()) continue;
      const SkinnedRegion region = fit_.layout->skinned(r, fit_.dofs);
      for (const EmbeddedLine& line : region.embedded)
        gap = std::max(gap, line_gap(region.surface, line));
    }
    return std::max(fit_.after.largest() / tolerance_, gap / fit_.layout->tolerance());
  }

  /// What came out worse than the start is not kept.
  void go_back() {
    fit_.layout = start_layout_;
    fit_.dofs = start_;
    fit_.halvings = 0;
    fit_.after = measured(true);
  }

  /// False where there is nothing to gain.
  bool halve() {
    const ModelLayout& layout = *fit_.layout;
    std::vector<char> marks(layout.mesh()->triangle_count(), 0);
    int count = 0;
    constexpr double margin = 0.5;  // of the tolerance: next time the largest distance is elsewhere
    const std::vector<double> off = off_lines();
    for (int r = 0; r < layout.region_count(); ++r)
      mark_gaps(layout.skinned(r, fit_.dofs), 0.5 * layout.tolerance(),
                marks.data() + layout.first_triangle(r));
    FitRounds::mark_turns(layout, fit_.dofs, marks);
    for (int t = 0; t < count_of(marks); ++t) {
      const double floor = std::max(margin * tolerance_, 1.2 * off[layout.region_of(t)]);
      marks[t] |= largest_of_[t] > floor;
      count += marks[t];
    }
    if (count == 0 || layout.mesh()->triangle_count() + count > options_.most_triangles)
      return false;
    auto finer = std::make_shared<ModelLayout>(layout);
    if (!finer->refine(marks)) return false;
    fit_.dofs = carried_over(layout, fit_.dofs, *finer);
    finer->plan_joins(fit_.dofs);
    fit_.layout = std::move(finer);
    ++fit_.halvings;
    on_finer_mesh();
    return true;
  }

  /// How far the lines of each region are from the target.
  std::vector<double> off_lines() const {
    std::vector<double> off(fit_.layout->region_count(), 0.0);
    const auto& lines = fit_.layout->lines();
    for (size_t l = 0; l < lines.size(); ++l)
      for (const LineSide& side : lines[l].sides)
        off[side.region] = std::max(off[side.region], fit_.after.lines[l].largest);
    return off;
  }

  const TargetSurface& target_;
  std::vector<const TargetSurface*> of_region_;
  std::vector<TargetSurface::Map> maps_;
  const ModelFitOptions& options_;
  const Progress& progress_;
  double tolerance_ = 0;
  double epsilon_ = kFirst;  // the last one
  std::shared_ptr<const ModelLayout> start_layout_;
  Points start_;
  ModelFit fit_;
  std::vector<double> sides_;
  VecX largest_of_;
};

}  // namespace

ModelFit fit_model(std::shared_ptr<const ModelLayout> layout, const Points& start,
                   const TargetSurface& target, const ModelFitOptions& options,
                   const Progress& progress) {
  return Fitting(std::move(layout), start, target, options, progress).run();
}

}  // namespace batten
