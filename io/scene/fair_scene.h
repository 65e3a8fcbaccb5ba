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

/// [[picture]] of a fairing scene: curvature combs.
struct CombPictureSpec {
  /// Combs: two panels, the curves as given and after all stages. Stages: one more panel after each
  /// stage; consecutive local stages share one.
  enum class Show { Combs, Stages };
  std::string file, title;
  Show show = Show::Combs;
  bool points = true;  ///< true: draw the input points as dots
  /// azimuth, elevation in degrees; empty: best-fit plane.
  std::optional<std::pair<double, double>> view;
  std::optional<PictureSize> size;  ///< empty: as high as the drawing needs
};

/// Contents of a fairing scene.
struct FairScene {
  std::filesystem::path file;  ///< empty for a scene created in memory
  std::string name = "curves", unit = "mm";
  std::vector<SceneLine> lines;
  std::vector<SceneFairStage> stages;
  /// Tolerance of the last step, model units: each fair curve is approximated by the fewest C1
  /// segments within this distance. 0: the fair curve is kept.
  double segments = 0;
  /// File names; the extension selects the format (write_curves()).
  std::vector<std::string> outputs;
  std::vector<CombPictureSpec> pictures;

  /// All parameters: STAGE.noise, STAGE.deviation and STAGE.wavelength, of the stages that set
  /// them.
  std::vector<Parameter> parameters() const;
  /// Sets a parameter. Throws InputError, beginning with `where`, for an unknown name (it suggests
  /// the nearest one) or a number ≤ 0.
  void set(const std::string& parameter, double value, const std::string& where);
  /// The location as "FILE:LINE:COLUMN: ", the prefix of messages.
  std::string at(const SourceLocation& location) const {
    return format_location(file.string(), location);
  }
};

/// True if a scene fairs curves without making a surface: it has [[fair]], but neither [skin] nor
/// [mesh]. Throws InputError if the file cannot be read or is not TOML.
bool is_fair_scene(const std::filesystem::path& file);

/// Reads a fairing scene. Throws InputError: "FILE:LINE:COLUMN: found …, expected …; did you mean
/// …?"
FairScene read_fair_scene(const std::filesystem::path& file);
/// Parses a fairing scene from text. `file` appears in messages, and paths are relative to its
/// folder.
FairScene parse_fair_scene(const std::string& text, const std::filesystem::path& file);

}  // namespace batten
