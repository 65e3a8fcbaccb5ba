// The frames of a sequence scene before, between and after its steps.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/apps/commands/meshes/vertex_selector.h"
#include "batten/apps/commands/sequences/sequence_steps.h"

namespace batten {

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
