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
  std::vector<FairStage> stages;
  bool fix_ends = false;  ///< default of FairStage::fix_ends
  double segments = 0;    ///< FairScene::segments
  std::string file;       ///< the scene file, for messages
};

/// One line and its curve after each stage.
struct FairedResult {
  FairedLine report;
  CharacterLine::Role role = CharacterLine::Role::Outline;
  std::vector<Vec3> points;  ///< input points; for CAD curves about 200 samples or more
  /// The input curve, then the curve after each stage (unchanged if the stage did not apply). Empty
  /// for a line without length.
  std::vector<HermiteCurve> states;
  std::vector<double> parameters;  ///< parameters of the points on the last curve
  std::string warning;             ///< why it cannot be faired; empty: it can

  bool has_curve() const { return !states.empty(); }
  /// The last curve under the name of the line; the points if there is no curve.
  NamedCurve named() const;
};

/// Fairs all lines, in parallel. The first stage of a whole line starts from its points, later
/// stages from the curve at these points. Final deviations are measured from the input; for CAD
/// curves at four times as many points as there are samples.
///
/// A line cannot be faired if it has a single point, all points coincide, or it is closed and has
/// two points. Its result then has a warning and its points, but no curve. Throws InputError, with
/// the location of a stage, if the stage's names or positions match no line; the exceptions of
/// fairing; ConflictError; CancelledError.
std::vector<FairedResult> fair_lines(const std::vector<SourceLine>& lines,
                                     const FairingSettings& settings, const Progress& progress);

/// Up to five names, and the number of further ones.
std::string first_few(const std::vector<std::string>& names);
/// Text that lists the points ignored as outliers; empty if there are none.
std::string describe_outliers(const FairedLine& line);

}  // namespace batten
