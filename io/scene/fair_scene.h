// A fairing scene is one small TOML file with lines, how they are faired and what is written
// (docs/fair.md has every key).
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
  /// Combs: two panels, the lines as given and at the end. Stages: one more panel after each stage;
  /// local stages that follow each other share one.
  enum class Show { Combs, Stages };
  std::string file, title;
  Show show = Show::Combs;
  bool points = true;                             ///< whether the input points are drawn as dots
  std::optional<std::pair<double, double>> view;  ///< azimuth, elevation; none: the best plane
  std::optional<PictureSize> size;                ///< none: as high as the drawing needs
};

/// A fairing scene as data.
struct FairScene {
  std::filesystem::path file;  ///< empty for a scene made by a program
  std::string name = "curves", unit = "mm";
  std::vector<SceneLine> lines;
  std::vector<FairStage> stages;
  /// Tolerance, in model units, of the last step: the fair curve is replaced by the fewest C1
  /// segments that stay so near to it. 0: it is kept.
  double segments = 0;
  std::vector<std::string> outputs;  ///< file names; the ending says the kind (write_curves())
  std::vector<CombPictureSpec> pictures;

  /// What can be set: STAGE.noise, STAGE.deviation and STAGE.wavelength, of the stages that state them.
  std::vector<Parameter> parameters() const;
  /// Sets one of these numbers. Throws InputError, beginning with `where`: an unknown name (the
  /// nearest is offered), a number not above 0.
  void set(const std::string& parameter, double value, const std::string& where);
  /// The place as "FILE:LINE:COLUMN: ", with which messages begin.
  std::string at(const SourceLocation& location) const {
    return format_location(file.string(), location);
  }
};

/// Whether a scene fairs curves and makes no surface: it has a [[fair]], but neither [skin] nor
/// [network]. Throws InputError when the file cannot be read or is not TOML.
bool is_fair_scene(const std::filesystem::path& file);

/// Reads a fairing scene. Throws InputError: "FILE:LINE:COLUMN: found …, expected …; did you mean
/// …?"
FairScene read_fair_scene(const std::filesystem::path& file);
/// Reads the same from a text. Messages name `file`; paths in the scene are relative to its folder.
FairScene parse_fair_scene(const std::string& text, const std::filesystem::path& file);

}  // namespace batten
