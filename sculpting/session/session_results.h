// SPDX-License-Identifier: MPL-2.0
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

/// Reaction force that a named curve or constraint exerts on the surface: the sum over its position
/// dofs, in the units of the loads.
struct Reaction {
  std::string name;
  Vec3 force = Vec3::Zero();
};

/// Distances of a point cloud from the surface, model units. Points beyond the boundary of the
/// surface are excluded and counted in `left_out`.
struct PointCloudDistances {
  std::string name;
  int points = 0, left_out = 0;
  /// Largest and RMS distance from the shape used for comparison.
  double before_max = 0, before_rms = 0;
  double max = 0, rms = 0;
};

// Display points of a moving surface, and their transfer to a viewer's thread.

/// Facets and curves that connect the display points. They change only if the mesh changes.
struct DisplayTopology {
  std::vector<std::array<int, 3>> facets;
  /// Point indices of the polylines of each curve: [curve][polyline][point], region by region. See
  /// DisplayFacets::lines.
  std::vector<std::vector<std::vector<int>>> lines;
  /// Location of each display point in the mesh of the model; empty if there is no model.
  std::vector<Location> locations;
  /// Index of the first facet and of the first curve of each region, followed by the total numbers.
  std::vector<int> first_facet, first_line;
};

/// Display points and normals of the surface at one moment.
struct Frame {
  std::vector<float> points, normals;  ///< x, y, z of each point, one point after the other
  std::shared_ptr<const DisplayTopology> pattern;
  long number = 0;        ///< running number of the frame
  bool moved = false;     ///< true: points or normals differ from the previous frame
  bool remeshed = false;  ///< true: `pattern` was replaced when this frame was last filled
};

/// Lock-free triple buffer that passes frames from one writer thread to one reader thread. Neither
/// ever waits, and the reader gets the newest complete frame.
class FrameExchange {
 public:
  /// The frame that the writer thread fills next. Its buffers keep their capacity.
  Frame& writing() { return frames_[write_]; }
  /// Publishes the frame that the writer thread has filled.
  void publish() {
    // Release: the written data is visible before the reader gets the frame. Acquire: the reader is
    // done with the frame that comes back.
    write_ = middle_.exchange(write_ | kUnread, std::memory_order_acq_rel) & ~kUnread;
  }
  /// The newest published frame, for the reader thread; null if latest() has already returned it.
  /// The frame stays valid until the next call of latest().
  const Frame* latest() {
    if (!(middle_.load(std::memory_order_relaxed) & kUnread)) return nullptr;
    read_ = middle_.exchange(read_, std::memory_order_acq_rel) & ~kUnread;
    return &frames_[read_];
  }

 private:
  // Each of the three frames belongs to the writer, to the reader, or to the middle. Publishing or
  // taking a frame swaps it with the middle one.
  static constexpr int kUnread = 4;
  std::array<Frame, 3> frames_;
  int write_ = 0, read_ = 1;
  std::atomic<int> middle_{2};  // index of the frame in the middle, plus kUnread if not read yet
};

}  // namespace batten
