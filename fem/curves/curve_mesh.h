// The parameter line of a deformable curve: segments, how their ends are joined, and the dofs.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "batten/core/containers.h"

namespace batten {

/// Segments between parameters u_0 < u_1 < … < u_m, each with its own parametric length. A closed
/// curve comes back at u_m to node 0. Where segments meet, position and dX/du are shared (C1),
/// except at corners, where only the position is: a corner has one slope for each side.
///
/// Dofs of one coordinate, numbered along the curve, so that a segment's four follow each other:
///
///     smooth node     w, w_u          also the first node of an open curve
///     corner          w_u of the segment before, w, w_u of the segment after
///
/// An open curve without corners: w, w_u of node i are dofs 2i, 2i + 1.
class CurveMesh {
 public:
  CurveMesh() = default;
  /// `corners`: nodes, the first and the last of an open curve not among them; node 0 of a closed
  /// one is its seam. Throws InputError: fewer than two parameters (closed: three), parameters that
  /// are not finite or do not increase, a corner that is not such a node.
  explicit CurveMesh(std::vector<double> parameters, bool closed = false,
                     std::vector<int> corners = {});

  int segment_count() const { return isize(parameters_) - 1; }
  int node_count() const { return segment_count() + (closed_ ? 0 : 1); }
  int dof_count() const { return 2 * node_count() + isize(corners_); }
  bool closed() const { return closed_; }
  /// Parameters u_0 … u_m of the nodes; a closed curve has one more, u_m, for node 0.
  const std::vector<double>& parameters() const { return parameters_; }
  /// Nodes that are corners, ascending.
  const std::vector<int>& corners() const { return corners_; }
  bool is_corner(int node) const {
    const size_t k = corners_before(node);
    return k < corners_.size() && corners_[k] == node;
  }

  double start() const { return parameters_.front(); }
  double end() const { return parameters_.back(); }
  double length(int segment) const { return parameters_[segment + 1] - parameters_[segment]; }

  int position_dof(int node) const { return first_dof(node) + is_corner(node); }
  /// Slope dofs of the segment that ends at the node, and of the one that begins there.
  int slope_in(int node) const { return first_dof(node) + !is_corner(node); }
  int slope_out(int node) const { return position_dof(node) + 1; }
  /// Dofs of a segment in the order of HermiteSegment.
  std::array<int, 4> segment_dofs(int segment) const;

  struct SegmentPoint {
    int segment = 0;
    double s = 0;  ///< in [0, 1]
  };
  /// Place of a parameter u, which is clamped to an open curve and comes around on a closed one. A
  /// node is in the segment that begins there, the end of an open curve in the last one.
  SegmentPoint locate(double u) const;
  /// The parameter within [start(), end()] that u stands for: clamped, or come around.
  double wrapped(double u) const;

 private:
  size_t corners_before(int node) const {
    return corners_.empty()
               ? 0
               : std::lower_bound(corners_.begin(), corners_.end(), node) - corners_.begin();
  }
  int first_dof(int node) const { return 2 * node + static_cast<int>(corners_before(node)); }

  std::vector<double> parameters_;
  bool closed_ = false;
  std::vector<int> corners_;
};

}  // namespace batten
