// SPDX-License-Identifier: MPL-2.0
// Contents of report.json for an edited mesh sequence, measured on the finished frames.
#pragma once

#include <string>
#include <vector>

#include "batten/io/report/run_report.h"

namespace batten {

/// Results of `batten sequence`. Lengths are in model units; "relative" means divided by the size
/// of the first frame. Frames are numbered from 1.
struct SequenceReport : RunReport {
  std::string file;
  int frames_before = 0, frames = 0, nodes = 0, faces = 0;
  double size = 0;
  int first = 1, last = 0;  ///< first and last frame computed by this run
  int found = 0;            ///< number of frames of this run that were reused from an earlier one

  /// Statistics of one operation on the sequence.
  struct Step {
    std::string name, kind;
    int frames = 0;  ///< number of frames after the operation
    int keyframes = 0;
    int iterations = 0;  ///< largest number of iterations at a keyframe
    /// Number of keyframes that stopped before reaching the tolerance.
    int unconverged_keyframes = 0;
    /// Largest displacement of a node in the last iteration of an unconverged keyframe, relative to
    /// the size of the first frame.
    double last_change = 0;
    double seconds = 0;
  };
  std::vector<Step> steps;

  /// Shape preservation of a handle or of a form feature.
  struct Handle {
    std::string name;
    int vertices = 0;
    /// Largest deviation from a rigid-body motion over all frames, relative to the size of the
    /// handle. In each frame the handle is compared with its shape in the same input frame, so
    /// deformations that are part of the input do not count.
    double max_rigid_error = 0;
  };
  std::vector<Handle> handles, features;

  /// One foot contact: an interval of frames in which a foot is planted.
  struct Foot {
    std::string step, handle;
    int first = 0, last = 0;
    /// Foot skate before and after editing: largest distance of the centroid of the foot from its
    /// mean position during the contact, relative to the size of the first frame.
    double foot_skate_before = 0, foot_skate = 0;
    double max_foot_skate = 1e-3;
  };
  std::vector<Foot> feet;

  /// Largest second difference in time of a node position over all nodes and frames, before and
  /// after editing; model units.
  double second_difference_before = 0, second_difference = 0;
  /// Number of triangles, summed over all frames, whose normal deviates by more than 90° from the
  /// mean normal of the neighbouring triangles; before and after editing.
  long inverted_triangles_before = 0, inverted_triangles = 0;
};

/// The report of an edited sequence as JSON text.
std::string to_json(const SequenceReport& report);

}  // namespace batten
