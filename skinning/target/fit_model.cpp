#include "batten/skinning/target/fit_model.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "batten/constraints/constrained_solver.h"
#include "batten/core/chunks.h"
#include "batten/core/errors.h"
#include "batten/fem/assembly.h"
#include "batten/skinning/region/quality.h"
#include "batten/skinning/surfaces/embedded_joins.h"
#include "batten/skinning/target/acceleration.h"
#include "batten/skinning/target/region_parts.h"

namespace batten {
namespace {

// ε: from the first one by tens to the one that spreads parameters evenly, at last so little that it pulls nothing.
constexpr double kFirst = 100, kSpreading = 1e-3, kLast = 1e-5;

/// One mesh: its matrices, and rounds on it.
class FitRounds {
 public:
  FitRounds(std::shared_ptr<const ModelLayout> layout, std::vector<const TargetSurface*> targets,
            const TargetSurface& whole)
      : layout_(std::move(layout)),
        whole_(whole),
        targets_(std::move(targets)),
        // What lies outside of a trim has no springs: bending alone shapes it.
        assembler_(*layout_->mesh(), layout_->element(), layout_->trim(), 1),
        scale_(layout_->domain_scale()),
        ones_(layout_->position_dofs()),
        held_(layout_->mesh()->triangle_count(), 1.0),
        mass_(assembler_.mass(scale_)) {
    about_origin_ = ones_ * layout_->origin().transpose();
  }

  /// Other rows or another ε: a factor.
  void prepare(double epsilon) {
    bending_ = assembler_.pattern();
    std::vector<SurfaceStiffness> materials;
    double mean = 0;
    const int count = layout_->mesh()->triangle_count();
    for (int t = 0; t < count; ++t) {
      const double h2 = 2 * layout_->mesh()->shape(t).area * scale_of(t);
      materials.push_back(SurfaceStiffness::isotropic(0, held_[t] * epsilon * h2 * h2));
      mean += epsilon * h2 * h2 / count;
    }
    assembler_.stiffness(layout_->on_regions(std::move(materials)), bending_);
    bending_ += mean * layout_->join_stiffness();
    const ConstraintSet rows = layout_->line_constraints().moved(ones_, layout_->origin());
    if (solver_)
      solver_->update(rows, mass_ + bending_);
    else
      solver_.emplace(rows, mass_ + bending_, layout_->dof_order());
  }

  /// One round from absolute dofs. The largest move of any vertex is noted.
  Points round(const Points& dofs, const std::vector<double>& sides) {
    const Surface surface = layout_->surface(dofs);
    const Points pull = assembler_.load(
        [&](const Location& where, const Vec2&) -> Vec3 {
          return scale_of(where.triangle) * slide(surface.jet(where),
                                                  *targets_[layout_->region_of(where.triangle)],
                                                  side_of(sides, where.triangle));
        },
        4);
    const Points own = dofs - about_origin_;
    const Points moved = solver_->solve(pull + mass_.selfadjointView<Eigen::Lower>() * own);
    largest_move_ = 0;
    for (int v = 0; v < layout_->mesh()->vertex_count(); ++v)
      largest_move_ = std::max(largest_move_, (moved.row(3 * v) - own.row(3 * v)).norm());
    return moved + about_origin_;
  }
  const SparseMatrix& mass() const { return mass_; }
  /// Triangles that turned over, and those around them, are held more firmly from the next prepare() on.
  bool hold_folds(const Points& dofs) {
    const auto& mesh = *layout_->mesh();
    const Surface surface = layout_->surface(dofs);
    std::vector<char> marks(mesh.triangle_count(), 0);
    for_each_in_chunks<64>(mesh.triangle_count(), [&](int t) { marks[t] = folds(surface, t); });
    if (std::none_of(marks.begin(), marks.end(), [](char m) { return m; })) return false;
    constexpr int rings = 2;
    constexpr double firmer = 100;
    for (int ring = 0; ring < rings; ++ring) {
      std::vector<char> touched(mesh.vertex_count(), 0);
      for (int t = 0; t < mesh.triangle_count(); ++t)
        for (const int v : mesh.triangles()[t]) touched[v] |= marks[t];
      for (int t = 0; t < mesh.triangle_count(); ++t)
        for (const int v : mesh.triangles()[t]) marks[t] |= touched[v];
    }
    for (int t = 0; t < mesh.triangle_count(); ++t)
      if (marks[t]) held_[t] *= firmer;
    return true;
  }
  double largest_move() const { return largest_move_; }

 private:
  double scale_of(int triangle) const { return scale_.size() > 0 ? scale_[triangle] : 1; }
  double side_of(const std::vector<double>& sides, int triangle) const {
    return sides[layout_->region_of(triangle)];
  }

