// SPDX-License-Identifier: MPL-2.0
// Models that are fitted to a given surface: a CAD file, or a mesh.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/scenes/mesh.h"
#include "batten/scenes/model.h"

namespace batten {

struct Report;

/// Options of fit_surface(), with the meanings and defaults of docs/fit.md. Lengths are in model
/// units.
struct FitSettings {
  std::string name = "";    ///< name of the model; empty: that of the file, or "surface"
  std::string unit = "mm";  ///< "mm", "cm", "m", "in" or "ft"
  /// Largest accepted distance from the target; 0: 1e-4 of the size.
  double fit_tolerance = 0;
  double edge_length = 0;    ///< initial length of element edges; 0: 1/40 of the size
  double gap_tolerance = 0;  ///< gaps between curves up to this length are closed; 0: detected
  bool cage = false;         ///< true: the target is the Catmull-Clark limit surface of the mesh
  /// Curves that bound the faces. Without curves and curve files: the edges of the CAD file, or the
  /// creases and free edges of the mesh.
  std::vector<InputLine> curves = {};
  std::vector<std::filesystem::path> curve_files = {};
};

/// Input of `batten fit`.
struct FitTask {
  FitSettings settings;                          ///< `curves` and `name` are not used
  bool step_curves = false, step_ap242 = false;  ///< as Scene::step_lines and Scene::step_ap242
};
/// Runs `batten fit`: run_scene() with the scene of scene_of_target(), which is also written, as
/// NAME.toml. Throws as run_scene() does.
Report run_fit(const std::filesystem::path& target, const FitTask& task,
               const std::filesystem::path& folder, const Progress& progress = {});

/// Fits a model to the surface of a CAD file or mesh file, as `batten fit` does, to the last bit.
///
/// The surface passes through the curves and approximates the target between them. The section
/// "target" of Model::report() contains the distances in both directions, and failed_checks() a
/// distance above the tolerance. Throws InputError, ConflictError, NoSolutionError, CancelledError.
/// Algorithm: fixed-point iteration (skinning/target/fit_model.h).
Model fit_surface(const std::filesystem::path& target, const FitSettings& settings = {},
                  const Progress& progress = {});
/// Fits a model to a mesh, whose coordinates are in model units. The scene of the model contains the
/// vertices and faces of the mesh. Throws as above, and InputError for second-order faces.
Model fit_surface(const Mesh& target, const FitSettings& settings = {},
                  const Progress& progress = {});

}  // namespace batten
