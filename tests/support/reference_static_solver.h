// SPDX-License-Identifier: MPL-2.0
// Reference implementation of an equilibrium in a session: loads on one region and its deformed
// shape, by another solver (load steps, Anderson acceleration, quadrature).
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "batten/constraints/affine_reduction.h"
#include "batten/elements/reference_triangle.h"
#include "batten/skinning/layout/region_layout.h"

namespace batten::reference_solver {

/// f = force per area of the domain, constant.
struct UniformLoad {
  Vec3 force;
};
/// p n per area of the surface itself, n the current unit normal x_u × x_v / |x_u × x_v|: a
/// follower load, F = p ∬ N (x_u × x_v) du dv. Positive pushes along the normal.
struct PressureLoad {
  double pressure;
};
/// A force at the point of the unloaded surface closest to `at`, at most half the region's size
/// away.
struct PointLoad {
  Vec3 at;
  Vec3 force;
};
/// Springs from the surface to points in space, such as measured ones. Adds the energy Σ
/// stiffness/n |x(c_i) - p_i|²; the closest point c_i to point i is updated until it no longer
/// moves. `stiffness` is the total of all n. Points beyond the boundary of the surface are
/// excluded.
struct SpringLoad {
  std::vector<Vec3> points;
  double stiffness;
};
struct Load {
  std::string name;
  std::variant<UniformLoad, PressureLoad, PointLoad, SpringLoad> value;
};

struct SculptOptions {
  SurfaceStiffness material;  ///< alpha, beta, in the units below
  LoadUnits units = LoadUnits::Relative;
  /// Converged if no inner dof changes by more than this times the region's size in one iteration
  /// (slopes times the size of their triangles), or if the change is below 1e-9 and no longer
  /// decreases.
  double tolerance = 1e-12;
  int max_iterations = 60;           ///< per load step
  double smallest_step = 1.0 / 256;  ///< as a fraction of the load; below it NoSolutionError
};

struct SculptResult {
  Points dofs;
  SurfaceEnergy energy;  ///< of the domain scaled to size 1; over size² in relative units
  int load_steps = 0, iterations = 0;
  double last_change = 0;  ///< of the last iteration, relative to the region's size
  /// Reaction of each named constraint (its part on the position dofs), in the units of the loads.
  struct Reaction {
    std::string name;
    Vec3 force;
  };
  std::vector<Reaction> reactions;
  double max_constraint_residual = 0;  ///< over all equations, relative to the size
  /// Distance of the points of each spring load from the final surface, model units.
  struct Springs {
    std::string name;
    int points = 0, left_out = 0;
    double before_max = 0, before_rms = 0;  ///< of the shape without loads
    double max = 0, rms = 0;
  };
  std::vector<Springs> springs;
};

/// The shape of minimum energy under constraints and loads. One factor (plus one per iteration of
/// springs, at most twenty). Uniform and point loads take one solve; pressure takes load steps of
/// fixed-point iterations with Anderson acceleration, with one pair of triangular solves each. The
/// start of the first curve is the origin, to keep the digits of a region far away. Throws
/// InputError for invalid numbers; ConflictError; NoSolutionError with the largest converged
/// pressure if the pressure exceeds its limit.
SculptResult sculpt(const RegionLayout& layout, const ConstraintSet& constraints,
                    const std::vector<Load>& loads, const SculptOptions& options,
                    const Progress& progress = {});

}  // namespace batten::reference_solver
