// SPDX-License-Identifier: MPL-2.0
#include "batten/tests/support/reference_static_solver.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>

#include "batten/constraints/constrained_solver.h"
#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/fem/surface_assembler.h"
#include "batten/fem/surface_projector.h"
#include "batten/sculpting/session/session_engine.h"
#include "batten/tests/support/reference_energy.h"

namespace batten::reference_solver {
namespace {

// Loads independent of the surface, plus the sum of all pressures: both per unit of the load
// factor, in dofs of the unit domain.
struct LoadTerms {
  Points fixed;
  double pressure = 0;
};

LoadTerms gather(const RegionLayout& layout, const SurfaceAssembler& assembler,
                 const Surface& unloaded, const std::vector<Load>& loads, LoadUnits units) {
  const double s = layout.size();
  const bool relative = units == LoadUnits::Relative;
  LoadTerms terms{Points::Zero(assembler.dofs().count(), 3), 0};
  for (const Load& load : loads) {
    const auto require_finite = [&](bool finite) {
      if (!finite) throw InputError("load '" + load.name + "' has a number that is not finite");
    };
    if (const auto* uniform = std::get_if<UniformLoad>(&load.value)) {
      require_finite(uniform->force.allFinite());
      terms.fixed += assembler.load(Vec3((relative ? s : s * s) * uniform->force));
    } else if (const auto* pressure = std::get_if<PressureLoad>(&load.value)) {
      require_finite(std::isfinite(pressure->pressure));
      terms.pressure += relative ? pressure->pressure / s : pressure->pressure;
    } else if (const auto* point_load = std::get_if<PointLoad>(&load.value)) {
      const PointLoad& point = *point_load;
      require_finite(point.force.allFinite() && point.at.allFinite());
      const auto closest = unloaded.closest_point(point.at);
      constexpr double far = 0.5;  // of the region's size: not rounding but an error
      if (closest.distance > far * s)
        throw InputError(
            "load '" + load.name + "': the surface is " + format_number(closest.distance) +
            " away from where it should act (the region's size is " + format_number(s) + ")");
      terms.fixed += assembler.point_load(closest.where, (relative ? s : 1.0) * point.force);
    }
  }
  return terms;
}

// All springs of the loads: their points on the surface, and their contributions to K and F.
class Springs {
 public:
  Springs(const RegionLayout& layout, const std::vector<Load>& loads) : layout_(layout) {
    for (const Load& load : loads) {
      const auto* springs = std::get_if<SpringLoad>(&load.value);
      if (!springs) continue;
      if (springs->points.empty())
        throw InputError("load '" + load.name + "' has no points for its springs");
      if (!(springs->stiffness >= 0) || !std::isfinite(springs->stiffness))
        throw InputError("load '" + load.name + "' has springs of stiffness " +
                         format_number(springs->stiffness) + ": it must not be below 0");
      for (const Vec3& p : springs->points)
        if (!p.allFinite())
          throw InputError("load '" + load.name + "' has a point that is not finite");
      groups_.push_back({&load.name, springs, {}});
    }
  }
  bool empty() const { return groups_.empty(); }

