// A deforming mesh: frames of one connectivity.
#pragma once

#include <string>
#include <vector>

#include "batten/mesh/prepared_mesh.h"

namespace batten {

/// Frames of one mesh: the faces stay, the nodes move. A value; positions are its only large part,
/// 24 bytes a node and frame.
struct MeshSequence {
  ShellMesh shells;            ///< faces, with the points of the first frame
  std::vector<Points> frames;  ///< of each frame, one point a node
  std::vector<double> times;   ///< of each frame, ascending: seconds, or the numbers of the frames

  int node_count() const { return shells.node_count(); }
  int frame_count() const { return isize(frames); }
};

/// Throws InputError, beginning with `name`, on what is no sequence: no frames, a frame with
/// another number of nodes (its number is named), a coordinate that is not finite or above 1e100 (frame and node),
/// times that are missing or do not ascend.
void check(const MeshSequence& sequence, const std::string& name);

/// Diagonal of the box around the first frame: lengths are compared with it.
double size_of(const MeshSequence& sequence);

/// Largest second difference |p_{k+1} - 2 p_k + p_{k-1}| of any vertex, of each frame but the first
/// and the last (0 there): jerks of an edit show in it.
std::vector<double> second_differences(const std::vector<Points>& frames);


// Walks on the spot become walks over the ground.

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
