// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/regions/local_global_iteration.h"

#include <limits>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"

namespace batten {

void LocalGlobalIteration::resize(long unknowns, long accelerated_rows) {
  y_ = next_ = MatX::Zero(unknowns, 3);
  accelerated_ = MatX::Zero(accelerated_rows, 3);
  accelerator_.resize(accelerated_rows);
}

void LocalGlobalIteration::begin() {
  accelerator_.reset();
  report_.iterations = 0;
  report_.last_change = 0;
  report_.converged = false;
  report_.energies.clear();
}

void LocalGlobalIteration::solve_unknowns() {
  global_step();
  if (!next_.allFinite()) throw NoSolutionError(name_ + ": positions are not finite");
  report_.last_change =
      size_ > 0 && y_.rows() > 0 ? (next_ - y_).rowwise().norm().maxCoeff() / size_ : 0;
}

double LocalGlobalIteration::iterate(double energy_before) {
  solve_unknowns();
  const bool accelerated = accelerates_ && accelerator_.accelerate(y_, next_, accelerated_);
  store_rotations();
  y_.swap(accelerated ? accelerated_ : next_);
  double now = update_rotations();
  if (accelerated && is_increased(now, energy_before)) {
    restore_rotations();
    y_.swap(next_);
    accelerator_.reset();
    now = update_rotations();
  }
  return now;
}

void LocalGlobalIteration::run(int max_iterations, double tolerance) {
  while (report_.iterations < max_iterations && !report_.converged) {
    report_.energies.push_back(iterate(report_.energies.empty()
                                           ? std::numeric_limits<double>::infinity()
                                           : report_.energies.back()));
    // The initial rotations are not those of a previous iteration.
    if (++report_.iterations == 1) accelerator_.reset();
    report_.converged = report_.last_change < tolerance;
  }
}

void interpolate_rotations(const MatX& weights, std::span<const Vec3> rotation_vectors,
                           std::vector<Mat3>& rotations) {
  parallel_for_each<512>(static_cast<int>(weights.rows()), [&](int i) {
    Vec3 sum = Vec3::Zero();
    for (size_t h = 0; h < rotation_vectors.size(); ++h)
      sum += weights(i, static_cast<long>(h)) * rotation_vectors[h];
    rotations[i] = rotation_matrix(sum);
  });
}

}  // namespace batten
