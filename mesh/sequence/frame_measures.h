// Measurements of consecutive frames of a sequence: jerks, inverted triangles and foot skate.
#pragma once

#include <deque>
#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Measurements accumulated over consecutive frames, of which at most three are in memory.
class FrameMeasures {
 public:
  /// A foot that should not move in the frames `first` … `last` (0-based).
  struct Foot {
    std::vector<int> vertices;
    int first = 0, last = 0;
  };

  /// Keeps a reference to `mesh`: any frame, converted by prepare().
  explicit FrameMeasures(const TriangleMesh& mesh, std::vector<Foot> feet = {});

  /// Adds the next frame: its 0-based number, and one position per node. O(triangles).
  void add(int frame, const Points& p);

  /// Largest second difference |p_{k+1} - 2 p_k + p_{k-1}| of a node over time, model units. See
  /// second_differences() for single frames.
  double max_second_difference() const { return max_second_difference_; }
  /// Number of inverted triangles in all frames: those whose normal deviates by more than 90° from
  /// the mean of their neighbours.
  long inverted_triangles() const { return inverted_triangles_; }
  /// Largest distance of the centroid of a foot from its mean position in its frames, model units;
  /// 0 if none of them was added.
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

}  // namespace batten
