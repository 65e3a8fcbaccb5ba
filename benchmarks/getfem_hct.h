// SPDX-License-Identifier: MPL-2.0
// Wrapper of GetFEM's HCT triangle without GetFEM types in its interface.
// In a build without GetFEM the functions exist, and getfem_version() is "".
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "batten/fem/parametric_mesh.h"

namespace batten::bench {

/// "5.4.2", or "" in a build without GetFEM.
std::string getfem_version();

/// GetFEM's way of assembly.
enum class GetfemAssemblyMode {
  Language,  ///< the weak-form language: "Hess_Test_u:Hess_Test2_u"
  Classical  ///< tensor products by name, comp(Hess(#1).Hess(#1)), as asm_…bilaplacian… does
};

/// Bending stiffness ∬ b w_ij w_ij on FEM_HCT_TRIANGLE with the composite rule: degree 2 on each
/// sub-triangle for constant b (exact, the cheapest such rule), degree 4 for varying b.
class GetfemHct {
 public:
  explicit GetfemHct(const ParametricMesh& mesh);
  ~GetfemHct();

  /// b = 1, or b(u, v) = 1 + u²/2 + v, assembled in a matrix that already has its sparsity pattern
  /// and is set to zero first.
  void stiffness(GetfemAssemblyMode assembly_mode, bool varying);
  /// qᵀKq of the last assembled matrix, with the dofs q of a cubic polynomial from an exact
  /// projection.
  double energy(const std::function<double(const Vec2&)>& cubic) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Seconds and H2 seminorm of the error for the clamped plate of plate.cpp.
struct PlateRun {
  double mesh = 0, stiffness = 0, load = 0;
  double solve = 0;  ///< with boundary conditions and factor
  double h2_error = 0;
  int unknowns = 0;
  double total() const { return mesh + stiffness + load + solve; }
};

enum class GetfemSolver {
  Gmm,      ///< gmm::MUMPS_solve on the symmetric matrix, as GetFEM's own solvers
  Positive  ///< MUMPS called directly, as positive definite, with AMD ordering
};
PlateRun getfem_plate(const ParametricMesh& mesh, GetfemAssemblyMode assembly_mode,
                      GetfemSolver solver);

}  // namespace batten::bench
