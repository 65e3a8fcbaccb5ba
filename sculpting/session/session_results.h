// Results of a session besides its dofs: reactions, point-cloud distances, and display frames for a
// viewer's thread.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/fem/parametric_mesh.h"

namespace batten {

/// Reaction force of a named line or constraint on the surface: the sum over its position dofs, in
/// the units of the loads.
struct Reaction {
  std::string name;
  Vec3 force = Vec3::Zero();
};

/// Distances of a point cloud from the surface, model units. Points beyond the boundary are
/// excluded.
struct PointCloudDistances {
  std::string name;
  int points = 0, left_out = 0;
  double before_max = 0, before_rms = 0;  ///< distances from the comparison shape
  double max = 0, rms = 0;
};

// Display points of a moving surface, and their transfer to a viewer's thread.

/// Facets and lines that connect the display points. It changes only with the mesh.
struct DisplayTopology {
  std::vector<std::array<int, 3>> facets;
  /// Point indices: DisplayFacets::lines, region by region.
  std::vector<std::vector<std::vector<int>>> lines;
  /// Location of each point in the model's mesh; empty if there is no model.
  std::vector<Location> locations;
  /// Index of the first facet and the first line of each region, and one past the last region.
  std::vector<int> first_facet, first_line;
};

/// Display points and normals of one moment.
struct Frame {
  std::vector<float> points, normals;  ///< coordinates x, y, z of one point after the other
  std::shared_ptr<const DisplayTopology> pattern;
  long number = 0;        ///< frame counter
  bool moved = false;     ///< points or normals differ from those of the previous frame
  bool remeshed = false;  ///< the pattern differs from the one this frame had before
};

/// Lock-free triple buffer that passes frames from one writer thread to one reader thread. Neither
/// ever waits, and the reader gets the newest complete frame.
class FrameExchange {
 public:
  /// Writer: the frame to fill. Its buffers keep their capacity.
  Frame& writing() { return frames_[write_]; }
  /// Writer: publishes the filled frame.
  void publish();
  /// Reader: the newest frame, or null if latest() has already returned it. It stays valid until
  /// the next call.
  const Frame* latest();

 private:
  std::array<Frame, 3> frames_;
  int write_ = 0, read_ = 1;
  std::atomic<int> middle_{2};  // index of the frame in the middle; bit 2: not read yet
};

}  // namespace batten
