// GetFEM's HCT triangle, behind an interface that names none of its types.
//
// Without GetFEM the functions are there and say so: getfem_version() is "".
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "batten/fem/parametric_mesh.h"

namespace batten::bench {

/// "5.4.2", or "" in a build without GetFEM.
std::string getfem_version();

/// How GetFEM is asked to assemble.
enum class GetfemAssemblyMode {
  Language,  ///< the weak-form language: "Hess_Test_u:Hess_Test2_u"
  Classical  ///< tensor products by name, comp(Hess(#1).Hess(#1)): what asm_…bilaplacian… calls
};

/// Bending stiffness ∬ b w_ij w_ij on FEM_HCT_TRIANGLE with the composite rule: degree 2 on each
/// sub-triangle for constant b (exact, the cheapest such rule), degree 4 for varying b.
class GetfemHct {
 public:
  explicit GetfemHct(const ParametricMesh& mesh);
  ~GetfemHct();

  /// b = 1, or b(u, v) = 1 + u²/2 + v, added up in a matrix that has its pattern already and is set
  /// to zero first.
  void stiffness(GetfemAssemblyMode assembly_mode, bool varying);
  /// qᵀKq of the matrix assembled last, where q are the dofs of a cubic polynomial, found by exact
  /// projection.
  double energy(const std::function<double(const Vec2&)>& cubic) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Seconds and H2 seminorm of the error of the clamped plate of plate.cpp.
struct PlateRun {
  double mesh = 0, stiffness = 0, load = 0, solve = 0;  ///< solve: conditions and factor included
  double h2_error = 0;
  int unknowns = 0;
  double total() const { return mesh + stiffness + load + solve; }
};

enum class GetfemSolver {
  Gmm,      ///< gmm::MUMPS_solve on the symmetric matrix: what GetFEM's own solvers call
  Positive  ///< MUMPS itself, told that the matrix is positive definite, with AMD ordering
};
PlateRun getfem_plate(const ParametricMesh& mesh, GetfemAssemblyMode assembly_mode,
                      GetfemSolver solver);

}  // namespace batten::bench
