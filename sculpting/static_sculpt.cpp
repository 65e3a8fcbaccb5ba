#include "batten/sculpting/static_sculpt.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <deque>

#include "batten/core/errors.h"
#include "batten/fem/dissection.h"

namespace batten {
namespace {

// Loads that do not follow the surface, plus the sum of all pressures: both per unit of the load
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
    } else {
      const auto& point = std::get<PointLoad>(load.value);
      require_finite(point.force.allFinite() && point.at.allFinite());
      const auto closest = unloaded.closest_point(point.at);
      constexpr double far = 0.5;  // of the region's size: no rounding, a mistake
      if (closest.distance > far * s)
        throw InputError("load '" + load.name + "': the surface is " + number(closest.distance) +
                         " away from where it should act (the region's size is " + number(s) + ")");
      terms.fixed += assembler.point_load(closest.where, (relative ? s : 1.0) * point.force);
    }
  }
  return terms;
}

// Anderson acceleration of x ← g(x): the next guess is the combination of the last few for which
// the linearised residual g(x) - x is smallest. Depth bounded, so that it forgets old curvature.
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
      const VecX theta = dF.colPivHouseholderQr().solve(VecX(f.reshaped()));
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
  const SurfaceStiffness material = on_unit_domain(options.material, options.units, size);
  const Eigen::SelfAdjointEigenSolver<Mat2> stretch(material.alpha);
  if (!material.alpha.allFinite() || !material.beta.allFinite() ||
      stretch.eigenvalues()[0] < -1e-12 * material.alpha.norm() || material.beta.minCoeff() < 0)
    throw InputError("alpha must be positive semi-definite and beta not negative");

  // Solved with the first corner as the origin: energies, tolerances and conflicts would otherwise
  // lose the digits of a region that lies far away.
  const Vec3 origin = layout.origin();
  VecX ones = VecX::Zero(assembler.dofs().count());
  for (int v = 0; v < layout.mesh()->vertex_count(); ++v) ones[assembler.dofs().vertex(v)] = 1;
  const ConstraintSet constraints = given.moved(ones, origin);

  progress.at("solving", 0);
  const ConstrainedSolver solver(constraints, assembler.stiffness(material),
                                 dissection_order(*layout.mesh()));
  SculptResult result;
  result.dofs = solver.solve(Points::Zero(assembler.dofs().count(), 3));
  const Surface unloaded(layout.mesh(), layout.element(), result.dofs + ones * origin.transpose(),
                         layout.trim());
  const LoadTerms terms = gather(layout, assembler, unloaded, loads, options.units);

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
    while (reached < 1) {
      const double target = std::min(1.0, reached + step);
      Points x = result.dofs;
      Anderson anderson;
      bool converged = false;
      double change = 0;
      for (int i = 0; i < options.max_iterations && !converged; ++i) {
        progress.at("sculpting", reached + (target - reached) * i / options.max_iterations);
        const Points g = solver.solve(load_at(x, target));
        change = (g - x).cwiseAbs().maxCoeff() / size;
        ++result.iterations;
        converged = change <= options.tolerance;
        // A shape many sizes away has run off: its pressure feeds on its own area.
        if (!g.allFinite() ||
            g.cwiseAbs().maxCoeff() > 1e6 * (size + result.dofs.cwiseAbs().maxCoeff()))
          break;
        x = converged ? g : anderson.next(x, g);
      }
      if (converged) {
        result.dofs = x;
        result.last_change = change;
        reached = target;
        ++result.load_steps;
      } else {
        step = 0.5 * (target - reached);
        constexpr double nothing = 1e-12;  // of the load: not even the beginning converges
        if (step < std::max(options.smallest_step * reached, nothing)) {
          const double full = terms.pressure * (options.units == LoadUnits::Relative ? size : 1);
          throw NoSolutionError("the pressure " + number(full) + " is past its limit: " +
                                number(reached * full) + " (" + number(100 * reached) +
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
  progress.at("solving", 1);
  return result;
}

}  // namespace batten
