// SPDX-License-Identifier: MPL-2.0
// Common base class of the iterative mesh deformers.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/regions/local_global_iteration.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

struct ArapEnergy;
class LocalGlobalSolver;

/// Base class of the deformers that compute the shape of a mesh iteratively from the
/// transformations of its handles. Each derived class minimises a different energy.
class IterativeDeformer {
 public:
  virtual ~IterativeDeformer();
  IterativeDeformer(IterativeDeformer&&) noexcept;
  IterativeDeformer& operator=(IterativeDeformer&&) noexcept;

  /// Computes the positions of all vertices. `moves`: one transformation per handle. The iteration
  /// starts from the undeformed shape with interpolated handle rotations (see the derived classes),
  /// not from the previous result, so equal moves give bit-identical results. Throws InputError if
  /// numbers are missing or not finite or a scale is not above 0, ConflictError if a vertex is
  /// constrained to two different positions, and NoSolutionError if a computed position is not
  /// finite.
  const Points& deform(std::span<const HandleTransform> moves);
  /// Computes the positions of all vertices, starting from an initial guess (n×3) of the positions
  /// of the free vertices, for example the previous result during a drag. Throws the exceptions of
  /// deform(moves), and InputError if the guess has a wrong number of points or a coordinate that
  /// is not finite.
  const Points& deform(std::span<const HandleTransform> moves, const Points& guess);

  const Points& positions() const;
  const IterationReport& report() const;

 protected:
  /// Sets up and factors the linear system. `name`: first words of error messages. Throws
  /// InputError if check() rejects the constraints (deform_problem.h), and NoSolutionError if the
  /// factorization fails.
  IterativeDeformer(const TriangleMesh& mesh, std::vector<int> fixed, std::vector<Handle> handles,
                    ArapEnergy energy, const std::string& name, int max_iterations,
                    double tolerance);
  /// Rotation of each cell (a vertex or face, depending on the energy) after the last edit.
  const std::vector<Mat3>& rotations() const;

 private:
  std::unique_ptr<LocalGlobalSolver> solver_;
  int max_iterations_;
  double tolerance_;
};

}  // namespace batten