  /// The closest points of a shape; true if none moved by more than 1e-6 in (u, v).
  bool follow(const Surface& shape) {
    const SurfaceProjector projector(shape);
    bool still = true;
    for (Group& group : groups_) {
      const bool first = group.foot_points.empty();
      group.foot_points.resize(group.load->points.size());
      for (size_t i = 0; i < group.foot_points.size(); ++i) {
        const Vec3& p = group.load->points[i];
        const auto closest = projector.nearest(p);
        ClosestPoint foot_point{closest.where,
                                shape.mesh().shape(closest.where.triangle).point(closest.where.L),
                                closest.distance, false};
        // At the boundary, the distance vector to a point beyond it is not perpendicular to the
        // surface.
        const SurfaceJet jet = shape.jet(closest.where);
        const Vec3 across = p - jet.x;
        foot_point.used = (!shape.trim() || shape.trim()->loops().contains(foot_point.uv)) &&
                          (across.norm() <= 1e-9 * layout_.size() ||
                           std::abs(across.normalized().dot(jet.normal())) > 0.7);
        still = still && !first && (foot_point.uv - group.foot_points[i].uv).norm() < 1e-6;
        group.foot_points[i] = foot_point;
      }
    }
    return still;
  }
  /// K + Σ k N Nᵀ and Σ k N p, with points moved by -origin.
  void add_to(const SurfaceAssembler& assembler, const Vec3& origin, SparseMatrix& K,
              Points& F) const {
    std::vector<Triplet> entries;
    for (const Group& group : groups_) {
      const double k = group.load->stiffness / static_cast<double>(group.load->points.size());
      for (size_t i = 0; i < group.foot_points.size(); ++i) {
        const ClosestPoint& foot_point = group.foot_points[i];
        if (!foot_point.used) continue;
        const int t = foot_point.where.triangle;
        const Vec12 N = C1Triangle(assembler.kind(), assembler.mesh().shape(t))
                            .evaluate(foot_point.where.L)
                            .col(kW);
        const auto dof = assembler.dofs().triangle(assembler.mesh(), t);
        for (int a = 0; a < 12; ++a) {
          F.row(dof[a]) += k * N[a] * (group.load->points[i] - origin).transpose();
          for (int b = 0; b < 12; ++b)
            if (dof[a] >= dof[b]) entries.emplace_back(dof[a], dof[b], k * N[a] * N[b]);
        }
      }
    }
    SparseMatrix springs(K.rows(), K.cols());
    springs.setFromTriplets(entries.begin(), entries.end());
    K += springs;
  }
  std::vector<SculptResult::Springs> measured(const Surface& before, const Surface& after) const {
    std::vector<SculptResult::Springs> all;
    const SurfaceProjector on_before(before), on_after(after);
    for (const Group& group : groups_) {
      SculptResult::Springs s;
      s.name = *group.name;
      s.points = static_cast<int>(group.foot_points.size());
      for (size_t i = 0; i < group.foot_points.size(); ++i) {
        if (!group.foot_points[i].used) {
          ++s.left_out;
          continue;
        }
        const double was = on_before.nearest(group.load->points[i]).distance,
                     is = on_after.nearest(group.load->points[i]).distance;
        s.before_max = std::max(s.before_max, was);
        s.max = std::max(s.max, is);
        s.before_rms += was * was;
        s.rms += is * is;
      }
      const double used = std::max(1, s.points - s.left_out);
      s.before_rms = std::sqrt(s.before_rms / used);
      s.rms = std::sqrt(s.rms / used);
      all.push_back(s);
    }
    return all;
  }

 private:
  struct ClosestPoint {
    Location where;
    Vec2 uv = Vec2::Zero();
    double distance = 0;
    bool used = false;
  };
  struct Group {
    const std::string* name;
    const SpringLoad* load;
    std::vector<ClosestPoint> foot_points;
  };
  const RegionLayout& layout_;
  std::vector<Group> groups_;
};

// Anderson acceleration of x ← g(x): the next iterate is the combination of the last few that
// minimises the linearised residual g(x) - x. Bounded depth, to forget old curvature.
class Anderson {
 public:
  Points next(const Points& x, const Points& g) {
    constexpr size_t depth = 6;
    const Points f = g - x;
    if (!f_.empty() && f_.size() > depth) {
      f_.pop_front();
      g_.pop_front();
    }
    Points guess = g;
    if (!f_.empty()) {
      MatX dF(f.size(), static_cast<long>(f_.size()));
      for (size_t k = 0; k < f_.size(); ++k) dF.col(static_cast<long>(k)) = (f - f_[k]).reshaped();
      const VecX theta = least_squares(dF, VecX(f.reshaped()));
      if (theta.allFinite() && theta.cwiseAbs().maxCoeff() < 1e4)
        for (size_t k = 0; k < f_.size(); ++k) guess -= theta[static_cast<long>(k)] * (g - g_[k]);
    }
    f_.push_back(f);
    g_.push_back(g);
    return guess;
  }

