// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/target/fit_model.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "batten/core/anderson_accelerator.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/model/model_shapes.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/skinning/target/primitive_projection.h"
#include "batten/skinning/target/target_fit_iterations.h"
#include "batten/skinning/target/target_surface.h"

namespace batten {

// Assignment of the parts of a target to regions.

/// Finds for each region the part on which its lines lie, with all their points within `near`; null
/// if there is none. Among several, parts that no other region uses come first, then the closest.
/// O(regions · parts), mostly decided by a single closest-point query.
std::vector<const TargetSurface*> target_parts_of_regions(
    const ModelLayout& layout, const std::vector<std::shared_ptr<const TargetSurface>>& parts,
    double near);

/// For each region with a part of its own: the part's points over the region's domain, with
/// matching boundaries. Empty for annular regions, and if the part's boundary is farther than
/// `near` from the region's. `dofs`: a shape that satisfies the lines.
std::vector<TargetSurface::Parametrization> parametrizations_of_regions(
    const ModelLayout& layout, const Points& dofs, const std::vector<const TargetSurface*>& parts,
    double near);

namespace {

// ε: from the initial value by tens down to one that keeps the parametrisation even; finally
// negligible.
constexpr double kInitialEpsilon = 100, kSmoothingEpsilon = 1e-3, kFinalEpsilon = 1e-5;

// Indices of the position dofs, without derivatives.
std::vector<int> indices_of_positions(const ModelLayout& layout) {
  const VecX is_position = layout.position_dofs();
  std::vector<int> indices;
  for (int d = 0; d < isize(is_position); ++d)
    if (is_position[d] != 0) indices.push_back(d);
  return indices;
}

// Accepted distance from primitives, relative to the tolerance.
constexpr double kExact = 0.05;

class ModelFitter {
 public:
  ModelFitter(std::shared_ptr<const ModelLayout> layout, const Points& start,
              const TargetSurface& target, const ModelFitOptions& options, const Progress& progress)
      : target_(target), options_(options), progress_(progress) {
    if (!(options.tolerance >= 0))
      throw InputError("target: found fit_tolerance = " + format_number(options.tolerance) +
                       ", expected 0 or more");
    fit_.layout = start_layout_ = std::move(layout);
    fit_.dofs = start_ = start;
    tolerance_ = options.tolerance > 0 ? options.tolerance : 1e-4 * fit_.layout->size();
  }

  ModelFit run() {
    fit_.before = measured(false);
    int points = 0;
    for (const Distances& region : fit_.before.regions) points += region.points;
    if (points == 0) throw InputError("no point of the target is close to the surface");
    target_of_region_ = target_parts_of_regions(*fit_.layout, options_.parts, tolerance_);
    choose_parametrizations();
    for (auto& part : target_of_region_)
      if (!part) part = &target_;
    sides_ = target_orientations(*fit_.layout, fit_.dofs, target_of_region_);
    fit_.analytic = std::all_of(target_of_region_.begin(), target_of_region_.end(),
                                [](const TargetSurface* target) { return target->is_analytic(); });
    for (const TargetSurface* target : target_of_region_)
      fit_.primitives.push_back(target->primitive() ? *target->primitive() : FittedPrimitive{});
    if (!on_primitives()) iterate_on_meshes();
    if (fit_.after.there() > fit_.before.there()) revert_to_start();
    if (fit_.after.back.points == 0)
      fit_.after.back = distances_from_target(*fit_.layout, fit_.dofs, target_);
    fit_.reached = fit_.after.largest() <= tolerance_;
    return std::move(fit_);
  }

