// What is measured on the frames of a run.
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "batten/apps/commands/sequences/step_result.h"

namespace batten {

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
