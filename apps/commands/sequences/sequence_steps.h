// The steps of a sequence scene, one after the other.
#pragma once

#include <functional>
#include <vector>

#include "batten/apps/commands/sequences/step_result.h"

namespace batten {

/// What reads the frames of a source.
using FrameReader = std::function<MeshSequence(const SequenceSource&)>;
/// What finds vertices of names such as `fixed`, on the first frame.
using VertexFinder = std::function<std::vector<int>(const std::vector<LocatedString>&)>;

/// Does one step up to the point where frames can be made. Keeps references to `from` and `scene`.
/// Throws InputError with the step's place; what the classes of mesh/sequence throw.
StepResult apply_step(const SequenceScene& scene, const SequenceOperation& step,
                      const PreparedSequence& from, const SequenceParts& parts,
                      const VertexFinder& vertices_of, const FrameReader& read,
                      const Progress& progress);

}  // namespace batten
