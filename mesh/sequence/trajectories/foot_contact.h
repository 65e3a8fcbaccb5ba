// Where a handle stays put for a while: feet on the ground.
#pragma once

#include <limits>
#include <string>
#include <vector>
#include <optional>

#include "batten/mesh/sequence/trajectories/handle_trajectory.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

// The ground of a sequence: which point of a mesh is above or below a place, and its normal.

/// A triangle mesh seen from above. Triangles may be given either way round, may be steep, and may
/// lie above each other; upright ones are not seen.
class Terrain {
 public:
  /// Throws InputError on an `up` that is no direction and on a mesh without triangles to be seen.
  /// O(triangles) and a grid of about as many cells.
  explicit Terrain(TriangleMesh mesh, const Vec3& up = Vec3::UnitZ());

  struct SurfacePoint {
    Vec3 at;
    Vec3 normal;  ///< unit, upwards; vertex normals (means by area) interpolated
  };
  /// The highest point of the mesh on the line p + t · up; none where there is no mesh. The few
  /// triangles of one cell are looked at.
  std::optional<SurfacePoint> surface_point(const Vec3& p) const;
  const Vec3& up() const { return up_; }

 private:
  Vec2 to_plane(const Vec3& p) const { return {p.dot(across_[0]), p.dot(across_[1])}; }
  int cell(double x, int axis) const;
  TriangleMesh mesh_;
  Vec3 up_, across_[2];
  Points normals_;  // of the nodes
  Vec2 low_, step_;
  int cells_ = 1;                  // along each axis
  std::vector<int> start_, list_;  // triangles of each cell
};


/// Frames first … last, in which a handle is at one place with one rotation.
struct FootContact {
  int first = 0, last = 0;
  Vec3 at = Vec3::Zero();            ///< of its centroid
  Mat3 rotation = Mat3::Identity();  ///< from the first frame of the sequence
};

struct FootContactOptions {
  double max_spread =
      0;  ///< model units, above 0: the largest distance between two of its centroids
  /// Model units a frame: the largest step from one frame of it to the next.
  double speed = std::numeric_limits<double>::infinity();
  int frames = 3;  ///< fewest frames of a footprint
};

/// Those vertices that are lowest along `up` in the mean over all frames, `fraction` of them, one at
/// least, ascending: a sole, whose trajectory has clearer footprints than that of a foot. Throws
/// InputError: no vertices, no frames, a vertex that a frame does not have. O(frames · vertices).
std::vector<int> lowest_vertices(const std::vector<Points>& frames,
                                 const std::vector<int>& vertices, const Vec3& up,
                                 double fraction = 0.1);

/// Footprints in the order of their frames, none overlapping: the longest interval that the options
/// allow, then the longest on either side of it, and so on; of two as long the earlier. Place and
/// rotation are means over its frames. Throws InputError on options that allow nothing. O(F ·
/// frames of the longest + F · footprints).
std::vector<FootContact> detect_foot_contacts(const Trajectory& trajectory,
                                              const FootContactOptions& options);

/// Place and rotation moved, the frames as they are.
FootContact moved(const RigidMotion& motion, const FootContact& contact);

/// How a footprint stands on a terrain.
struct ContactPose {
  double clearance = 0;    ///< model units, from the terrain to the centroid
  bool rotations = false;  ///< with the normal, clearance measured along it; else along up
};

/// Moved along up onto the terrain. A footprint that turns does so by the smallest rotation that
/// takes up to the terrain's normal. Throws InputError, beginning with `name`, where there is no
/// terrain.
FootContact projected(const FootContact& contact, const Terrain& terrain,
                      const ContactPose& contact_pose, const std::string& name);

/// Of each footprint the rigid mean of its images, one in each of its frames: the mean of M_k(at)
/// and of the rotations M_k.turn · turn (`mean_rotation`). `motions`: one a frame. Throws
/// InputError on a footprint that is outside of these.
std::vector<FootContact> averaged(const std::vector<FootContact>& foot_contacts,
                                  const std::vector<RigidMotion>& motions);

/// Throws InputError, beginning with `name`, on footprints of one handle that cannot be: last
/// before first, frames that are not there, two that overlap at different places or with different
/// rotations (more than 1e-9 of the largest coordinate, or of a radian). O(n²).
void check(const std::vector<FootContact>& foot_contacts, int frames, const std::string& name);

/// Every frame of a footprint becomes a keyframe: the handle moves as its footprint does, from
/// `from` to `to`, so that what it does within is kept. In the order of frames. Throws InputError,
/// beginning with `name`, on what check() refuses in `to`, and on footprints whose frames are not
/// the same in both.
std::vector<HandleKeyframe> keyframes_of(const std::vector<FootContact>& from,
                                         const std::vector<FootContact>& to, int frames,
                                         const std::string& name);

}  // namespace batten
