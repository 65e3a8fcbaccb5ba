// The lines that a scene's surface is made from.
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
  std::vector<FairedLine> reports;         ///< reports on the lines that were faired
  std::vector<std::string> reading_notes;  ///< what a person may not expect of how points were read
};

/// Reads the lines that a scene's surface is made from. Lines that a [[fair]] names are faired,
/// with ends held unless a stage says otherwise. Without any [[fair]], the lines of a network that
/// tremble are faired likewise (SceneNetwork::fair_noisy_lines): lines of points whose curvature
/// loses two thirds of its extrema so, four at least; in a drawing by hand, whose ends do not meet
/// within the usual tolerance, any. All others are as given. Throws what read_lines() and
/// fair_lines() throw, and InputError for a line without length.
FairedLines faired_lines(const Scene& scene, const Progress& progress);


// Networks of which one half is drawn.

/// Adds to the lines of half a model those of the other half: the mirror image in the plane through
/// the origin at right angles to the scene's axis of symmetry (SceneNetwork::symmetry), with the
/// name "mirrored NAME", of every line that does not lie in that plane within 1e-3 of the lines'
/// size. Nothing without an axis. Throws InputError, with the place in the scene, for a line that
/// crosses the plane.
void add_mirrored(const Scene& scene, std::vector<CharacterLine>& lines);

/// The scene's words about joins and regions, and the same about the mirror images: of every join
/// whose line has one, of every region that is not its own.
std::vector<JoinSpec> mirrored_joins(const Scene& scene, const std::vector<CharacterLine>& lines);
std::vector<RegionSpec> mirrored_regions(const Scene& scene,
                                         const std::vector<CharacterLine>& lines);

}  // namespace batten
