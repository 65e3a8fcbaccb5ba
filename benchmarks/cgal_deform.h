// SPDX-License-Identifier: MPL-2.0
// Wrapper of CGAL's Surface_mesh_deformation without CGAL types in its interface.
// In a build without CGAL the functions exist, and cgal_version() is "".
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
  Arap,           ///< ORIGINAL_ARAP: as-rigid-as-possible, spokes only
  SpokesAndRims,  ///< SPOKES_AND_RIMS: CGAL's default
  SreArap         ///< SRE_ARAP: rotations smoothed, alpha 0.02, CGAL's default
};

/// CGAL's matrix is not symmetric: rows of fixed vertices are those of the identity. A Cholesky
/// factorization therefore needs a custom solver class that omits them.
enum class CgalSolver {
  SparseLu,    ///< Eigen's SparseLU with COLAMD: CGAL's default, used in its manual
  Simplicial,  ///< custom solver class: SimplicialLDLT with AMD on the free vertices
  Cholmod      ///< custom solver class: CHOLMOD, supernodal or simplicial by its own choice
};
bool cgal_has(CgalSolver solver);

/// A mesh deformed by moving some of its vertices. CGAL has no constraint that keeps the shape of a
/// hole.
class CgalDeform {
 public:
  /// `region`: vertices that may move; `controls`, a subset: vertices that are moved. All others
  /// are fixed. The construction of CGAL's mesh is not timed.
  CgalDeform(CgalEnergy energy, CgalSolver solver, const Points& points,
             const std::vector<std::array<int, 3>>& triangles, const std::vector<int>& region,
             const std::vector<int>& controls);
  ~CgalDeform();

  /// Weights, matrix and factor from scratch, with identity rotations. Throws std::runtime_error if
  /// CGAL fails.
  void preprocess();
  /// Moves `controls` to `targets` and iterates with tolerance 0, starting from the result of the
  /// last edit. Returns all vertices.
  Points edit(const Points& targets, int iterations = 5);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten::bench
