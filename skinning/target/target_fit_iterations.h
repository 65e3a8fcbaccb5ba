// SPDX-License-Identifier: MPL-2.0
// Matrices and fixed-point iterations of fit_model() on one mesh.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "batten/constraints/constrained_solver.h"
#include "batten/core/parallel.h"
#include "batten/fem/surface_assembler.h"
#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/target/target_surface.h"

namespace batten {

/// Runs the iterations of fit_model() on one mesh.
class TargetFitIterations {
 public:
  TargetFitIterations(std::shared_ptr<const ModelLayout> layout,
                      std::vector<const TargetSurface*> targets, const TargetSurface& whole)
      : layout_(std::move(layout)),
        whole_(whole),
        targets_(std::move(targets)),
        // Outside of a trim there is no attraction, only the bending term.
        assembler_(*layout_->mesh(), layout_->element(), layout_->trim(), 1),
        scale_(layout_->domain_scale()),
        ones_(layout_->position_dofs()),
        bending_factors_(layout_->mesh()->triangle_count(), 1.0),
        mass_(assembler_.mass(scale_)) {
    about_origin_ = ones_ * layout_->origin().transpose();
  }

  /// Sets a layout with the same mesh and other constraints; call factorize() afterwards.
  void set_layout(std::shared_ptr<const ModelLayout> layout) { layout_ = std::move(layout); }

  /// Factorizes the system for the current constraints and a value of ε.
  void factorize(double epsilon) {
    bending_ = assembler_.pattern();
    std::vector<SurfaceStiffness> materials;
    double mean = 0;
    const int count = layout_->mesh()->triangle_count();
    for (int t = 0; t < count; ++t) {
      const double h2 = 2 * layout_->mesh()->shape(t).area * scale_of(t);
      materials.push_back(SurfaceStiffness::isotropic(0, bending_factors_[t] * epsilon * h2 * h2));
      mean += epsilon * h2 * h2 / count;
    }
    assembler_.stiffness(layout_->scale_to_regions(std::move(materials)), bending_);
    const JoinPenalty joins = layout_->join_penalty();
    bending_ += mean * joins.stiffness;
    join_load_ = mean * joins.load;
    const ConstraintSet rows = layout_->line_constraints().translated(ones_, layout_->origin());
    if (solver_)
      solver_->update(rows, mass_ + bending_);
    else
      solver_.emplace(rows, mass_ + bending_, layout_->dof_order());
  }

  /// Performs one iteration from absolute dofs; returns the new ones. Regions with a
  /// parametrization are attracted to its points. Records the largest displacement of any vertex
  /// (max_displacement()).
  Points step(const Points& dofs, const std::vector<double>& sides,
              const std::vector<TargetSurface::Parametrization>& parametrizations = {}) {
    const Surface surface = layout_->surface(dofs);
    const Points pull = assembler_.load(
        [&](const Location& where, const Vec2& uv) -> Vec3 {
          const int r = layout_->region_of(where.triangle);
          const SurfaceJet jet = surface.jet(where);
          return scale_of(where.triangle) *
                 (!parametrizations.empty() && parametrizations[r]
                      ? Vec3(parametrizations[r](uv) - jet.x)
                      : pull_to_tangent_plane(jet, *targets_[r], sides[r]));
        },
        4);
    const Points own = dofs - about_origin_;
    const Points moved = solver_->solve(pull + join_load_ + mass_.selfadjointView<Eigen::Lower>() * own);
    max_displacement_ = 0;
    for (int v = 0; v < layout_->mesh()->vertex_count(); ++v)
      max_displacement_ = std::max(max_displacement_, (moved.row(3 * v) - own.row(3 * v)).norm());
    return moved + about_origin_;
  }
  /// Multiplies the bending term of inverted triangles and of the two rings around them by 100,
  /// from the next factorize() on. Returns false if no triangle is inverted.
  bool stiffen_inverted(const Points& dofs, const std::vector<double>& sides) {
    const auto& mesh = *layout_->mesh();
    const Surface surface = layout_->surface(dofs);
    std::vector<char> marks(mesh.triangle_count(), 0);
    parallel_for_each<64>(mesh.triangle_count(), [&](int t) {
      if (!layout_->trim() || layout_->trim()->side(t) != Trim::Side::Outside)
        marks[t] = is_inverted(surface, t, sides[layout_->region_of(t)]);
    });
    if (std::none_of(marks.begin(), marks.end(), [](char m) { return m; })) return false;
    constexpr int rings = 2;
    constexpr double stiffening = 100;
    for (int ring = 0; ring < rings; ++ring) {
      std::vector<char> touched(mesh.vertex_count(), 0);
      for (int t = 0; t < mesh.triangle_count(); ++t)
        for (const int v : mesh.triangles()[t]) touched[v] |= marks[t];
      for (int t = 0; t < mesh.triangle_count(); ++t)
        for (const int v : mesh.triangles()[t]) marks[t] |= touched[v];
    }
    for (int t = 0; t < mesh.triangle_count(); ++t)
      if (marks[t]) bending_factors_[t] *= stiffening;
    return true;
  }
  double max_displacement() const { return max_displacement_; }

