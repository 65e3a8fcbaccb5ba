// The twin of a session that settles: loads on one region and the shape under them, by another
// solver (load steps, Anderson acceleration, quadrature).
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
/// A force at the point of the unloaded surface nearest to `at`, which must not be farther away
/// than half of the region's size.
struct PointLoad {
  Vec3 at;
  Vec3 force;
};
/// Springs from the surface to points in space, as measured ones: the energy gets
/// Σ stiffness/n |x(c_i) - p_i|², c_i the place that is nearest to point i, looked for anew until
/// it stands still. `stiffness` is that of all n together. Points beyond the surface's rim are left
/// out.
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
  /// Converged when no dof inside moves by more than this times the region's size in one iteration
  /// (slopes times the size of their triangles), or by less than 1e-9 that does not fall any more.
  double tolerance = 1e-12;
  int max_iterations = 60;           ///< for one load step
  double smallest_step = 1.0 / 256;  ///< of the load that was reached; below it NoSolutionError
};

struct SculptResult {
  Points dofs;
  SurfaceEnergy energy;  ///< of the domain scaled to size 1; over size² in relative units
  int load_steps = 0, iterations = 0;
  double last_change = 0;  ///< of the last iteration, over the region's size
  /// Force with which each named constraint holds the surface (its share of the reaction on the
  /// position dofs), in the units of the loads.
  struct Reaction {
    std::string name;
    Vec3 force;
  };
  std::vector<Reaction> reactions;
  double max_constraint_residual = 0;  ///< over all rows, over the region's size
  /// Of each spring load: how far its points are from the finished surface, model units.
  struct Springs {
    std::string name;
    int points = 0, left_out = 0;
    double before_max = 0, before_rms = 0;  ///< of the shape without loads
    double max = 0, rms = 0;
  };
  std::vector<Springs> springs;
};

/// The shape of least energy under constraints and loads. One factor (one more for each round of
/// springs, twenty at most); uniform and point loads take one solve, pressure takes load steps of
/// fixed-point iterations with Anderson acceleration, each one pair of triangular solves. Solved
/// with the first line's start as the origin, so that a region far away keeps its digits. Throws
/// InputError on bad numbers; ConflictError; NoSolutionError when the pressure is past its limit,
/// with the largest pressure that converged.
SculptResult sculpt(const RegionLayout& layout, const ConstraintSet& constraints,
                    const std::vector<Load>& loads, const SculptOptions& options,
                    const Progress& progress = {});

}  // namespace batten::reference_solver
