// What the deformers that work in rounds have in common.
#pragma once

#include <span>
#include <vector>

#include "batten/mesh/deform/deform_problem.h"

namespace batten {

struct IterationReport {
  int iterations = 0;
  double last_change = 0;  ///< largest move of a vertex in the last round, over the mesh's size
  bool converged = false;  ///< last_change came below the tolerance within the rounds allowed
  /// The energy after each round, model units: it never rises but by rounding (1e-12 of the first).
  std::vector<double> energies;
};

/// A shape of a mesh for given moves of its handles, found in rounds.
class IterativeDeformer {
 public:
  virtual ~IterativeDeformer() = default;

  /// All vertices after the moves, one for each handle. Starts from the rest shape turned along
  /// with the handles (each class says how), not from the last answer: the same moves give the same
  /// bits. Throws InputError (numbers missing, not finite, a scale not above 0), ConflictError (a
  /// vertex held twice in two places), NoSolutionError (positions that are not finite).
  virtual const Points& deform(std::span<const HandleTransform> moves) = 0;
  /// The same from a first guess (n×3) of the free vertices: another estimate, or the last answer
  /// of a drag. Throws InputError on another number of points or one that is not finite.
  virtual const Points& deform(std::span<const HandleTransform> moves, const Points& guess) = 0;

  virtual const Points& positions() const = 0;
  virtual const IterationReport& report() const = 0;
};

}  // namespace batten
