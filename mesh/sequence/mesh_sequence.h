// Deforming meshes: sequences of frames with common connectivity, and conversion of in-place walks.
#pragma once

#include <string>
#include <vector>

#include "batten/mesh/prepared_mesh.h"

namespace batten {

/// A deforming mesh: the faces are the same in all frames, the nodes move. Value semantics; the
/// positions take 24 bytes per node and frame.
struct MeshSequence {
  ShellMesh shells;            ///< faces, and the points of the first frame
  std::vector<Points> frames;  ///< per frame: one point per node
  std::vector<double> times;   ///< per frame, ascending: seconds, or frame numbers

  int node_count() const { return shells.node_count(); }
  int frame_count() const { return isize(frames); }
};

/// Checks a sequence. Throws InputError, whose message begins with `name`: no frames; a frame with
/// another number of nodes (its number is stated); a coordinate that is not finite or above 1e100
/// (frame and node are stated); times that are missing or do not ascend.
void check(const MeshSequence& sequence, const std::string& name);

/// Diagonal of the bounding box of the first frame, the reference for relative lengths.
double size_of(const MeshSequence& sequence);

/// Largest second difference |p_{k+1} - 2 p_k + p_{k-1}| of any vertex, per frame (0 for the first
/// and last frame). Peaks reveal jerks caused by an edit.
std::vector<double> second_differences(const std::vector<Points>& frames);

// Conversion of in-place walks to walks over the ground.

/// Speed that makes an in-place walk move forward without foot skate. For each pair of frames the
/// lowest foot (centroid along `up`) moves backwards; the result is the median of these
/// displacements along `direction`. `feet`: vertices of each foot. In model units per frame;
/// negative if the feet move forwards. Throws InputError: fewer than two frames, no feet. O(frames
/// · vertices of feet).
double stance_speed(const std::vector<Points>& frames, const std::vector<std::vector<int>>& feet,
                    const Vec3& direction, const Vec3& up);

/// Repeats the frames `cycles` times and adds root motion: each frame is shifted along `direction`
/// by `speed` relative to the previous one. If the last frame equals the first one (within 1e-6 of
/// the size), it is omitted between cycles. Times continue with the mean time step. Throws
/// InputError: fewer than one cycle, a single frame.
MeshSequence with_root_motion(const MeshSequence& sequence, int cycles, const Vec3& direction,
                              double speed);

}  // namespace batten
