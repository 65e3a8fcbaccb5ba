// Foot contacts: intervals in which a handle rests, their detection, and their projection to a
// terrain.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "batten/mesh/sequence/trajectories/handle_trajectory.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

// Terrain: height and normal of the ground.

/// A triangle mesh as a height field along `up`. Triangles may have any orientation, be steep, and
/// lie above each other; vertical ones are ignored.
class Terrain {
 public:
  /// Builds a uniform grid over the triangles. Throws InputError if `up` has no direction or no
  /// triangle is visible along it. O(triangles); the grid has about as many cells.
  explicit Terrain(TriangleMesh mesh, const Vec3& up = Vec3::UnitZ());

  /// A point on the terrain.
  struct SurfacePoint {
    Vec3 at;
    Vec3 normal;  ///< unit vector, upwards; interpolated from area-weighted vertex normals
  };
  /// The highest point of the terrain on the line p + t · up; empty outside the terrain. Tests the
  /// few triangles of one grid cell.
  std::optional<SurfacePoint> surface_point(const Vec3& p) const;
  const Vec3& up() const { return up_; }

 private:
  Vec2 to_plane(const Vec3& p) const { return {p.dot(across_[0]), p.dot(across_[1])}; }
  int cell(double x, int axis) const;
  TriangleMesh mesh_;
  Vec3 up_, across_[2];
  Points normals_;  // per node
  Vec2 low_, step_;
  int cells_ = 1;                  // number of cells along each axis
  std::vector<int> start_, list_;  // triangles of each cell
};

/// A foot contact: frames `first` … `last` (0-based), in which a handle has one position and
/// rotation.
struct FootContact {
  int first = 0, last = 0;
  Vec3 at = Vec3::Zero();            ///< position of the centroid of the handle
  Mat3 rotation = Mat3::Identity();  ///< relative to the first frame of the sequence
};

/// Options of detect_foot_contacts().
struct FootContactOptions {
  double max_spread =
      0;  ///< above 0, model units: largest distance between two centroids within a contact
  /// Largest displacement between consecutive frames of a contact, in model units per frame.
  double speed = std::numeric_limits<double>::infinity();
  int frames = 3;  ///< minimum length of a contact
};

/// Selects the vertices that are lowest along `up` on average over all frames. `fraction`: the
/// fraction of the vertices to select (at least one vertex), default 0.1. The trajectory of a sole
/// shows contacts more clearly than that of the whole foot. The result is ascending. Throws
/// InputError: no vertices, no frames, a vertex out of range. O(frames · vertices).
std::vector<int> lowest_vertices(const std::vector<Points>& frames,
                                 const std::vector<int>& vertices, const Vec3& up,
                                 double fraction = 0.1);

/// Detects foot contacts in a trajectory, in the order of their frames and without overlap. The
/// longest interval that the options allow is taken first, then the longest on either side of it,
/// and so on; ties go to the earlier one. Position and rotation are means over the interval. Throws
/// InputError if an option is not above 0. O(F · frames of the longest contact + F · contacts).
std::vector<FootContact> detect_foot_contacts(const Trajectory& trajectory,
                                              const FootContactOptions& options);

/// Applies a rigid motion to position and rotation of a contact; its frames are unchanged.
FootContact moved(const RigidMotion& motion, const FootContact& contact);

/// How a contact is placed on a terrain.
struct ContactPose {
  double clearance = 0;  ///< distance of the centroid from the terrain, model units
  /// true: aligned with the terrain normal, clearance along the normal; false: clearance along up.
  bool rotations = false;
};

/// Projects a contact along `up` onto the terrain. If the pose rotates, the smallest rotation from
/// up to the terrain normal is applied. Throws InputError, whose message begins with `name`, if
/// there is no terrain.
FootContact projected(const FootContact& contact, const Terrain& terrain,
                      const ContactPose& contact_pose, const std::string& name);

/// Averages the images of each contact under the motions of its frames: the mean of M_k(at), and of
/// the rotations M_k.rotation · rotation (by mean_rotation()). `motions`: one per frame. Throws
/// InputError if a contact is outside these frames.
std::vector<FootContact> averaged(const std::vector<FootContact>& foot_contacts,
                                  const std::vector<RigidMotion>& motions);

/// Checks the contacts of one handle. Throws InputError, whose message begins with `name`: last
/// before first, frames out of range, overlapping contacts with different positions or rotations
/// (by more than 1e-9 of the largest coordinate, or 1e-9 rad). O(n²).
void check(const std::vector<FootContact>& foot_contacts, int frames, const std::string& name);

/// Converts contacts to keyframes: one per frame of a contact. The handle moves by the rigid motion
/// from contact `from` to contact `to`, so its motion within the contact is preserved. The
/// keyframes are ordered by frame. Throws InputError, whose message begins with `name`, if check()
/// rejects `to`, or if the frames of `from` and `to` differ.
std::vector<HandleKeyframe> keyframes_of(const std::vector<FootContact>& from,
                                         const std::vector<FootContact>& to, int frames,
                                         const std::string& name);

}  // namespace batten
