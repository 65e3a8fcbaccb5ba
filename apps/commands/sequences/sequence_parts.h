// Input, output and measurements of the steps of a sequence scene.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/io/report/sequence_report.h"
#include "batten/io/scene/sequence_scene.h"
#include "batten/mesh/sequence/frame_measures.h"
#include "batten/mesh/sequence/sequence_editor.h"

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

// Measurements of the output frames.

/// Largest deviation of features and handles from a rigid-body motion by a step, over all frames.
class PartDeviation {
 public:
  explicit PartDeviation(const SequenceParts& parts)
      : features(parts.features.size(), 0), handles(parts.handles.size(), 0) {}
  /// Adds one frame: its positions before and after the step.
  void measure(const SequenceParts& parts, const Points& before, const Points& after);

  std::vector<double> features, handles;  ///< largest errors, relative to each part's size
};

/// The nodes and frames of planted feet, for FrameMeasures.
std::vector<FrameMeasures::Foot> measured_feet(const SequenceParts& parts,
                                               const std::vector<SequenceReport::Foot>& feet);

/// Stores all measurements in the report. `feet`: those that `measures` measured. `size`: of the
/// first frame.
void report_measures(const FrameMeasures& measures, const SequenceParts& parts,
                     const PartDeviation& deviation, std::vector<SequenceReport::Foot> feet,
                     double size, SequenceReport& report);

}  // namespace batten
