// Implements `batten run`, `skin`, `stress` and `fit`: makes everything that a scene requests.
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

/// Creates a scene from curve files alone, for `batten skin`. `inner`: files of curves that lie on
/// a surface without bounding it.
Scene scene_of_lines(const std::vector<std::filesystem::path>& outline,
                     const std::vector<std::filesystem::path>& inner, const std::string& unit);

/// Computes the shape, measures it and writes all files and report.json into the folder, all or
/// none. A result that violates checks is written, too; report.failed_checks lists them. Throws
/// InputError, ConflictError, NoSolutionError, CancelledError.
Report run_scene(const Scene& scene, const std::filesystem::path& folder,
                 const Progress& progress = {});

/// Options of run_stress().
struct StressTask {
  bool with_calculix = false;  ///< cross-check with CalculiX (check_with_calculix())
  ShellDeck::Element element = ShellDeck::Element::S6;  ///< element type of the CalculiX deck
  /// Linear solver backend; empty: SparseCholesky.
  BackendFactory factors = {};
  /// Relative accuracy of displacements (refine_adaptively()); 0: edge_length as given.
  double accuracy = 0;
};
/// Like run_scene(), and analyses the shape as the shell of [stress]: analyse(). Also throws
/// InputError for a scene without [stress].
Report run_stress(const Scene& scene, const std::filesystem::path& folder, const StressTask& task,
                  const Progress& progress = {});

/// Draws one picture of the scene's shape and writes no other file. Throws the exceptions of
/// run_scene(), and InputError if there is no display.
void view_scene(const Scene& scene, const PictureScene& look, const std::filesystem::path& file,
                const Progress& progress = {});

/// A summary of the most important results in about a dozen lines, followed by the files.
std::string summary(const Report& report, const std::filesystem::path& folder);
/// Summary for a network: diagnostics, repairs, surfaces and unused edges, with the TOML that
/// changes each decision.
std::string network_summary(const Report& report, const std::filesystem::path& folder);

// The scene of `batten fit`.

/// Adds feature lines of a mesh to a network scene: its creases ("crease 1", …) and boundary edges
/// ("free edge 1", …), and the faces they enclose ("patch 1", …). Throws InputError if there are none.
void add_mesh_lines(Scene& scene, const TriangleMesh& mesh);

/// Creates a network scene whose shape is fitted to a surface. Its lines come from `lines`; if that
/// is empty, they are the edges of the CAD file or the feature lines of the mesh. STEP and VTP are
/// written.
Scene scene_of_target(const std::filesystem::path& target,
                      const std::vector<std::filesystem::path>& lines, const std::string& unit);

}  // namespace batten