 private:
  /// Fits a model all of whose faces have a primitive as target: interpolates the projection of a
  /// regular shape onto the primitives, on finer meshes until the interpolation error is far below
  /// the tolerance. Returns false, with the initial shape, if the result would be inverted or misses
  /// the tolerance.
  bool on_primitives() {
    if (!std::all_of(target_of_region_.begin(), target_of_region_.end(),
                     [](const TargetSurface* target) { return target->primitive() != nullptr; }))
      return false;
    fit_.after = fit_.before;
    {
      TargetFitIterations iterations(fit_.layout, target_of_region_, target_);
      const bool far = std::any_of(parametrizations_.begin(), parametrizations_.end(),
                                   [](const auto& map) { return !!map; });
      if (far) step_to_parametrizations(iterations);
      if (far || is_far_from_primitives()) approach_primitives();
      if (iterations.stiffen_inverted(fit_.dofs, sides_)) return reset();
    }
    constexpr int most = 6;
    for (int round = 0; round < most && is_far_from_primitives(); ++round) {
      const ModelFit coarse = fit_;
      if (!refine(kExact, [&] { approach_primitives(); })) break;
      if (fit_.after.there() < coarse.after.there()) continue;
      fit_ = coarse;
      break;
    }
    fit_.after.back = distances_from_target(*fit_.layout, fit_.dofs, target_);
    return violation() <= 1 || reset();
  }

  bool is_far_from_primitives() const { return fit_.after.there() > kExact * tolerance_; }

  /// Alternates between the primitives and the constraints, which move the surface along the
  /// primitives where the parameters of embedded curves do not match, until the distance stagnates.
  void approach_primitives() {
    constexpr int most = 5;
    constexpr double slow = 0.5;
    double last = std::numeric_limits<double>::infinity();
    for (int step = 0; step < most; ++step) {
      project_onto_primitives();
      fit_.after = measured(false);
      const double now = fit_.after.there();
      if (!is_far_from_primitives() || now > slow * last) break;
      last = now;
    }
  }

  /// Interpolates the projection of the shape onto the primitives, subject to the constraints.
  void project_onto_primitives() {
    fit_.dofs = primitive_dofs(*fit_.layout, fit_.dofs, target_of_region_);
    auto planned = std::make_shared<ModelLayout>(*fit_.layout);
    planned->plan_joins(fit_.dofs);
    fit_.dofs = planned->nearest(fit_.dofs);
    fit_.layout = std::move(planned);
    ++fit_.iterations;
  }

  bool reset() {
    fit_.layout = start_layout_;
    fit_.dofs = start_;
    fit_.refinements = fit_.iterations = 0;
    sides_ = target_orientations(*fit_.layout, fit_.dofs, target_of_region_);
    return false;
  }

  void iterate_on_meshes() {
    on_first_mesh();
    // Continues although the largest distance stagnates, because other distances may fall.
    constexpr int max_idle = 2;
    ModelFit best = fit_;
    double least = violation(), now = least;
    for (int idle = 0; idle < max_idle && now > 1 && fit_.refinements < options_.max_refinements;) {
      // Of the tolerance: the largest distance will be elsewhere next time.
      constexpr double margin = 0.5;
      if (!refine(margin, [&] { on_finer_mesh(); })) break;
      constexpr double max_ratio = 0.9;
      now = violation();
      idle = now < max_ratio * least ? 0 : idle + 1;
      if (now >= least) continue;
      least = now;
      best = fit_;
    }
    fit_ = std::move(best);
  }

  /// Keeps parametrizations only for regions whose lines define the surface poorly. Closest points
  /// suffice for near surfaces, and give a better distribution at sharp corners.
  void choose_parametrizations() {
    parametrizations_ =
        parametrizations_of_regions(*fit_.layout, fit_.dofs, target_of_region_, tolerance_);
    constexpr double far = 0.1;  // of the region's size
    for (int r = 0; r < isize(parametrizations_); ++r) {
      const RegionLayout& region = fit_.layout->region(r);
      const Distances& before = fit_.before.regions[r];
      if (!region.convex() && before.largest < far * region.size() &&
          before.excluded <= before.points)
        parametrizations_[r] = {};
    }
  }

  /// Computes the first shape: the smoothest one that is clearly within the tolerance, or the
  /// nearest one.
  void on_first_mesh() {
    TargetFitIterations iterations(fit_.layout, target_of_region_, target_);
    step_to_parametrizations(iterations);
    constexpr std::pair<double, int> fair[] = {
        {1, 4}, {0.03, 4}, {kSmoothingEpsilon, 8}};  // ε, iterations
    for (const auto& [epsilon, most] : fair) {
      iterate(iterations, epsilon, most);
      if (clearly_near(iterations)) return finish(iterations);
    }
    iterate_with_least_bending(iterations);
    finish(iterations);
  }