  /// Marks triangles whose normal varies by more than about 75 degrees from its value at the
  /// centroid: they are too large for the target's curvature, and would count as inverted by any
  /// measure of their own.
  static void mark_strongly_curved(const ModelLayout& layout, const Points& dofs,
                                   std::vector<char>& marks) {
    const Surface surface = layout.surface(dofs);
    parallel_for_each<64>(isize(marks), [&](int t) {
      if (!layout.trim() || layout.trim()->side(t) != Trim::Side::Outside)
        marks[t] |= is_strongly_curved(surface, t);
    });
  }

 private:
  double scale_of(int triangle) const { return scale_.size() > 0 ? scale_[triangle] : 1; }
  /// True if the normal varies so much within a triangle that the triangle is too large.
  static bool is_strongly_curved(const Surface& surface, int t) {
    constexpr double least = 0.25;  // of the area vector at the centroid, along it
    const Vec3 middle = surface.area_vector({t, Vec3::Constant(1.0 / 3)});
    for (int corner = 0; corner < 3; ++corner)
      for (const Vec3& L :
           {Vec3(Vec3::Unit(corner)), Vec3(0.5 * (Vec3::Ones() - Vec3::Unit(corner)))})
        if (surface.area_vector({t, L}).dot(middle) < least * middle.squaredNorm()) return true;
    return false;
  }

  /// True if a triangle is inverted somewhere: relative to the region's own part of the target or,
  /// without a part, relative to its own mean normal.
  bool is_inverted(const Surface& surface, int t, double side) const {
    constexpr double least = 0.05;  // of the mean area
    constexpr int n = 4;
    const TargetSurface& part = *targets_[layout_->region_of(t)];
    std::vector<SurfaceJet> jets;
    Vec3 sum = Vec3::Zero();
    double mean = 0;
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j) {
        // Not in the corners: the normal is undefined at the apex of a cone.
        constexpr double inwards = 0.02;
        const Vec3 L = (1 - inwards) * Vec3(i, j, n - i - j) / n + Vec3::Constant(inwards / 3);
        jets.push_back(surface.jet({t, L}));
        sum += jets.back().area_vector();
        mean += jets.back().area_vector().norm();
      }
    mean /= isize(jets);
    return std::any_of(jets.begin(), jets.end(), [&](const SurfaceJet& jet) {
      const auto there = &part == &whole_ ? std::nullopt : part.nearest(jet.x, Vec3::Zero());
      const Vec3 along = there ? Vec3(side * there->normal) : Vec3(sum.normalized());
      return jet.area_vector().dot(along) < least * mean;
    });
  }

  /// The closest point whose normal is not opposite to `along`. Returns nullopt if it is more than
  /// three times farther than the closest point of all, which at the edges of thin walls is on the
  /// other side.
  static std::optional<TargetSurface::Nearest> same_side_as(const TargetSurface& target,
                                                            const Vec3& x, const Vec3& along) {
    const auto any = target.nearest(x, Vec3::Zero());
    if (!any || any->normal.dot(along) > 0) return any;
    constexpr double max_distance_ratio = 3;
    const auto there = target.nearest(x, along);
    if (there && (there->at - x).norm() > max_distance_ratio * (any->at - x).norm()) return {};
    return there;
  }

  /// The attraction g: along the surface's normal to the tangent plane of the target.
  Vec3 pull_to_tangent_plane(const SurfaceJet& jet, const TargetSurface& target,
                             double side) const {
    const Vec3 n = jet.normal();
    // A region's own part of the target has no second side.
    const auto there = &target == &whole_ ? same_side_as(target, jet.x, side * n)
                                          : target.nearest(jet.x, Vec3::Zero());
    if (!there) return Vec3::Zero();
    const Vec3 offset = there->at - jet.x;
    const double along = n.dot(offset), length = offset.norm();
    constexpr double sideways = 0.5;  // of the offset
    if (there->at_boundary && (offset - along * n).norm() > sideways * length) return Vec3::Zero();
    // If the normals differ by more than 60 degrees, the tangent plane is useless: use the offset's
    // normal component.
    constexpr double min_cosine = 0.5;
    const double cosine = n.dot(there->normal);
    if (std::abs(cosine) < min_cosine) return along * n;
    return std::clamp(offset.dot(there->normal) / cosine, -2 * length, 2 * length) * n;
  }

  std::shared_ptr<const ModelLayout> layout_;
  const TargetSurface& whole_;
  std::vector<const TargetSurface*> targets_;  // by region
  SurfaceAssembler assembler_;
  VecX scale_, ones_;
  std::vector<double> bending_factors_;  // by triangle; factors of ε
  Points about_origin_;
  Points join_load_;  // of the penalty on angles at given surfaces
  SparseMatrix mass_, bending_;
  std::optional<ConstrainedSolver> solver_;
  double max_displacement_ = 0;
};

}  // namespace batten
