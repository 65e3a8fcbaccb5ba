// Turns of handles, for solvers over all nodes and over few. Internal.
#pragma once

#include <vector>

#include "batten/mesh/deform/deform_system.h"
#include "batten/mesh/sequence/frame_problem.h"

namespace batten {

/// The mean of nodes; zero for none.
Vec3 centre_of(const std::vector<int>& nodes, const RowPoints& p);

/// The rotation that takes nodes about `from` best to where they are about `to`. `before`: the one they
/// had; where nothing tells, they turn no further.
Mat3 best_turn(const std::vector<int>& nodes, const RowPoints& rest, const Vec3& from,
               const RowPoints& now, const Vec3& to, const Mat3& before);

/// R of every node: the logarithms of the handles' turns, summed by its shares of them (nodes ×
/// handles).
void spread_turns(const MatX& share, const std::vector<HandlePlace>& handles,
                  std::vector<Mat3>& turns);

}  // namespace batten
