// SPDX-License-Identifier: MPL-2.0
// Deforming meshes: sequences of frames with common connectivity, quality measures of sequences,
// and root motion for walks recorded on the spot.
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "batten/mesh/prepared_mesh.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// A deforming mesh: all frames have the same faces, but different node positions. It has value
/// semantics; the positions take 24 bytes per node and frame.
struct MeshSequence {
  ShellMesh shells;            ///< faces of all frames, and node coordinates of the first frame
  std::vector<Points> frames;  ///< node positions of each frame, nodes × 3
  std::vector<double> times;   ///< time of each frame, ascending: seconds or frame numbers

  int node_count() const { return shells.node_count(); }
  int frame_count() const { return isize(frames); }
};

/// Checks a sequence. Throws InputError if there are no frames, a frame has a different number of
/// nodes, a coordinate is not finite or above 1e100, or times are missing or do not ascend. `name`:
/// name of the sequence, the first words of the messages.
void check(const MeshSequence& sequence, const std::string& name);

/// Size of a sequence: the diagonal of the bounding box of the first frame, which is the reference
/// for relative lengths.
double size_of(const MeshSequence& sequence);

/// Largest second difference in time, |p_{k+1} - 2 p_k + p_{k-1}|, of any node in each frame k, in
/// model units (0 for the first and last frame). Peaks indicate jerky motion caused by an edit.
std::vector<double> second_differences(const std::vector<Points>& frames);

/// Quality measures of a sequence, accumulated frame by frame. At most three frames are in memory.
class FrameMeasures {
 public:
  /// A foot, given by its vertices, that should not move in the frames `first` … `last` (0-based).
  struct Foot {
    std::vector<int> vertices;
    int first = 0, last = 0;
  };

  /// Starts without frames. Keeps a reference to `mesh`: any frame of the sequence, converted by
  /// prepare(). `feet`: feet for foot_skate().
  explicit FrameMeasures(const TriangleMesh& mesh, std::vector<Foot> feet = {});

  /// Adds the next frame to the measures. `frame`: 0-based frame number. `p`: node positions (nodes
  /// × 3). O(triangles).
  void add(int frame, const Points& p);

  /// Largest second difference in time, |p_{k+1} - 2 p_k + p_{k-1}|, of any node in any frame k, in
  /// model units. second_differences() gives the values of the individual frames.
  double max_second_difference() const { return max_second_difference_; }
  /// Total number of inverted triangles in all frames. A triangle is inverted if the angle between
  /// its normal and the area-weighted mean normal of the adjacent triangles is above 90°.
  long inverted_triangles() const { return inverted_triangles_; }
  /// Foot skate: largest distance of the centroid of a foot from the mean position of the centroid
  /// in the frames Foot::first … Foot::last, model units; 0 if none of these frames was added.
  /// `foot`: index of the foot.
  double foot_skate(int foot) const;

 private:
  long count_inverted_triangles(const Points& p) const;

  const TriangleMesh& mesh_;
  std::vector<Foot> feet_;
  std::vector<std::vector<Vec3>> centres_;  // of each foot, in its frames
  std::deque<Points> last_;
  double max_second_difference_ = 0;
  long inverted_triangles_ = 0;
};

// Root motion for walks recorded on the spot.

/// Forward speed with which a walk recorded on the spot has no foot skate, in model units per
/// frame. Between two consecutive frames, the foot with the lowest centroid along `up` moves
/// backwards. The speed is the median of these backward displacements along the unit vector
/// `direction`; it is negative if the feet move forwards. `feet`: vertices of each foot. Throws
/// InputError if there are fewer than two frames or no feet. O(frames · vertices of feet).
double stance_speed(const std::vector<Points>& frames, const std::vector<std::vector<int>>& feet,
                    const Vec3& direction, const Vec3& up);

/// Repeats a sequence `cycles` times and adds root motion: each frame is translated by `speed`
/// along the unit vector `direction` relative to the previous frame. If the last frame equals the
/// first one (to 1e-6 of size_of()), it is omitted between cycles. After the first cycle, frames
/// have the mean time step. Throws InputError if `cycles` is below 1 or the sequence has a single
/// frame.
MeshSequence with_root_motion(const MeshSequence& sequence, int cycles, const Vec3& direction,
                              double speed);

}  // namespace batten
