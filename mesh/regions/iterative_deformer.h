// Common interface of the iterative deformers.
#pragma once

#include <span>
#include <vector>

#include "batten/mesh/deform/deform_problem.h"

namespace batten {

/// Convergence of an iterative deformer in the last edit.
struct IterationReport {
  int iterations = 0;
  /// Largest displacement of a vertex in the last iteration, relative to the mesh size.
  double last_change = 0;
  bool converged = false;  ///< last_change fell below the tolerance within max_iterations
  /// Energy after each iteration, in model units. It never increases except by rounding (1e-12 of
  /// the first value).
  std::vector<double> energies;
};

/// Computes the shape of a mesh iteratively for given transformations of its handles.
class IterativeDeformer {
 public:
  virtual ~IterativeDeformer() = default;

  /// Positions of all vertices after the moves; one move per handle. The iteration starts from the
  /// rest shape with interpolated handle rotations (see each class), not from the last result:
  /// equal moves give bit-identical results. Throws InputError (missing or non-finite numbers, a
  /// scale not above 0), ConflictError (a vertex constrained to two different positions) or
  /// NoSolutionError (positions that are not finite).
  virtual const Points& deform(std::span<const HandleTransform> moves) = 0;
  /// The same, starting from an initial guess (n×3) for the free vertices: another estimate, or the
  /// previous result during a drag. Throws InputError if the number of points is wrong or one is
  /// not finite.
  virtual const Points& deform(std::span<const HandleTransform> moves, const Points& guess) = 0;

  virtual const Points& positions() const = 0;
  virtual const IterationReport& report() const = 0;
};

}  // namespace batten
