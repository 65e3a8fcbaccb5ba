// SPDX-License-Identifier: MPL-2.0
// Foot contacts (intervals of frames in which a handle rests): detection, and projection onto a
// terrain.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/box_tree.h"
#include "batten/mesh/sequence/trajectories/handle_trajectory.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

// Terrain: height and normal of the ground.

/// A terrain: a triangle mesh that is used as a height field along `up`. Triangles may have any
/// orientation, be steep, and lie above each other; vertical triangles are ignored.
class Terrain {
 public:
  /// Prepares queries of the terrain by a BoxTree over its triangles, projected along `up`. Throws
  /// InputError if `up` is zero or not finite, or if all triangles are vertical. O(triangles · log
  /// triangles).
  explicit Terrain(TriangleMesh mesh, const Vec3& up = Vec3::UnitZ());

  /// A point on the terrain.
  struct SurfacePoint {
    Vec3 at;
    Vec3 normal;  ///< upward unit normal, interpolated from vertex normals
  };
  /// The highest point of the terrain on the line through p along up(); empty if the line does not
  /// meet the terrain. O(log triangles) if few triangles lie above each other.
  std::optional<SurfacePoint> surface_point(const Vec3& p) const;
  const Vec3& up() const { return up_; }

 private:
  Vec2 to_plane(const Vec3& p) const { return {p.dot(across_[0]), p.dot(across_[1])}; }
  TriangleMesh mesh_;
  Vec3 up_, across_[2];
  Points normals_;   // per node
  double size_ = 0;  // largest extent across `up`
  BoxTree<2> tree_;  // of the triangles in the plane across `up`
};

/// A foot contact: an interval of frames, `first` … `last` (0-based), in which a handle keeps its
/// position and rotation.
struct FootContact {
  int first = 0, last = 0;
  Vec3 at = Vec3::Zero();            ///< position of the centroid of the handle
  Mat3 rotation = Mat3::Identity();  ///< rotation of the handle since the first frame
};

/// Options of detect_foot_contacts().
struct FootContactOptions {
  /// Largest distance between two positions of the handle centroid within a contact, model units,
  /// above 0.
  double max_spread = 0;
  /// Largest displacement of the handle centroid between consecutive frames of a contact, in model
  /// units per frame.
  double speed = std::numeric_limits<double>::infinity();
  int frames = 3;  ///< minimum number of frames of a contact, above 0
};

/// Selects the vertices with the lowest mean height along `up` over all frames, for example the
/// sole of a foot, whose trajectory shows contacts more clearly than that of the whole foot. The
/// result is ascending. `fraction`: fraction of `vertices` that is selected (at least one vertex),
/// default 0.1. Throws InputError if there are no vertices or no frames, or a vertex is out of
/// range. O(frames · vertices).
std::vector<int> lowest_vertices(const std::vector<Points>& frames,
                                 const std::vector<int>& vertices, const Vec3& up,
                                 double fraction = 0.1);

/// Detects the foot contacts in a trajectory of F frames. The contacts are sorted by frames and do
/// not overlap. The longest interval that satisfies the options is selected first (ties: earliest
/// interval), then recursively the longest intervals before and after it. The position and rotation
/// of a contact are means over its frames. Throws InputError if an option is not above 0. O(F ·
/// frames of the longest contact + F · contacts).
std::vector<FootContact> detect_foot_contacts(const Trajectory& trajectory,
                                              const FootContactOptions& options);

/// Applies a rigid motion to the position and rotation of a contact. The frames of the contact are
/// unchanged.
FootContact moved(const RigidMotion& motion, const FootContact& contact);

/// Pose of a handle on a terrain during a contact.
struct ContactPose {
  double clearance = 0;  ///< distance of the centroid from the terrain, model units
  /// True: the handle is aligned with the terrain normal, and the clearance is measured along this
  /// normal. False: the handle is not rotated, and the clearance is measured along Terrain::up().
  bool rotations = false;
};

/// Projects a contact along Terrain::up() onto the terrain. If ContactPose::rotations is set, the
/// contact is rotated by the smallest rotation from Terrain::up() to the terrain normal. Throws
/// InputError if there is no terrain above or below the contact. `name`: first words of error
/// messages.
FootContact projected(const FootContact& contact, const Terrain& terrain,
                      const ContactPose& contact_pose, const std::string& name);

/// Moves each contact by the rigid motions M_k of its frames k and averages the moved poses: the
/// new position is the mean of M_k(at), the new rotation the mean of M_k.rotation · rotation
/// (mean_rotation()). `motions`: one per frame of the sequence. Throws InputError if a contact has
/// frames outside the sequence.
std::vector<FootContact> averaged(const std::vector<FootContact>& foot_contacts,
                                  const std::vector<RigidMotion>& motions);

/// Checks the n contacts of one handle. Throws InputError if `last` is less than `first`, a frame
/// is out of range, or overlapping contacts differ in position or rotation (by more than 1e-9 of
/// the largest coordinate, or 1e-9 rad). `frames`: number of frames of the sequence. `name`: first
/// words of error messages. O(n²).
void check(const std::vector<FootContact>& foot_contacts, int frames, const std::string& name);

/// Converts contacts of one handle to keyframes, one for each frame of a contact, in ascending
/// order. In the frames of a contact, the handle is moved by the rigid motion from `from` to `to`,
/// so its motion within the contact is preserved. `from`, `to`: original and new contacts, with the
/// same frames. `frames`: number of frames of the sequence. `name`: first words of error messages.
/// Throws InputError if check() rejects `to`, or if the frames of `from` and `to` differ.
std::vector<HandleKeyframe> keyframes_of(const std::vector<FootContact>& from,
                                         const std::vector<FootContact>& to, int frames,
                                         const std::string& name);

}  // namespace batten
