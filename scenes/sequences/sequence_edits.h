// SPDX-License-Identifier: MPL-2.0
// The operations of a sequence scene, applied to frames in memory, and measures of the result.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "batten/io/meshes/mesh_file.h"
#include "batten/scenes/sequences/sequence_steps.h"

namespace batten {

/// Applies the operations of a scene in order. The frames of the last operation are computed on
/// demand, and measured one by one.
///
///     SequenceEdits edits(scene, frames, report);
///     edits.find_parts();
///     edits.apply(read, progress);
///     edits.make_frames(0, edits.frame_count() - 1, [&](int k, const Points& p) {
///       edits.measure(k, p);
///       …
///     }, progress);
///     edits.finish_measures();
class SequenceEdits {
 public:
  /// Prepares the input. Keeps references to `scene` and to `report`, which receives counts,
  /// warnings and measures. Throws InputError that begins with the location of the input.
  SequenceEdits(const SequenceScene& scene, MeshSequence input, SequenceReport& report);
  SequenceEdits(const SequenceEdits&) = delete;
  SequenceEdits& operator=(const SequenceEdits&) = delete;

  /// Finds handles and features. Throws as find_sequence_parts().
  void find_parts();
  /// Applies all operations; the frames of the last one are not computed yet. Throws as run_step().
  void apply(const FrameReader& read, const Progress& progress);

  const PreparedSequence& input() const { return *input_; }
  const SequenceParts& parts() const { return parts_; }
  /// Faces and times of the result.
  const StepResult& result() const { return last_; }
  int frame_count() const { return isize(last_.times); }

  /// Computes frames first … last (0-based) of the result, and calls take(frame, positions) for each
  /// in order.
  void make_frames(int first, int last, const std::function<void(int, const Points&)>& take,
                   const Progress& progress) const;
  /// Adds a frame of the result to the measures. Frames must be added in ascending order.
  void measure(int frame, const Points& points);
  /// Stores the measures of all frames in the report.
  void finish_measures();
  /// The checks of the report that failed.
  std::vector<FailedCheck> failed_checks() const;

 private:
  /// Largest deviation of features and handles from a rigid-body motion by a step, over all frames,
  /// relative to the size of each part.
  struct PartDeviation {
    std::vector<double> features, handles;
  };
  void add_deviation(const Points& before, const Points& after);
  void add_warnings();

  const SequenceScene& scene_;
  SequenceReport& report_;
  std::shared_ptr<const PreparedSequence> input_, current_;
  MeshFile file_;
  VertexSelector select_;
  SequenceParts parts_;
  PartDeviation deviation_;
  StepResult last_;
  std::optional<FrameMeasures> measures_;
};

}  // namespace batten
