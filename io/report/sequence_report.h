// report.json of an edited mesh sequence, measured on the finished frames.
#pragma once

#include <string>
#include <vector>

#include "batten/io/report/run_report.h"

namespace batten {

/// Results of `batten sequence`. Lengths are in model units, *_s in seconds; "relative" means
/// divided by the size of the first frame. Frames are numbered from 1.
struct SequenceReport : RunReport {
  std::string file;
  int frames_before = 0, frames = 0, nodes = 0, faces = 0;
  double size = 0;
  int first = 1, last = 0;  ///< frames computed by this run
  int found = 0;            ///< number of these that an earlier run had completed

  /// Statistics of one step.
  struct Step {
    std::string name, kind;
    int frames = 0;  ///< number of frames after the step
    int keyframes = 0;
    int iterations = 0;             ///< maximum over the keyframes
    int unconverged_keyframes = 0;  ///< keyframes that stopped before reaching the tolerance
    double last_change = 0;         ///< largest of these, relative
    double seconds = 0;
  };
  std::vector<Step> steps;

  /// A handle or a feature.
  struct Handle {
    std::string name;
    int vertices = 0;
    /// Largest deviation from a rigid-body motion over all frames, relative to the handle's size.
    /// Compared with the handle's shape in the same input frame, so handles that deform in the
    /// input keep that deformation.
    double max_rigid_error = 0;
  };
  std::vector<Handle> handles, features;

  /// A foot contact.
  struct Foot {
    std::string step, handle;
    int first = 0, last = 0;
    /// Foot skate: largest distance of the foot's centroid from its mean position, relative.
    double foot_skate_before = 0, foot_skate = 0;
    double max_foot_skate = 1e-3;
  };
  std::vector<Foot> feet;

  /// Largest over all nodes and frames, model units.
  double second_difference_before = 0, second_difference = 0;
  /// Triangles whose normal deviates by more than 90° from the mean of their neighbours, over all
  /// frames.
  long inverted_triangles_before = 0, inverted_triangles = 0;
};

/// The report as JSON text.
std::string to_json(const SequenceReport& report);

}  // namespace batten
