// What is known of a shape beside its dofs.
#pragma once

#include <string>
#include <array>
#include <atomic>
#include <memory>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/fem/parametric_mesh.h"

namespace batten {

/// The force with which a named line or constraint holds the surface: the sum of its reaction over
/// the position dofs, in the units of the loads.
struct Reaction {
  std::string name;
  Vec3 force = Vec3::Zero();
};

/// How far the points of a scan are from the surface, model units. Points beyond the rim are left
/// out.
struct PointCloudDistances {
  std::string name;
  int points = 0, left_out = 0;
  double before_max = 0, before_rms = 0;  ///< of the shape to compare with
  double max = 0, rms = 0;
};


// Display points of a moving surface, and how they reach a viewer's thread.

/// The facets and lines that connect display points. It changes with the mesh only.
struct DisplayTopology {
  std::vector<std::array<int, 3>> facets;
  std::vector<std::vector<std::vector<int>>> lines;  ///< DisplayFacets::lines, region after region
  /// The place of each point in the model's mesh; none where no model is behind it.
  std::vector<Location> locations;
  /// The number of each region's first facet and first line, and behind the last region.
  std::vector<int> first_facet, first_line;
};

/// A frame holds the display points of one moment for a viewer.
struct Frame {
  std::vector<float> points, normals;  ///< x, y, z one after the other
  std::shared_ptr<const DisplayTopology> pattern;
  long number = 0;        ///< counts frames
  bool moved = false;     ///< points or normals differ from the frame that was drawn before
  bool remeshed = false;  ///< the pattern differs from that which this frame had before
};

/// Passes frames from one writer's thread to one reader's thread. Three frames are in use, so that
/// neither of the two ever waits; the reader gets the newest frame that is complete.
class FrameExchange {
 public:
  /// Writer: returns the frame to fill. Its buffers keep their size from use to use.
  Frame& writing() { return frames_[write_]; }
  /// Writer: hands the filled frame over.
  void publish();
  /// Reader: returns the newest frame, or null when latest() has returned it before. It stays valid
  /// until the next latest().
  const Frame* latest();

 private:
  std::array<Frame, 3> frames_;
  int write_ = 0, read_ = 1;
  std::atomic<int> middle_{2};  // bit 2: not read yet
};

}  // namespace batten
