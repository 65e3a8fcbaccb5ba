// The steps of a sequence scene, one after the other.
#pragma once

#include <functional>
#include <vector>
#include <memory>
#include <string>

#include "batten/apps/commands/sequences/sequence_parts.h"
#include "batten/apps/commands/meshes/vertex_selector.h"

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


// The frames of a sequence scene before, between and after its steps.

/// A sequence with the mathematics' view of its mesh; `notes` gets what was repaired for it. Throws
/// InputError that begins with `where`.
PreparedSequence prepared_sequence(MeshSequence sequence, const std::string& where,
                                   std::vector<std::string>& notes);

/// The handles and features of a scene. Throws InputError with the place: a name that is not there, a
/// handle without nodes.
SequenceParts find_sequence_parts(const SequenceScene& scene, VertexSelector& select);

/// A step's result that is the sequence itself.
StepResult unchanged_result(std::shared_ptr<const PreparedSequence> sequence);

/// apply_step(), whose errors name the step and its place.
StepResult run_step(const SequenceScene& scene, const SequenceOperation& step,
                    const PreparedSequence& from, const SequenceParts& parts,
                    VertexSelector& select, const FrameReader& read, const Progress& progress);

/// All frames of a step's result. `mesh`: of any of the frames.
std::shared_ptr<const PreparedSequence> collect_frames(const StepResult& result,
                                                       const TriangleMesh& mesh,
                                                       const Progress& progress);

/// What `work` gives. Its errors name the step and its place.
template <class Work>
auto with_step_context(const SequenceScene& scene, const SequenceOperation& step,
                       const Work& work) {
  const std::string where = scene.at(step.location) + "the step '" + step.name + "': ";
  try {
    return work();
  } catch (const ConflictError& e) {
    throw ConflictError(e.conflicts(), where);
  } catch (const InputError& e) {
    throw InputError(std::string(e.what()).starts_with(scene.file.string()) ? e.what()
                                                                            : where + e.what());
  } catch (const NoSolutionError& e) {
    throw NoSolutionError(where + e.what());
  }
}

}  // namespace batten