 private:
  std::deque<Points> f_, g_;
};

}  // namespace

SculptResult sculpt(const RegionLayout& layout, const ConstraintSet& given,
                    const std::vector<Load>& loads, const SculptOptions& options,
                    const Progress& progress) {
  const double size = layout.size();
  const SurfaceAssembler assembler(*layout.mesh(), layout.element(), layout.trim());
  const SurfaceStiffness material = scaled_to_unit_domain(options.material, options.units, size);
  if (!material.is_valid())
    throw InputError("alpha must be positive semi-definite and beta not negative");

  // Solved with the first corner as the origin: otherwise energies, tolerances and conflicts of a
  // region far from the origin lose digits.
  const Vec3 origin = layout.origin();
  VecX ones = VecX::Zero(assembler.dofs().count());
  for (int v = 0; v < layout.mesh()->vertex_count(); ++v) ones[assembler.dofs().vertex(v)] = 1;
  const ConstraintSet constraints = given.translated(ones, origin);

  progress.update("solving", 0);
  const SparseMatrix plain = assembler.stiffness(material);
  const std::vector<int> order = nested_dissection_order(*layout.mesh());
  std::optional<ConstrainedSolver> factored(std::in_place, constraints, plain, order);
  SculptResult result;
  result.dofs = factored->solve(Points::Zero(assembler.dofs().count(), 3));
  const Surface unloaded(layout.mesh(), layout.element(), result.dofs + ones * origin.transpose(),
                         layout.trim());
  LoadTerms terms = gather(layout, assembler, unloaded, loads, options.units);
  Springs springs(layout, loads);
  if (!springs.empty()) {
    const Points without = terms.fixed;
    constexpr int max_rounds = 20;
    Surface shape = unloaded;
    for (int round = 0; round < max_rounds; ++round) {
      progress.update("springs", static_cast<double>(round) / max_rounds);
      if (springs.follow(shape)) break;
      SparseMatrix K = plain;
      terms.fixed = without;
      springs.add_to(assembler, origin, K, terms.fixed);
      factored.emplace(constraints, std::move(K), order);
      shape = Surface(layout.mesh(), layout.element(),
                      factored->solve(terms.fixed) + ones * origin.transpose(), layout.trim());
    }
  }
  const ConstrainedSolver& solver = *factored;

  const auto load_at = [&](const Points& q, double factor) -> Points {
    Points F = factor * terms.fixed;
    if (terms.pressure != 0) F += factor * terms.pressure * assembler.pressure_load(q);
    return F;
  };

  if (terms.pressure == 0) {
    if (!loads.empty()) {
      result.dofs = solver.solve(terms.fixed);
      result.load_steps = result.iterations = 1;
    }
  } else {
    double reached = 0, step = 1;
    const VecX felt = displacement_weights(*layout.mesh(), layout.trim().get());
    while (reached < 1) {
      const double target = std::min(1.0, reached + step);
      Points x = result.dofs;
      Anderson anderson;
      bool converged = false;
      double change = 0, fallen = std::numeric_limits<double>::infinity();
      int since_fallen = 0;
      for (int i = 0; i < options.max_iterations && !converged; ++i) {
        progress.update("sculpting", reached + (target - reached) * i / options.max_iterations);
        const Points g = solver.solve(load_at(x, target));
        change = 0;
        for (int c = 0; c < 3; ++c)
          change = std::max(change,
                            (g.col(c) - x.col(c)).cwiseAbs().cwiseProduct(felt).maxCoeff() / size);
        since_fallen = change < 0.5 * fallen ? 0 : since_fallen + 1;
        if (since_fallen == 0) fallen = change;
        ++result.iterations;
        // Rounding sets a floor, higher on trimmed and graded meshes: convergence ends there.
        converged = change <= options.tolerance || (since_fallen >= 4 && fallen <= 1e-9);
        // A shape several sizes away diverges: its pressure grows with its own area.
        if (!g.allFinite() ||
            g.cwiseAbs().maxCoeff() > 1e6 * (size + result.dofs.cwiseAbs().maxCoeff())) {
          converged = false;
          break;
        }
        x = converged ? g : anderson.next(x, g);
      }
      if (converged) {
        result.dofs = x;
        result.last_change = change;
        reached = target;
        ++result.load_steps;
      } else {
        step = 0.5 * (target - reached);
        constexpr double nothing = 1e-12;  // of the load: not even the first step converges
        if (step < std::max(options.smallest_step * reached, nothing)) {
          const double full = terms.pressure * (options.units == LoadUnits::Relative ? size : 1);
          throw NoSolutionError("the pressure " + format_number(full) +
                                " is past its limit: " + format_number(reached * full) + " (" +
                                format_number(100 * reached) +
                                " %) was reached, beyond that the shape does not settle within " +
                                std::to_string(options.max_iterations) +
                                " iterations (more alpha or beta, or less pressure)");
        }
      }
    }
  }

  const Points reaction = reaction_forces(solver.K(), result.dofs, load_at(result.dofs, 1)) /
                          (options.units == LoadUnits::Relative ? size : 1);
  for (const auto& named : named_reactions(constraints, reaction)) {
    Vec3 force = Vec3::Zero();
    for (int v = 0; v < layout.mesh()->vertex_count(); ++v)
      force += named.forces.row(assembler.dofs().vertex(v));
    result.reactions.push_back({named.name, force});
  }
  result.energy = energy(assembler, material, result.dofs);
  if (options.units == LoadUnits::Relative) {
    result.energy.stretching /= size * size;
    result.energy.bending /= size * size;
  }
  result.max_constraint_residual = constraints.max_residual(result.dofs) / size;
  result.dofs += ones * origin.transpose();
  if (!springs.empty())
    result.springs = springs.measured(
        unloaded, Surface(layout.mesh(), layout.element(), result.dofs, layout.trim()));
  progress.update("solving", 1);
  return result;
}

}  // namespace batten::reference_solver
