// [[fair]]: how the lines of a scene are faired, stage after stage (docs/scenes.md has every key).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/fairing/curvature_fairing.h"
#include "batten/fairing/fair_curve.h"
#include "batten/io/files/toml_table.h"

namespace batten {

/// One [[fair]]: of whole lines, or local (a brush, a stretch) on what the stages before left.
struct FairStage {
  struct Brush {
    Vec3 at;
    double radius;
  };
  struct Stretch {
    Vec3 from, to;  ///< the nearest points of the curve
  };
  std::string name;
  FilePlace place;
  std::vector<PlacedWord> lines;  ///< names; '*' stands for any letters; empty: all
  FairOptions options;            ///< its corners are not set; of a local stage,
                                  ///< the wavelength only
  /// Instead of springs: the curve of least curvature or least change of it through all points.
  std::optional<CurveFunctional> minimum;
  std::optional<bool> hold_ends;             ///< not given: by the kind of scene
  std::optional<std::vector<Vec3>> corners;  ///< each: the nearest point of the nearest line
  std::optional<Brush> brush;
  std::optional<Stretch> stretch;

  bool local() const { return brush || stretch; }
};

/// All [[fair]] of a scene in their order; without a name they are fair-1, fair-2, … Throws
/// InputError.
std::vector<FairStage> read_fair_stages(const TomlTable& root);

/// The numbers of the stages that can be set from outside, all above 0: calls f(name, value) for
/// STAGE.deviation or STAGE.wavelength with a reference to the value.
template <class Stages, class Function>
void for_each_fair_parameter(Stages& stages, const Function& f) {
  for (auto& stage : stages) {
    if (stage.options.balance == FairOptions::Balance::Deviation)
      f(stage.name + ".deviation", stage.options.deviation);
    if (stage.options.balance == FairOptions::Balance::Wavelength)
      f(stage.name + ".wavelength", stage.options.wavelength);
  }
}

}  // namespace batten
