// SPDX-License-Identifier: MPL-2.0
// Fairing scenes: TOML files with curves, fairing stages and outputs (all keys: docs/fair.md).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/io/pictures/image.h"
#include "batten/io/scene/scene.h"

namespace batten {

/// [[picture]] of a fairing scene: a picture of curvature combs along the curves.
struct CombPictureSpec {
  /// Combs: two panels, with the input curves and the faired curves. Stages: the input curves, then
  /// one panel after each stage; consecutive local stages share one panel.
  enum class Show { Combs, Stages };
  std::string file, title;
  Show show = Show::Combs;
  bool points = true;  ///< true: draw the input points as dots
  /// Azimuth and elevation of the camera, degrees; empty: perpendicular to the best-fit plane.
  std::optional<std::pair<double, double>> view;
  /// Size of the picture; empty: the height is adapted to the curves.
  std::optional<PictureSize> size;
};

/// Contents of a fairing scene.
struct FairScene {
  std::filesystem::path file;  ///< path of the scene file; empty: the scene was created in memory
  std::string name = "curves", unit = "mm";
  std::vector<SceneLine> lines;
  std::vector<SceneFairStage> stages;
  /// Tolerance of the final approximation, model units: each faired curve is approximated by as few
  /// C1 segments as possible within this distance. 0: no approximation.
  double segments = 0;
  /// Names of output files; the extension selects the format (see write_curves()).
  std::vector<std::string> outputs;
  std::vector<CombPictureSpec> pictures;

  /// All parameters of the stages, named STAGE.noise, STAGE.deviation, STAGE.wavelength.
  std::vector<Parameter> parameters() const;
  /// Sets a parameter of a fairing stage. Throws InputError, with a message that begins with
  /// `where`, for an unknown name (the message suggests the nearest one) or a number ≤ 0.
  void set(const std::string& parameter, double value, const std::string& where);
  /// The prefix of messages about a location in the scene file: "FILE:LINE:COLUMN: ".
  std::string at(const SourceLocation& location) const {
    return format_location(file.string(), location);
  }
};

/// True if a scene file fairs curves without making a surface, that is, contains [[fair]] but
/// neither [skin] nor [mesh]. Throws InputError if the file cannot be read or is not TOML.
bool is_fair_scene(const std::filesystem::path& file);

/// Reads a fairing scene. Throws InputError ("FILE:LINE:COLUMN: found …, expected …; did you mean
/// …?") if the file is invalid.
FairScene read_fair_scene(const std::filesystem::path& file);
/// Parses a fairing scene from text. `file` appears in messages, and relative paths are resolved
/// against its folder.
FairScene parse_fair_scene(const std::string& text, const std::filesystem::path& file);

}  // namespace batten
