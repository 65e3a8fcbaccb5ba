// CGAL's Surface_mesh_deformation, behind an interface that names none of its types.
//
// Without CGAL the functions are there and say so: cgal_version() is "".
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten::bench {

/// "5.5.1", or "" in a build without CGAL.
std::string cgal_version();

enum class CgalEnergy {
  Arap,           ///< ORIGINAL_ARAP: as rigid as possible, spokes only
  SpokesAndRims,  ///< SPOKES_AND_RIMS: CGAL's default
  SreArap         ///< SRE_ARAP: rotations smoothed, alpha 0.02, CGAL's default
};

/// CGAL's matrix is not symmetric: rows of vertices that are held are those of the identity. A
/// Cholesky factorization therefore needs a solver class of one's own that leaves them out.
enum class CgalSolver {
  SparseLu,    ///< Eigen's SparseLU with COLAMD: CGAL's default, what its manual shows
  Simplicial,  ///< own solver class: SimplicialLDLT with AMD on the free vertices
  Cholmod      ///< own solver class: CHOLMOD, supernodal or not as it likes; needs CHOLMOD
};
bool cgal_has(CgalSolver solver);

/// A mesh that is deformed by moving some of its vertices; CGAL has no way to keep a hole's shape.
class CgalDeform {
 public:
  /// `region`: vertices that may move, `controls` among them: vertices that are moved. All others
  /// are held. Building CGAL's mesh is not part of what is timed.
  CgalDeform(CgalEnergy energy, CgalSolver solver, const Points& points,
             const std::vector<std::array<int, 3>>& triangles, const std::vector<int>& region,
             const std::vector<int>& controls);
  ~CgalDeform();

  /// Weights, matrix, factor; from scratch each time, all rotations the identity. Throws
  /// std::runtime_error where CGAL cannot.
  void preprocess();
  /// Moves `controls` to `targets` and iterates, tolerance 0, on from where the last edit ended.
  /// All vertices.
  Points edit(const Points& targets, int iterations = 5);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten::bench