  /// Moves the faces with parametrizations close to them.
  void step_to_parametrizations(TargetFitIterations& iterations) {
    const bool all = std::all_of(parametrizations_.begin(), parametrizations_.end(),
                                 [](const auto& map) { return !!map; });
    for (double epsilon = all ? 1 : kInitialEpsilon; epsilon > 0.5; epsilon /= 10) {
      iterations.factorize(epsilon);
      fit_.dofs = iterations.step(fit_.dofs, sides_, parametrizations_);
      ++fit_.iterations;
    }
    const auto sides = target_orientations(*fit_.layout, fit_.dofs, target_of_region_);
    for (size_t r = 0; r < parametrizations_.size(); ++r)
      if (parametrizations_[r]) sides_[r] = sides[r];
  }

  bool clearly_near(TargetFitIterations& iterations) {
    constexpr double clearly = 0.5;  // of the tolerance
    return measured(false).there() <= clearly * tolerance_ &&
           !iterations.stiffen_inverted(fit_.dofs, sides_);
  }

  void on_finer_mesh() {
    TargetFitIterations iterations(fit_.layout, target_of_region_, target_);
    iterate_with_least_bending(iterations);
    finish(iterations);
  }

  /// Iterates with almost no bending, except for triangles that would be inverted.
  void iterate_with_least_bending(TargetFitIterations& iterations) {
    const Points even = fit_.dofs;
    iterate(iterations, kFinalEpsilon, options_.max_rounds);
    constexpr int max_stiffenings = 2;
    for (int hold = 0; hold < max_stiffenings && iterations.stiffen_inverted(fit_.dofs, sides_);
         ++hold) {
      fit_.dofs = even;
      iterate(iterations, kFinalEpsilon, options_.max_rounds);
    }
  }

  void finish(TargetFitIterations& iterations) {
    replan_joins(iterations);
    fit_.after = measured(true);
  }

  /// Measures distances, from model to target only or in both directions. The first is faster far
  /// away from the target. Records the largest distance of each triangle.
  TargetDistances measured(bool both) {
    progress_.update("measuring the fit", 0);
    TargetDistances result = target_distances(*fit_.layout, fit_.dofs, target_, &largest_of_);
    // Far away, one direction is enough.
    constexpr double near = 4;  // multiple of the tolerance
    if (both && result.there() <= near * tolerance_)
      result.back = distances_from_target(*fit_.layout, fit_.dofs, target_, &largest_of_);
    return result;
  }

  void iterate(TargetFitIterations& iterations, double epsilon, int max_rounds) {
    iterations.factorize(epsilon_ = epsilon);
    AndersonAccelerator accelerator(1e-5);
    accelerator.resize(fit_.dofs.rows(), indices_of_positions(*fit_.layout));
    for (int step = 0; step < max_rounds; ++step) {
      progress_.update("fitting to the target", double(step) / max_rounds);
      const Points x = iterations.step(fit_.dofs, sides_);
      if (!accelerator.accelerate(fit_.dofs, x, fit_.dofs)) fit_.dofs = x;
      ++fit_.iterations;
      if (iterations.max_displacement() < 0.1 * tolerance_) break;
    }
  }

  /// Smooth joins keep the tangent planes of the shape for which they were planned, so they are
  /// planned again from the fitted shape.
  void replan_joins(TargetFitIterations& iterations) {
    constexpr int most = 4;
    for (int again = 0; again < most && !fit_.layout->join_plans().empty(); ++again) {
      auto planned = std::make_shared<ModelLayout>(*fit_.layout);
      planned->plan_joins(fit_.dofs);
      fit_.layout = std::move(planned);
      iterations.set_layout(fit_.layout);
      iterations.factorize(epsilon_);
      for (int step = 0; step < 3; ++step, ++fit_.iterations)
        fit_.dofs = iterations.step(fit_.dofs, sides_);
      if (fit_.layout->gluing_change(fit_.dofs) < 1e-3) break;
    }
  }

