// Fairing scenes: lines, how they are faired, what is written, in one small TOML file
// (docs/scenes.md has every key).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/io/pictures/image.h"
#include "batten/io/scene/fair_stages.h"
#include "batten/io/scene/scene.h"

namespace batten {

/// [[picture]]: curvature combs.
struct CombPictureRule {
  enum class Show { Combs, Stages };  ///< as given and at the end; a panel after each stage
  std::string file, title;
  Show show = Show::Combs;
  bool points = true;                             ///< the input points as dots
  std::optional<std::pair<double, double>> view;  ///< azimuth, elevation; none: the best plane
  std::optional<PictureSize> size;                ///< none: as high as the drawing needs
};

struct FairScene {
  std::filesystem::path file;  ///< empty for a scene made by a program
  std::string name = "curves", unit = "mm";
  std::vector<SceneLine> lines;
  std::vector<FairStage> stages;
  /// At the end: as few C1 segments as stay this near to the fair curve; 0: as it is.
  double segments = 0;
  std::vector<std::string> outputs;  ///< file names; the ending says the kind
  std::vector<CombPictureRule> pictures;

  /// STAGE.deviation, STAGE.wavelength.
  std::vector<Parameter> parameters() const;
  /// Throws InputError, beginning with `where`: an unknown name (the nearest is offered), a number
  /// not above 0.
  void set(const std::string& parameter, double value, const std::string& where);
  /// "FILE:LINE:COLUMN: "
  std::string at(const FilePlace& place) const { return place_prefix(file.string(), place); }
};

/// Whether a scene fairs curves and makes no surface: it has a [[fair]] and no [skin]. Throws
/// InputError when the file cannot be read or is not TOML.
bool only_fairs(const std::filesystem::path& file);

/// Throws InputError: "FILE:LINE:COLUMN: found …, expected …; did you mean …?"
FairScene read_fair_scene(const std::filesystem::path& file);
FairScene parse_fair_scene(const std::string& text, const std::filesystem::path& file);

}  // namespace batten
