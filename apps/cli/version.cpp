// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/cli/version.h"

#include <batten_build.h>
#include <batten_commit.h>

#include <filesystem>

#include "batten/scenes/runs/plugins.h"

namespace batten {
namespace {

std::string row(const std::string& name, const std::string& value) {
  constexpr size_t column = 14;
  return "\n" + name + std::string(column - name.size(), ' ') + value;
}

/// A library and its version, or what the program does without it.
std::string library(const std::string& name, const std::string& version,
                    const std::string& without) {
  return row(name, version.empty() ? "not used: " + without : version);
}

std::string plugin(const std::string& name, const std::string& file, const std::string& without) {
  const std::filesystem::path found = find_plugin(file);
  std::error_code none;
  return row(name, found.empty() ? "not found: " + without
                                 : std::filesystem::weakly_canonical(found, none).string());
}

}  // namespace

std::string version_text() {
  return "batten " BATTEN_VERSION + row("commit", BATTEN_COMMIT ", " BATTEN_COMMIT_DATE) +
         row("compiler", BATTEN_COMPILER ", " BATTEN_BUILD_TYPE ", " BATTEN_SYSTEM) +
         row("Eigen", BATTEN_EIGEN) +
         library("CHOLMOD", BATTEN_CHOLMOD, "Eigen factorizes, which is slower") +
         library("CGAL", BATTEN_CGAL, "only the fan mesher, for star-shaped faces") +
         library("Ceres", BATTEN_CERES, "no minimum-energy and minimum-variation curves") +
         row("OpenCASCADE", BATTEN_OPENCASCADE) + row("VTK", BATTEN_VTK) +
         plugin("CAD module", "batten_cad.so", "no STEP, IGES and BREP files") +
         plugin("PETSc module", "batten_petsc.so", "no runs under mpirun") +
         row("licence", BATTEN_LICENCE);
}

}  // namespace batten
