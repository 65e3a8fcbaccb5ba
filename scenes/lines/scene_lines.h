// SPDX-License-Identifier: MPL-2.0
// The lines of a scene after fairing, and those of its surface with their mirror images.
#pragma once

#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/io/lines/curve_files.h"
#include "batten/io/report/run_report.h"
#include "batten/io/scene/scene.h"
#include "batten/scenes/lines/line_files.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

// Fairing.

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

// Lines of a surface.

/// The lines of a scene's surface.
struct FairedLines {
  std::vector<CharacterLine> lines;
  std::vector<FairedLine> reports;         ///< reports on the faired lines
  std::vector<std::string> reading_notes;  ///< remarks on how files were interpreted
  std::vector<std::string> warnings;       ///< curves of files that were not read
};

/// Reads the lines of a scene's surface. Lines named by a [[fair]] are faired, with fixed ends
/// unless the stage overrides that.
///
/// Without any [[fair]], noisy lines of a network are faired in the same manner
/// (SceneNetwork::fair_noisy_lines). A line of points is noisy if fairing removes two thirds of its
/// curvature extrema, and at least four. In a hand-drawn network, whose ends do not meet within the
/// default tolerance, every line is faired. All other lines are unchanged. Throws the exceptions of
/// read_lines() and fair_lines(), and InputError for a line without length.
FairedLines faired_lines(const Scene& scene, const Progress& progress);

// Networks of which only one half is given.

/// Adds the mirror images of all lines of a half model (add_mirror_images()) in the plane through
/// the origin perpendicular to the scene's symmetry axis, SceneNetwork::symmetry. Does nothing
/// without one. Throws InputError, with the location in the scene, for a line that crosses the
/// plane.
void add_mirrored(const Scene& scene, std::vector<CharacterLine>& lines);

/// The scene's join and region specifications, of a half model with their mirror images.
std::vector<JoinSpec> mirrored_joins(const Scene& scene, const std::vector<CharacterLine>& lines);
std::vector<RegionSpec> mirrored_regions(const Scene& scene,
                                         const std::vector<CharacterLine>& lines);

}  // namespace batten
