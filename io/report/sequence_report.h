// report.json of an edited sequence: measured on the finished frames.
#pragma once

#include <string>
#include <vector>

#include "batten/io/report/run_report.h"

namespace batten {

/// What `batten sequence` did. Lengths are in model units, shares are over the size of the first
/// frame, *_s in seconds. Frames count from 1.
struct SequenceReport : RunReport {
  std::string file;
  int frames_before = 0, frames = 0, nodes = 0, faces = 0;
  double size = 0;
  int first = 1, last = 0;  ///< frames that this run made
  int found = 0;            ///< of these, frames that an earlier run had left

  struct Step {
    std::string name, kind;
    int frames = 0;  ///< after it
    int keyframes = 0;
    int iterations = 0;             ///< most of any keyframe
    int unconverged_keyframes = 0;  ///< keyframes whose rounds ended before their tolerance
    double last_change = 0;         ///< largest of these, a share
    double seconds = 0;
  };
  std::vector<Step> steps;

  struct Handle {
    std::string name;
    int vertices = 0;
    double max_rigid_error = 0;  ///< largest in any frame, against its own rest in that frame; a
                                 ///< share of its size. Sequences whose handles bend by themselves
                                 ///< keep their bend
  };
  std::vector<Handle> handles, features;

  struct Foot {
    std::string step, handle;
    int first = 0, last = 0;
    double foot_skate_before = 0,
           foot_skate = 0;  ///< largest distance of its centroid from its mean, a share
    double max_foot_skate = 1e-3;
  };
  std::vector<Foot> feet;

  double second_difference_before = 0, second_difference = 0;  ///< largest, model units
  long inverted_triangles_before = 0,
       inverted_triangles = 0;  ///< triangles whose normal turns by more than 90°
                                ///< against the mean of the neighbours, in all frames
};

std::string to_json(const SequenceReport& report);

}  // namespace batten
