// [[fair]]: how the lines of a scene are faired, stage after stage (docs/scenes.md has every key).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/fairing/curvature_fairing.h"
#include "batten/fairing/fair_curve.h"
#include "batten/io/files/toml_table.h"

namespace batten {

/// One [[fair]]. It fairs whole lines or, as a local stage (a brush or a stretch), a part of the
/// curves that the stages before made.
struct FairStage {
  struct Brush {
    Vec3 at;
    double radius;
  };
  struct CurveSegment {
    Vec3 from, to;  ///< it runs between the points of the curve that are nearest to these
  };
  std::string name;
  SourceLocation location;
  std::vector<LocatedString> lines;  ///< names of lines; '*' stands for any letters; empty: all
  FairOptions options;               ///< without corners; of a local stage, the wavelength only
  /// The integral that the curve through all points makes least, instead of springs at the points.
  std::optional<CurveFunctional> minimum;
  std::optional<bool> fix_ends;              ///< not given: the kind of scene decides
  std::optional<std::vector<Vec3>> corners;  ///< places; each marks the nearest point of all lines
  std::optional<Brush> brush;
  std::optional<CurveSegment> segment;

  bool local() const { return brush || segment; }
};

/// Reads all [[fair]] of a scene, in their order. Stages without a name are called fair-1, fair-2,
/// … by their numbers. Throws InputError.
std::vector<FairStage> read_fair_stages(const TomlTable& root);

/// Calls f(name, value), with a reference to the value, for each number of the stages that can be
/// set from outside: STAGE.noise, STAGE.deviation or STAGE.wavelength. They have to be above 0.
template <class Stages, class Function>
void for_each_fair_parameter(Stages& stages, const Function& f) {
  for (auto& stage : stages) {
    if (stage.options.smoothing == FairOptions::Smoothing::Noise)
      f(stage.name + ".noise", stage.options.noise);
    if (stage.options.smoothing == FairOptions::Smoothing::Deviation)
      f(stage.name + ".deviation", stage.options.deviation);
    if (stage.options.smoothing == FairOptions::Smoothing::Wavelength)
      f(stage.name + ".wavelength", stage.options.wavelength);
  }
}

}  // namespace batten
