// SPDX-License-Identifier: MPL-2.0
// Local/global iteration, shared by the deformers of mesh/regions and the frame solvers of
// mesh/sequence.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "batten/core/anderson_accelerator.h"
#include "batten/core/eigen.h"

namespace batten {

/// Convergence data of a local/global iteration.
struct IterationReport {
  int iterations = 0;
  /// Largest displacement of an unknown in the last iteration, relative to the mesh size.
  double last_change = 0;
  bool converged = false;  ///< true if `last_change` is below the tolerance
  /// Energy after each iteration, in model units. It increases at most by rounding errors (1e-12 of
  /// the first value).
  std::vector<double> energies;
};

/// Minimises an energy of positions and rotations by alternating minimisation. The global step
/// computes the best positions for given rotations, by one linear solve. The local step fits the
/// rotations to given positions. Both steps minimise the same energy exactly, so the energy cannot
/// increase.
///
/// Iterates are combined by Anderson acceleration (core/anderson_accelerator.h) if the combination
/// lowers the energy; otherwise the plain step is taken. Derived classes implement the two steps.
/// Cost per iteration: one global step, one or two local steps and O(unknowns), without allocation.
/// References: [SorkineAlexa2007], [Anderson1965].
class LocalGlobalIteration {
 public:
  virtual ~LocalGlobalIteration() = default;

  const IterationReport& report() const { return report_; }

 protected:
  /// `size`: mesh size (diagonal of the bounding box), the reference length of
  /// IterationReport::last_change. `name`: first words of error messages.
  LocalGlobalIteration(double size, std::string name) : size_(size), name_(std::move(name)) {}

  /// Global step: stores the unknowns that minimise the energy at fixed rotations in next_.
  virtual void global_step() = 0;
  /// Local step: computes positions from y_ and fits rotations to them. Returns the energy.
  virtual double update_rotations() = 0;
  /// Saves a copy of the current rotations; restore_rotations() restores them.
  virtual void store_rotations() = 0;
  virtual void restore_rotations() = 0;
  /// Performs one iteration, which updates the unknowns y_ and the rotations. Returns the energy
  /// after the iteration, which is at most `energy_before`, up to rounding errors.
  virtual double iterate(double energy_before);
  /// True if an energy increased by more than rounding errors: close to the minimum, where the energy
  /// is stationary, they would reject every accelerated iterate.
  static bool is_increased(double energy, double before) {
    constexpr double rounding = 1e-12;
    return !(energy <= (1 + rounding) * before);
  }

  /// Allocates the unknowns y_ and next_ (`unknowns` × 3), and the Anderson accelerator for
  /// iterates with `accelerated_rows` rows.
  void resize(long unknowns, long accelerated_rows);
  /// Starts a new edit: clears the report and the stored iterates.
  void begin();
  /// Calls global_step(), checks the result and compares it with the previous unknowns y_. Throws
  /// NoSolutionError if an unknown is not finite.
  void solve_unknowns();
  /// Iterates until IterationReport::last_change is below `tolerance`, or until `max_iterations`
  /// iterations have been performed since begin().
  void run(int max_iterations, double tolerance);

  double size_;
  std::string name_;
  MatX y_, next_;  // unknowns, and the result of the global step
  AndersonAccelerator accelerator_{0.1};
  MatX accelerated_;
  bool accelerates_ = true;
  IterationReport report_;
};

/// Computes rotations by interpolation of the rotation vectors of handles: rotation i has the
/// rotation vector Σ_h weights(i, h) rotation_vectors[h], summed over the handles h. The rotation
/// vectors may be longer than 2π. `weights`: rotations × handles. `rotations`: output, one per row
/// of `weights`. Parallel, without allocation.
void interpolate_rotations(const MatX& weights, std::span<const Vec3> rotation_vectors,
                           std::vector<Mat3>& rotations);

}  // namespace batten
