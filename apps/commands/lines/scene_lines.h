// The lines that a scene's surface is made from.
#pragma once

#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/io/report/run_report.h"
#include "batten/io/scene/scene.h"

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

}  // namespace batten
