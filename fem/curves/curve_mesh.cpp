// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/curves/curve_mesh.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "batten/core/errors.h"

namespace batten {

CurveMesh::CurveMesh(std::vector<double> parameters, bool closed, std::vector<int> corners)
    : parameters_(std::move(parameters)), closed_(closed), corners_(std::move(corners)) {
  if (parameters_.size() < 2) throw InputError("a curve needs at least two nodes");
  if (closed_ && parameters_.size() < 3)
    throw InputError("a closed curve needs two segments or more");
  if (!std::isfinite(start()) || !std::isfinite(end()))
    throw InputError("a curve parameter is not finite");
  for (size_t i = 0; i + 1 < parameters_.size(); ++i)
    if (!(parameters_[i + 1] > parameters_[i]))
      throw InputError("curve parameters must increase: u[" + std::to_string(i) +
                       "] = " + format_number(parameters_[i]) + ", u[" + std::to_string(i + 1) +
                       "] = " + format_number(parameters_[i + 1]));
  std::sort(corners_.begin(), corners_.end());
  corners_.erase(std::unique(corners_.begin(), corners_.end()), corners_.end());
  const int first = closed_ ? 0 : 1, last = closed_ ? node_count() - 1 : node_count() - 2;
  for (const int c : corners_)
    if (c < first || c > last)
      throw InputError("found a corner at node " + std::to_string(c) +
                       " of a curve, expected a node from " + std::to_string(first) + " to " +
                       std::to_string(last));
}

std::array<int, 4> CurveMesh::segment_dofs(int segment) const {
  const int next = segment + 1 == node_count() ? 0 : segment + 1;
  return {position_dof(segment), slope_out(segment), position_dof(next), slope_in(next)};
}

double CurveMesh::wrapped(double u) const {
  if (!closed_) return std::clamp(u, start(), end());
  if (u >= start() && u <= end()) return u;
  const double period = end() - start();
  return std::clamp(u - period * std::floor((u - start()) / period), start(), end());
}

CurveMesh::SegmentPoint CurveMesh::locate(double u) const {
  u = wrapped(u);
  const auto it = std::upper_bound(parameters_.begin() + 1, parameters_.end() - 1, u);
  const int i = static_cast<int>(it - parameters_.begin()) - 1;
  return {i, (u - parameters_[i]) / length(i)};
}

}  // namespace batten
