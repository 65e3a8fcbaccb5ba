// The steps of a sequence scene, one after the other.
#pragma once

#include <functional>
#include <vector>

#include "batten/apps/commands/sequences/step_result.h"

namespace batten {

/// What reads the frames of a source.
using ReadFrames = std::function<MeshSequence(const SequenceSource&)>;
/// What finds vertices of names such as `fixed`, on the first frame.
using VerticesOf = std::function<std::vector<int>(const std::vector<PlacedWord>&)>;

/// Does one step up to the point where frames can be made. Keeps references to `from` and `scene`.
/// Throws InputError with the step's place; what the classes of mesh/sequence throw.
StepResult do_step(const SequenceScene& scene, const SequenceStep& step,
                   const PreparedSequence& from, const SequenceParts& parts,
                   const VerticesOf& vertices_of, const ReadFrames& read, const Progress& progress);

}  // namespace batten