  static bool folds(const Surface& surface, int t) {
    constexpr double least = 0.05;  // of the mean area
    constexpr int n = 4;
    std::vector<Vec3> areas;
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j) {
        const Vec3 L(double(i) / n, double(j) / n, double(n - i - j) / n);
        areas.push_back(surface.jet({t, L}).area_vector());
        sum += areas.back();
      }
    const double bound = least * sum.squaredNorm() / count_of(areas);
    return std::any_of(areas.begin(), areas.end(),
                       [&](const Vec3& area) { return area.dot(sum) < bound; });
  }

  /// The nearest point whose normal is not against `along`, unless it is much farther than the nearest of
  /// all: at the edges of thin walls that is on the other side.
  static std::optional<TargetSurface::Nearest> same_side_as(const TargetSurface& target,
                                                            const Vec3& x, const Vec3& along) {
    const auto any = target.nearest(x, Vec3::Zero());
    if (!any || any->normal.dot(along) > 0) return any;
    constexpr double most_times = 3;
    const auto there = target.nearest(x, along);
    if (there && (there->at - x).norm() > most_times * (any->at - x).norm()) return {};
    return there;
  }

  /// g: along the surface's normal to the plane that touches the target.
  Vec3 slide(const SurfaceJet& jet, const TargetSurface& target, double side) const {
    const Vec3 n = jet.normal();
    // Among the points of a region's own part none is on another side.
    const auto there = &target == &whole_ ? same_side_as(target, jet.x, side * n)
                                          : target.nearest(jet.x, Vec3::Zero());
    if (!there) return Vec3::Zero();
    const Vec3 way = there->at - jet.x;
    const double along = n.dot(way), length = way.norm();
    constexpr double sideways = 0.5;  // of the way
    if (there->at_rim && (way - along * n).norm() > sideways * length) return Vec3::Zero();
    // Where normals differ much the plane is no guide: straight towards the point.
    constexpr double most_apart = 0.5;
    const double cosine = n.dot(there->normal);
    if (std::abs(cosine) < most_apart) return along * n;
    return std::clamp(way.dot(there->normal) / cosine, -2 * length, 2 * length) * n;
  }

  std::shared_ptr<const ModelLayout> layout_;
  const TargetSurface& whole_;
  std::vector<const TargetSurface*> targets_;  // of each region
  SurfaceAssembler assembler_;
  VecX scale_, ones_;
  std::vector<double> held_;  // of each triangle, times ε
  Points about_origin_;
  SparseMatrix mass_, bending_;
  std::optional<ConstrainedSolver> solver_;
  double largest_move_ = 0;
};

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
    fit_.reached = fit_.after.largest() <= tolerance_;
    return std::move(fit_);
  }

 private:
  /// The first shape: the fairest one that is clearly within the tolerance, or the nearest one.
  void on_first_mesh() {
    FitRounds rounds(fit_.layout, of_region_, target_);
    for (double epsilon = kFirst; epsilon > 2; epsilon /= 10) settle(rounds, epsilon, 1);
    constexpr std::pair<double, int> fair[] = {{1, 4}, {0.03, 4}, {kSpreading, 8}};  // ε, rounds
    for (const auto& [epsilon, most] : fair) {
      settle(rounds, epsilon, most);
      if (clearly_near(rounds)) return finish();
    }
    settle_firmly(rounds);
    finish();
  }

  bool clearly_near(FitRounds& rounds) {
    constexpr double clearly = 0.5;  // of the tolerance
    return measured(false).there() <= clearly * tolerance_ && !rounds.hold_folds(fit_.dofs);
  }

  void on_finer_mesh() {
    FitRounds rounds(fit_.layout, of_region_, target_);
    settle_firmly(rounds);
    finish();
  }

  /// Without bending but where the surface would turn over.
  void settle_firmly(FitRounds& rounds) {
    const Points even = fit_.dofs;
    settle(rounds, kLast, options_.most_rounds);
    constexpr int most_holds = 2;
    for (int hold = 0; hold < most_holds && rounds.hold_folds(fit_.dofs); ++hold) {
      fit_.dofs = even;
      settle(rounds, kLast, options_.most_rounds);
    }
  }

  void finish() {
    replan_joins();
    fit_.after = measured(true);
  }

  /// To the target and back, or there only, which is faster far away from it; the largest distance of each
  /// triangle is kept.
  TargetDistances measured(bool both) {
    progress_.at("measure the fit", 0);
    TargetDistances result = target_distances(*fit_.layout, fit_.dofs, target_, &largest_of_);
    if (both) result.back = way_back(*fit_.layout, fit_.dofs, target_, &largest_of_);
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
  void replan_joins() {
    constexpr int most = 4;
    for (int again = 0; again < most && !fit_.layout->join_plans().empty(); ++again) {
      auto planned = std::make_shared<ModelLayout>(*fit_.layout);
      planned->plan_joins(fit_.dofs);
      fit_.layout = std::move(planned);
      FitRounds rounds(fit_.layout, of_region_, target_);
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
