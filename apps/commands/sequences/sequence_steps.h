// The steps of a sequence scene, one after the other.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/io/report/sequence_report.h"
#include "batten/io/scene/sequence_scene.h"
#include "batten/mesh/sequence/sequence_editor.h"

namespace batten {

/// A sequence and the mathematics' view of its mesh.
struct PreparedSequence {
  MeshSequence sequence;
  TriangleMesh mesh;  ///< its first frame
};

/// Handles and features of a scene as nodes.
struct SequenceParts {
  std::vector<Handle> handles;
  std::vector<int> parents;  ///< of each handle; -1: the whole mesh
  std::vector<FormFeature> features;

  /// Number of a handle. Throws InputError that offers the nearest.
  int handle(const SequenceScene& scene, const PlacedWord& name) const;
};

/// A sequence after a step: frames are made when they are asked for, so that the last step's need
/// never be in memory together.
struct StepResult {
  ShellMesh shells;
  std::vector<double> times;
  /// Calls take(frame, positions) for first … last, from 0, in order.
  std::function<void(int first, int last, const std::function<void(int, const Points&)>& take,
                     const Progress& progress)>
      frames;
  std::vector<SequenceReport::Foot> feet;  ///< that it planted; slip_before is known
  std::vector<std::string> warnings;
  SequenceReport::Step report;
};

/// What finds vertices of names such as `fixed`, on the first frame.
/// The frames of a source. Errors name its place in the scene.
MeshSequence read_frames(const SequenceScene& scene, const SequenceSource& source,
                         const Progress& progress);

using VerticesOf = std::function<std::vector<int>(const std::vector<PlacedWord>&)>;

/// Does one step up to the point where frames can be made. Keeps references to `from` and `scene`.
/// Throws InputError with the step's place; what the classes of mesh/sequence throw.
StepResult do_step(const SequenceScene& scene, const SequenceStep& step,
                   const PreparedSequence& from, const SequenceParts& parts,
                   const VerticesOf& vertices_of, const Progress& progress);

}  // namespace batten
