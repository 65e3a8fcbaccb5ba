// SPDX-License-Identifier: MPL-2.0
// Mesh of a deformable curve: parameters, segments, corners and dof numbering.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "batten/core/containers.h"

namespace batten {

/// Mesh of a curve: segments between the parameters u_0 < u_1 < … < u_m. A closed curve returns to
/// node 0 at u_m. At a node, adjacent segments share position and dX/du (C1). At a corner they
/// share only the position, and each side has its own derivative.
///
/// Dofs of one coordinate are numbered along the curve, so that the four dofs of a segment are
/// consecutive:
///
///     smooth node     w, w_u          also the first node of an open curve
///     corner          w_u of the previous segment, w, w_u of the next segment
///
/// On an open curve without corners, w and w_u of node i are dofs 2i, 2i + 1.
class CurveMesh {
 public:
  CurveMesh() = default;
  /// `parameters`: parameters u of the nodes, strictly increasing; on a closed curve, followed by
  /// the parameter at which node 0 is reached again. `corners`: indices of the nodes that are
  /// corners; not the first and last node of an open curve. On a closed curve, node 0 is the seam
  /// and may be a corner. Throws InputError if there are fewer than two parameters (closed: three),
  /// if they are not finite or not increasing, or if a corner is not a valid node.
  explicit CurveMesh(std::vector<double> parameters, bool closed = false,
                     std::vector<int> corners = {});

  int segment_count() const { return isize(parameters_) - 1; }
  int node_count() const { return segment_count() + (closed_ ? 0 : 1); }
  int dof_count() const { return 2 * node_count() + isize(corners_); }
  bool closed() const { return closed_; }
  /// Curve parameters of the nodes, ascending. On a closed curve, there is one parameter more than
  /// there are nodes, because the last parameter belongs to node 0 again.
  const std::vector<double>& parameters() const { return parameters_; }
  /// Indices of the corners, ascending. Corners are nodes at which the derivative of the curve may
  /// jump.
  const std::vector<int>& corners() const { return corners_; }
  bool is_corner(int node) const {
    const size_t k = corners_before(node);
    return k < corners_.size() && corners_[k] == node;
  }

  double start() const { return parameters_.front(); }
  double end() const { return parameters_.back(); }
  double length(int segment) const { return parameters_[segment + 1] - parameters_[segment]; }

  int position_dof(int node) const { return first_dof(node) + is_corner(node); }
  /// Index of the dof for the derivative dX/du of the curve just before a node. slope_out(): the
  /// dof for dX/du just after the node. The two dofs are identical unless the node is a corner.
  int slope_in(int node) const { return first_dof(node) + !is_corner(node); }
  int slope_out(int node) const { return position_dof(node) + 1; }
  /// Indices of the four dofs of a segment: position and slope at its start, then at its end.
  std::array<int, 4> segment_dofs(int segment) const;

  /// Segment and local coordinate of a point of the curve.
  struct SegmentPoint {
    int segment = 0;
    double s = 0;  ///< local coordinate in [0, 1]
  };
  /// Segment that contains the curve parameter u, and local coordinate of u in it; u is clamped on
  /// an open curve and wrapped on a closed one. The parameter of a node gives the segment that
  /// begins there; the end of an open curve gives the last segment.
  SegmentPoint locate(double u) const;
  /// Curve parameter u mapped into [start(), end()]: clamped (open curve) or wrapped (closed).
  double wrapped(double u) const;

 private:
  // Number of corners before a node. Inline, because each evaluation of a curve calls it.
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
