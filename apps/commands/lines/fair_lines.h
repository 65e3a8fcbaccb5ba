// Lines through the stages of a fairing: from what was given to what is written.
#pragma once

#include <string>
#include <vector>

#include "batten/apps/commands/lines/line_files.h"
#include "batten/core/progress.h"
#include "batten/io/lines/curve_files.h"
#include "batten/io/report/report_parts.h"

namespace batten {

struct FairingSettings {
  std::vector<FairStage> stages;
  bool hold_ends = false;  ///< where a stage does not say
  double segments = 0;     ///< FairScene::segments
  std::string file;        ///< of the scene, for messages
};

/// One line and what the stages made of it.
struct FairedResult {
  FairedLine report;
  CharacterLine::Role role = CharacterLine::Role::Outline;
  std::vector<Vec3> points;  ///< the input's; of a CAD curve about 200 or more samples
  /// As given, then after each stage (the same curve again where a stage did not act). Empty for a
  /// line without length.
  std::vector<HermiteCurve> states;
  std::vector<double> parameters;  ///< of the points, on the last state
  std::string warning;             ///< why it is passed through; "" for a line that could be faired

  bool has_curve() const { return !states.empty(); }
  NamedCurve named() const;
};

/// Fairs all lines, several at a time. Stages of whole lines start from the points (the first) or
/// from the curve at them (later ones); deviations are those from the input at the end: of CAD
/// curves at four times as many places as they are sampled at.
///
/// A line of one point, or whose points are all the same, or of two that should be closed, cannot
/// be faired: its result has a warning, no curve and its own points. Throws InputError with the
/// place of a stage whose names or places meet no line, and what fairing throws; ConflictError;
/// CancelledError.
std::vector<FairedResult> fair_lines(const std::vector<SourceLine>& lines,
                                     const FairingSettings& settings, const Progress& progress);

/// The lines that a scene's surface is made from: those that its [[fair]] are about as the stages
/// leave them (ends held unless a stage says otherwise), all others as they were given. Throws
/// InputError: also for a line without length.
struct FairedLines {
  std::vector<CharacterLine> lines;
  std::vector<FairedLine> reports;  ///< of the lines that were faired
};
FairedLines faired_lines(const Scene& scene, const Progress& progress);

}  // namespace batten
