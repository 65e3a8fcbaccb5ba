// The lines of a scene's surface: read, faired, and mirrored.
#pragma once

#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/io/report/run_report.h"
#include "batten/io/scene/scene.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

/// The lines of a scene's surface.
struct FairedLines {
  std::vector<CharacterLine> lines;
  std::vector<FairedLine> reports;         ///< reports on the faired lines
  std::vector<std::string> reading_notes;  ///< remarks on how point files were interpreted
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