  /// Largest violation relative to its tolerance: of the distance, and of the gap at embedded
  /// lines.
  double violation() const {
    double gap = 0;
    for (int r = 0; r < fit_.layout->region_count(); ++r) {
      if (fit_.layout->region(r).embedded().empty()) continue;
      gap = std::max(gap, line_gap(fit_.layout->skinned(r, fit_.dofs)));
    }
    return std::max(fit_.after.largest() / tolerance_, gap / fit_.layout->tolerance());
  }

  /// Restores the start if the result is worse.
  void revert_to_start() {
    fit_.layout = start_layout_;
    fit_.dofs = start_;
    fit_.refinements = 0;
    fit_.after = measured(true);
  }

  /// Bisects triangles whose distance exceeds `margin` times the tolerance, and fits again. Returns
  /// false if there is nothing to gain.
  bool refine(double margin, const std::function<void()>& fit_again) {
    const ModelLayout& layout = *fit_.layout;
    std::vector<char> marks(layout.mesh()->triangle_count(), 0);
    int count = 0;
    const std::vector<double> line_distance = line_distances();
    for (int r = 0; r < layout.region_count(); ++r)
      mark_gaps(layout.skinned(r, fit_.dofs), 0.5 * layout.tolerance(),
                marks.data() + layout.first_triangle(r));
    TargetFitIterations::mark_strongly_curved(layout, fit_.dofs, marks);
    for (int t = 0; t < isize(marks); ++t) {
      const double floor = std::max(margin * tolerance_, 1.2 * line_distance[layout.region_of(t)]);
      marks[t] |= largest_of_[t] > floor;
      count += marks[t];
    }
    if (count == 0 || layout.mesh()->triangle_count() + count > options_.max_triangles)
      return false;
    auto finer = std::make_shared<ModelLayout>(layout);
    if (!finer->refine(marks)) return false;
    fit_.dofs = interpolate_onto(layout, fit_.dofs, *finer);
    finer->plan_joins(fit_.dofs);
    fit_.layout = std::move(finer);
    ++fit_.refinements;
    fit_again();
    return true;
  }

  /// Largest distance of each region's lines from the target.
  std::vector<double> line_distances() const {
    std::vector<double> line_distance(fit_.layout->region_count(), 0.0);
    const auto& lines = fit_.layout->lines();
    for (size_t l = 0; l < lines.size(); ++l)
      for (const LineSide& side : lines[l].sides)
        line_distance[side.region] =
            std::max(line_distance[side.region], fit_.after.lines[l].largest);
    return line_distance;
  }

  const TargetSurface& target_;
  std::vector<const TargetSurface*> target_of_region_;
  std::vector<TargetSurface::Parametrization> parametrizations_;
  const ModelFitOptions& options_;
  const Progress& progress_;
  double tolerance_ = 0;
  double epsilon_ = kInitialEpsilon;  // current value
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
  return ModelFitter(std::move(layout), start, target, options, progress).run();
}

namespace {

std::vector<std::vector<Vec3>> points_on_lines(const ModelLayout& layout) {
  constexpr int samples = 4;  // per segment
  std::vector<std::vector<Vec3>> points(layout.region_count());
  for (const ModelLine& line : layout.lines()) {
    const HermiteCurve& curve = layout.curve(line.sides.front());
    const auto& breaks = curve.parameters();
    for (size_t s = 0; s + 1 < breaks.size(); ++s)
      for (int i = 0; i <= samples; ++i) {
        const Vec3 x = curve.evaluate(breaks[s] + (breaks[s + 1] - breaks[s]) * i / samples);
        for (const LineSide& side : line.sides) points[side.region].push_back(x);
      }
  }
  return points;
}

/// Largest distance of points from a part; infinite as soon as one is farther away than `near`.
double distance(const std::vector<Vec3>& points, const TargetSurface& part, double near) {
  double largest = 0;
  // From both ends, because lines of neighbours often start at a common point.
  for (size_t i = 0; i < points.size(); ++i) {
    const Vec3& p = points[i % 2 == 0 ? i / 2 : points.size() - 1 - i / 2];
    const auto there = part.nearest(p, Vec3::Zero());
    if (!there || !((there->at - p).norm() <= near)) return std::numeric_limits<double>::infinity();
    largest = std::max(largest, (there->at - p).norm());
  }
  return largest;
}

}  // namespace

std::vector<const TargetSurface*> target_parts_of_regions(
    const ModelLayout& layout, const std::vector<std::shared_ptr<const TargetSurface>>& parts,
    double near) {
  const auto points = points_on_lines(layout);
  struct Candidate {
    int part;
    double distance;
  };
  std::vector<std::vector<Candidate>> candidates(points.size());
  parallel_for_each<1>(isize(points), [&](int r) {
    for (int p = 0; p < isize(parts) && !points[r].empty(); ++p) {
      const double far = distance(points[r], *parts[p], near);
      if (far <= near) candidates[r].push_back({p, far});
    }
  });
  std::vector<int> order(points.size());
  for (int r = 0; r < isize(order); ++r) order[r] = r;
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return candidates[a].size() < candidates[b].size(); });
  std::vector<const TargetSurface*> result(points.size(), nullptr);
  std::vector<char> taken(parts.size(), 0);
  for (const int r : order) {
    const auto best = std::min_element(
        candidates[r].begin(), candidates[r].end(), [&](const Candidate& a, const Candidate& b) {
          return std::pair(taken[a.part], a.distance) < std::pair(taken[b.part], b.distance);
        });
    if (best == candidates[r].end()) continue;
    taken[best->part] = 1;
    result[r] = parts[best->part].get();
  }
  return result;
}

