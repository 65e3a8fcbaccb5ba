// SPDX-License-Identifier: MPL-2.0
#include "batten/core/solvers/linear_solver_backend.h"

#include "batten/core/errors.h"

namespace batten {
namespace {

struct LibraryFunctions {
  const char* name;
  std::unique_ptr<SupernodalFactor> (*factor)();
  std::vector<int> (*order)(const SparseMatrix&, FactorReuse);
};

LibraryFunctions functions_of(CholeskyLibrary library) {
  if (library == CholeskyLibrary::Eigen)
    return {"Eigen", make_eigen_factor, eigen_elimination_order};
#if BATTEN_HAVE_CHOLMOD
  return {"CHOLMOD", make_cholmod_factor, cholmod_elimination_order};
#else
  return {"CHOLMOD", nullptr, nullptr};
#endif
}

}  // namespace

bool LinearSolverBackend::has_pattern_of(const SparseMatrix&) const { return true; }

void LinearSolverBackend::analyze(const SparseMatrix&, const std::vector<int>&) {}

std::span<const CholeskyLibrary> cholesky_libraries() {
  static constexpr CholeskyLibrary libraries[] = {
#if BATTEN_HAVE_CHOLMOD
    CholeskyLibrary::Cholmod,
#endif
    CholeskyLibrary::Eigen
  };
  return libraries;
}

const char* library_name(CholeskyLibrary library) { return functions_of(library).name; }

std::unique_ptr<SupernodalFactor> make_supernodal_factor(CholeskyLibrary library) {
  const LibraryFunctions functions = functions_of(library);
  if (!functions.factor)
    throw InputError(std::string("Batten was built without ") + functions.name +
                     ", expected another library of the Cholesky factorization");
  return functions.factor();
}

std::vector<int> elimination_order(const SparseMatrix& graph, FactorReuse factor_reuse) {
  if (graph.rows() == 0) return {};
  return functions_of(cholesky_libraries().front()).order(graph, factor_reuse);
}

}  // namespace batten
