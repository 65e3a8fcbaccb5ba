// Turns of handles, for solvers over all nodes and over few. Internal.
#pragma once

#include <vector>

#include "batten/mesh/deform/deform_system.h"
#include "batten/mesh/sequence/frame_constraints.h"

namespace batten {

/// The mean of nodes; zero for none.
Vec3 centre_of(const std::vector<int>& nodes, const RowPoints& p);

/// The rotation that takes nodes about `from` best to where they are about `to`. `before`: the one they
/// had; where nothing tells, they turn no further.
Mat3 best_rotation(const std::vector<int>& nodes, const RowPoints& rest, const Vec3& from,
                   const RowPoints& now, const Vec3& to, const Mat3& before);

/// R of every node: the logarithms of the handles' turns, summed by its shares of them (nodes ×
/// handles).
void spread_rotations(const MatX& handle_weights, const std::vector<HandlePose>& handles,
                      std::vector<Mat3>& rotations);

}  // namespace batten