namespace {

/// The boundary of a region in space and in its domain, as short chords.
class BoundaryParametrization {
 public:
  explicit BoundaryParametrization(const SkinnedRegion& region) {
    constexpr int samples = 8;  // per segment
    for (const auto& loop : region.boundary)
      for (const BoundarySegment& piece : loop) {
        const HermiteCurve pcurve = boundary_pcurve(region, piece),
                           curve = boundary_curve(region, piece);
        const auto& breaks = curve.parameters();
        for (size_t s = 0; s + 1 < breaks.size(); ++s)
          for (int i = 0; i < samples; ++i)
            add(pcurve, curve, breaks[s] + (breaks[s + 1] - breaks[s]) * i / samples,
                breaks[s] + (breaks[s + 1] - breaks[s]) * (i + 1) / samples);
      }
  }

  struct Found {
    Vec2 uv;
    double distance;
  };
  Found nearest(const Vec3& p) const {
    Found best{Vec2::Zero(), std::numeric_limits<double>::infinity()};
    for (const Chord& chord : chords_) {
      const Vec3 offset = chord.to - chord.from;
      const double along = std::clamp(
          (p - chord.from).dot(offset) / std::max(offset.squaredNorm(), 1e-300), 0.0, 1.0);
      const double distance = (chord.from + along * offset - p).norm();
      if (distance >= best.distance) continue;
      best = {chord.from_uv + along * (chord.to_uv - chord.from_uv), distance};
    }
    return best;
  }

 private:
  struct Chord {
    Vec3 from, to;
    Vec2 from_uv, to_uv;
  };
  void add(const HermiteCurve& pcurve, const HermiteCurve& curve, double t, double next) {
    chords_.push_back({curve.evaluate(t), curve.evaluate(next), pcurve.evaluate(t).head<2>(),
                       pcurve.evaluate(next).head<2>()});
  }
  std::vector<Chord> chords_;
};

}  // namespace

std::vector<TargetSurface::Parametrization> parametrizations_of_regions(
    const ModelLayout& layout, const Points& dofs, const std::vector<const TargetSurface*>& parts,
    double near) {
  std::vector<TargetSurface::Parametrization> parametrizations(parts.size());
  parallel_for_each<1>(isize(parts), [&](int r) {
    if (!parts[r] || layout.region(r).mesh()->period() > 0) return;
    const BoundaryParametrization boundary(layout.skinned(r, dofs));
    double farthest = 0;
    auto map = parts[r]->parametrize([&](const Vec3& x) {
      const auto found = boundary.nearest(x);
      farthest = std::max(farthest, found.distance);
      return found.uv;
    });
    if (farthest <= near) parametrizations[r] = std::move(map);
  });
  return parametrizations;
}

}  // namespace batten
