// What the steps of a sequence scene work on, and what they give.
#pragma once

#include <functional>
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
  int handle(const SequenceScene& scene, const LocatedString& name) const;
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
  std::vector<SequenceReport::Foot> feet;  ///< that it planted; foot_skate_before is known
  std::vector<std::string> warnings;
  SequenceReport::Step report;
};

}  // namespace batten
