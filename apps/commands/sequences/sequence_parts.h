// What the steps of a sequence scene work on, and what they give.
#pragma once

#include <functional>
#include <string>
#include <vector>
#include <deque>

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


// What is measured on the frames of a run.

/// How far parts are from what they were before a step, in any frame.
class PartDeviation {
 public:
  explicit PartDeviation(const SequenceParts& parts)
      : features(parts.features.size(), 0), handles(parts.handles.size(), 0) {}
  void measure(const SequenceParts& parts, const Points& before, const Points& after);

  std::vector<double> features, handles;  ///< largest errors, of each part's size
};

/// What is measured on frames that come one after the other and are not kept.
class FrameMeasures {
 public:
  FrameMeasures(const TriangleMesh& mesh, const SequenceParts& parts,
                std::vector<SequenceReport::Foot> feet)
      : mesh_(mesh), parts_(parts), feet_(std::move(feet)), centres_(feet_.size()) {}

  void add(int frame, const Points& p);
  void fill(SequenceReport& report, const PartDeviation& deviation, double size);

  double max_second_difference() const { return max_second_difference_; }
  long inverted_triangles() const { return inverted_triangles_; }

 private:
  const std::vector<int>& handle_vertices(const std::string& name) const;
  // Triangles that look against the mean of their neighbours.
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
