// Does the work of `batten run`: makes everything that a scene asks for.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/io/decks/shell_deck.h"
#include "batten/io/report/report.h"
#include "batten/io/scene/scene.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// A scene made of files of curves alone, for `batten skin`. `inner`: files of curves that lie on a
/// surface and bound none.
Scene scene_of_lines(const std::vector<std::filesystem::path>& outline,
                     const std::vector<std::filesystem::path>& inner, const std::string& unit);

/// Makes the shape, measures it and writes all files and report.json into the folder, all of them
/// or none. A result that misses a promise is written, too; report.missed says so. Throws
/// InputError, ConflictError, NoSolutionError, CancelledError.
Report run_scene(const Scene& scene, const std::filesystem::path& folder,
                 const Progress& progress = {});

/// The same, and analyses the shape as the shell of [stress]: analyse(). Throws as run_scene(), and
/// InputError for a scene without [stress].
struct StressTask {
  bool with_calculix = false;  ///< asks CalculiX, too (check_with_calculix())
  ShellDeck::Element element = ShellDeck::Element::S6;  ///< of CalculiX
  BackendFactory factors = {};                          ///< of its systems; empty: SparseCholesky
  double accuracy = 0;  ///< share of displacements; 0: edge_length as it is. accurate_scene()
};
Report run_stress(const Scene& scene, const std::filesystem::path& folder, const StressTask& task,
                  const Progress& progress = {});

/// Draws one picture of the scene's shape, and writes no other file. Throws what run_scene()
/// throws, and InputError when there is no display.
void view_scene(const Scene& scene, const PictureScene& look, const std::filesystem::path& file,
                const Progress& progress = {});

/// The most important results in about a dozen lines, with the files at the end.
std::string summary(const Report& report, const std::filesystem::path& folder);
/// The same for a network: what was found, repaired, skinned and left over, and what to write into
/// the scene to change that.
std::string network_summary(const Report& report, const std::filesystem::path& folder);


// The scene of `batten fit`.

/// Adds the lines of a mesh to a scene with a network as a person would draw them: its creases and rims, named
/// "crease 1" …, "rim 1" …, and as regions "patch 1" … what they enclose. Throws InputError where there are none.
void add_mesh_lines(Scene& scene, const TriangleMesh& mesh);

/// A network of lines whose shape is fitted to a surface: those of the files; where there are none, the edges
/// of a CAD file or the lines of a mesh. STEP and VTP are written.
Scene scene_of_target(const std::filesystem::path& target,
                      const std::vector<std::filesystem::path>& lines, const std::string& unit);

}  // namespace batten
