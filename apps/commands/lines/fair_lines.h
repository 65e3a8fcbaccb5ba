// Takes lines through the stages of a fairing.
#pragma once

#include <string>
#include <vector>

#include "batten/apps/commands/lines/line_files.h"
#include "batten/core/progress.h"
#include "batten/io/lines/curve_files.h"
#include "batten/io/report/run_report.h"

namespace batten {

/// How lines are faired.
struct FairingSettings {
  std::vector<FairStage> stages;
  bool fix_ends = false;  ///< FairStage::fix_ends of stages that do not give it
  double segments = 0;    ///< FairScene::segments
  std::string file;       ///< the scene's file, for messages
};

/// One line and what the stages made of it.
struct FairedResult {
  FairedLine report;
  CharacterLine::Role role = CharacterLine::Role::Outline;
  std::vector<Vec3> points;  ///< points of the input; of a CAD curve about 200 samples or more
  /// The curve as given, then after each stage (the same curve again where a stage did not act).
  /// Empty for a line without length.
  std::vector<HermiteCurve> states;
  std::vector<double> parameters;  ///< parameters of the points on the last state
  std::string warning;             ///< why it cannot be faired; "" for a line that can

  bool has_curve() const { return !states.empty(); }
  NamedCurve named() const;
};

/// Fairs all lines, several at a time. The first stage of a whole line starts from its points,
/// later ones from the curve at the points. Deviations are measured from the input at the end; of
/// CAD curves at four times as many places as there are samples.
///
/// A line cannot be faired when it has one point, when its points are all the same, or when it has
/// two and should be closed: its result has a warning, its own points and no curve. Throws
/// InputError, with the place of a stage, when the stage's names or places meet no line, and what
/// fairing throws; ConflictError; CancelledError.
std::vector<FairedResult> fair_lines(const std::vector<SourceLine>& lines,
                                     const FairingSettings& settings, const Progress& progress);

/// Five of the names, and how many more there are.
std::string first_few(const std::vector<std::string>& names);
/// Says which points were passed over as outliers; "" for none.
std::string describe_outliers(const FairedLine& line);

}  // namespace batten
