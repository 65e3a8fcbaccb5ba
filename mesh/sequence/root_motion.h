// Walks on the spot become walks over the ground.
#pragma once

#include <vector>

#include "batten/mesh/sequence/mesh_sequence.h"

namespace batten {

/// How far a walk on the spot should go from each frame to the next, along `direction`, so that the
/// foot that stands does not slide: of each pair of frames the lowest foot (centroid, along `up`)
/// moves backwards; the median of that. Model units a frame; below 0 where it moves forwards. Throws
/// InputError: fewer than two frames, no feet. O(frames · vertices of feet).
double stance_speed(const std::vector<Points>& frames, const std::vector<std::vector<int>>& feet,
                    const Vec3& direction, const Vec3& up);

/// The frames `cycles` times one after the other, each farther along `direction` by `speed` than the
/// one before. Where the last frame is the first one again (within 1e-6 of the size) it is left out
/// between cycles. Times go on at the mean step. Throws InputError: fewer than one cycle, a single
/// frame.
MeshSequence with_root_motion(const MeshSequence& sequence, int cycles, const Vec3& direction,
                              double speed);

}  // namespace batten
