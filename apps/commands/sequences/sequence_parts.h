// Input, output and measurements of the steps of a sequence scene.
#pragma once

#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/io/report/sequence_report.h"
#include "batten/io/scene/sequence_scene.h"
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

/// Measurements accumulated over consecutive frames, without storing them.
class FrameMeasures {
 public:
  FrameMeasures(const TriangleMesh& mesh, const SequenceParts& parts,
                std::vector<SequenceReport::Foot> feet)
      : mesh_(mesh), parts_(parts), feet_(std::move(feet)), centres_(feet_.size()) {}

  /// Adds the next frame.
  void add(int frame, const Points& p);
  /// Stores all measurements in the report.
  void fill(SequenceReport& report, const PartDeviation& deviation, double size);

  /// Largest second difference of a node position over time, model units.
  double max_second_difference() const { return max_second_difference_; }
  /// Number of inverted triangles in all frames.
  long inverted_triangles() const { return inverted_triangles_; }

 private:
  const std::vector<int>& handle_vertices(const std::string& name) const;
  // Number of triangles whose normal opposes the mean normal of their neighbours.
  long count_folded_triangles(const Points& p) const;

  const TriangleMesh& mesh_;
  const SequenceParts& parts_;
  std::vector<SequenceReport::Foot> feet_;
  std::vector<std::vector<Vec3>> centres_;
  std::deque<Points> last_;
  double max_second_difference_ = 0;
  long inverted_triangles_ = 0;
};

}  // namespace batten
