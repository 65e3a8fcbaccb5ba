// Applies fairing stages to curves.
#pragma once

#include <string>
#include <vector>

#include "batten/apps/commands/lines/line_files.h"
#include "batten/core/progress.h"
#include "batten/io/lines/curve_files.h"
#include "batten/io/report/run_report.h"

namespace batten {

/// Settings for fairing curves.
struct FairingSettings {
  std::vector<SceneFairStage> stages;
  bool fix_ends = false;  ///< default of SceneFairStage::fix_ends
  double segments = 0;    ///< FairScene::segments
  std::string file;       ///< the scene file, for messages
};

/// One line and its curve after each stage.
struct FairedResult : StagedFairingResult {
  CharacterLine::Role role = CharacterLine::Role::Outline;
  std::vector<Vec3> points;  ///< input points; for CAD curves about 200 samples or more
  std::string warning;       ///< rejection_reason as a sentence; empty: the curve can be faired

  /// The last curve under the name of the line; the points if there is no curve.
  NamedCurve named() const;
};

/// Samples the lines, determines by name to which of them the stages apply, and fairs them
/// (fair_in_stages()). Deviations of CAD curves are measured at four times as many points as there
/// are samples.
///
/// Throws InputError, with the location of a stage, if one of its names matches no line, and the
/// exceptions of fair_in_stages().
std::vector<FairedResult> fair_lines(const std::vector<SourceLine>& lines,
                                     const FairingSettings& settings, const Progress& progress);

/// Up to five names, and the number of further ones.
std::string first_few(const std::vector<std::string>& names);
/// Text that lists the points ignored as outliers; empty if there are none.
std::string describe_outliers(const FairedLine& line);

}  // namespace batten
