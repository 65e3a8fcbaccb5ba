// SPDX-License-Identifier: MPL-2.0
// The steps of a sequence scene: what they work on, what they result in, and their execution.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "batten/core/errors.h"
#include "batten/core/progress.h"
#include "batten/io/report/sequence_report.h"
#include "batten/io/scene/sequence_scene.h"
#include "batten/mesh/sequence/sequence_editor.h"
#include "batten/scenes/meshes/vertex_selector.h"

namespace batten {

/// A sequence with the prepared triangle mesh of its first frame.
struct PreparedSequence {
  MeshSequence sequence;
  TriangleMesh mesh;  ///< first frame
};

/// Handles and features of a scene, as nodes.
struct SequenceParts {
  std::vector<Handle> handles;
  std::vector<int> parents;  ///< parent of each handle; -1: the whole mesh
  std::vector<FormFeature> features;

  /// Index of a handle. Throws InputError for an unknown name, with the nearest one as a
  /// suggestion.
  int handle(const SequenceScene& scene, const LocatedString& name) const;
};

/// Result of a step. Its frames are computed on demand, so that those of the last step are never in
/// memory together.
struct StepResult {
  ShellMesh shells;
  std::vector<double> times;
  /// Computes frames first … last (0-based), and calls take(frame, positions) for each in order.
  std::function<void(int first, int last, const std::function<void(int, const Points&)>& take,
                     const Progress& progress)>
      frames;
  std::vector<SequenceReport::Foot> feet;  ///< planted feet; foot_skate_before is set
  std::vector<std::string> warnings;
  SequenceReport::Step report;
};

/// Reads the frames of a source.
using FrameReader = std::function<MeshSequence(const SequenceSource&)>;
/// Finds the vertices of names such as `fixed`, on the first frame.
using VertexFinder = std::function<std::vector<int>(const std::vector<LocatedString>&)>;

/// Prepares one step, so that its frames can be computed. Keeps references to `from` and `scene`.
/// Throws InputError with the location of the step, and the exceptions of the classes in
/// mesh/sequence.
StepResult apply_step(const SequenceScene& scene, const SequenceOperation& step,
                      const PreparedSequence& from, const SequenceParts& parts,
                      const VertexFinder& vertices_of, const FrameReader& read,
                      const Progress& progress);

// The frames of a sequence scene before, between and after its steps.

/// A sequence with its prepared mesh. `notes` receives the repairs that were necessary. Throws
/// InputError that begins with `where`.
PreparedSequence prepared_sequence(MeshSequence sequence, const std::string& where,
                                   std::vector<std::string>& notes);

/// The handles and features of a scene. Throws InputError, with the location, for an unknown name
/// or a handle without nodes.
SequenceParts find_sequence_parts(const SequenceScene& scene, VertexSelector& select);

/// The result of a step that changes nothing.
StepResult unchanged_result(std::shared_ptr<const PreparedSequence> sequence);

/// Like apply_step(), with the step's name and location added to exceptions.
StepResult run_step(const SequenceScene& scene, const SequenceOperation& step,
                    const PreparedSequence& from, const SequenceParts& parts,
                    VertexSelector& select, const FrameReader& read, const Progress& progress);

/// Computes all frames of a step's result. `mesh`: prepared mesh of any frame.
std::shared_ptr<const PreparedSequence> collect_frames(const StepResult& result,
                                                       const TriangleMesh& mesh,
                                                       const Progress& progress);

/// The result of `work`, with the step's name and location added to exceptions.
template <class Work>
auto with_step_context(const SequenceScene& scene, const SequenceOperation& step,
                       const Work& work) {
  const std::string where = scene.at(step.location) + "the operation '" + step.name + "': ";
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
