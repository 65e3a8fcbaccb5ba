// Contact sheets and animations of sequences.
#pragma once

#include <vector>

#include "batten/apps/commands/runs/run_support.h"
#include "batten/apps/commands/sequences/sequence_task.h"
#include "batten/apps/commands/sequences/step_result.h"

namespace batten {

/// Frames that pictures show, from 0: of the sequence before and after. A long sequence has only
/// these in memory.
struct ShownFrames {
  std::vector<int> before, after;
};
ShownFrames shown_frames(const SequenceScene& scene, int before, int first, int last);

/// Draws the pictures of a scene. `after`: positions of shown.after, in that order. Terrains of
/// footprint steps are drawn beneath.
void draw_sequence(SequenceReport& report, const SequenceScene& scene,
                   const PreparedSequence& before, const SequenceParts& parts,
                   const ShellMesh& shells, const ShownFrames& shown,
                   const std::vector<Points>& after, const SequenceTask& task,
                   const OutputFolder& out);

}  // namespace batten
