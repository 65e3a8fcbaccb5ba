// Foot plants: feet that stay in place while they touch the ground, also on a terrain or along
// another path.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/mesh/sequence/prescribed_motion.h"
#include "batten/mesh/sequence/trajectories/foot_contact.h"

namespace batten {

/// Feet of a sequence: handles whose contacts with the ground were detected.
struct FootTracks {
  std::vector<int> handles;        ///< index of the handle of each foot
  std::vector<std::string> names;  ///< name of each foot, for messages
  std::vector<Trajectory> trajectories;
  std::vector<std::vector<FootContact>> contacts;  ///< of each foot; empty: never on the ground
};

/// Computes the trajectories of feet and detects their contacts (detect_foot_contacts()). `feet`:
/// indices of handles. Throws InputError if an option is not above 0. O(frames · vertices).
FootTracks track_feet(const std::vector<Points>& frames, const std::vector<Handle>& handles,
                      const std::vector<int>& feet, const FootContactOptions& options);

/// Foot skate: largest distance of the centroid of a foot from its mean position during a contact,
/// model units.
double foot_skate(const Trajectory& foot, const FootContact& contact);

/// Where feet are planted.
struct ContactPlacement {
  Vec3 translation = Vec3::Zero();   ///< applied to every contact first
  const Terrain* terrain = nullptr;  ///< contacts are then projected onto it; nullptr: not at all
  /// Distance of centroids from the terrain, model units; empty: their height above the original
  /// ground is kept.
  std::optional<double> clearance;
  double ground = 0;       ///< height of the original ground, along Terrain::up()
  bool rotations = false;  ///< see ContactPose::rotations
};

/// The contacts of all feet at their new positions. Throws InputError, naming the foot, if there is
/// no terrain above or below a contact.
std::vector<std::vector<FootContact>> placed_contacts(const FootTracks& feet,
                                                      const ContactPlacement& placement);

/// Options of plant_feet() and plant_feet_along().
struct FootPlantOptions {
  /// Smoothness of the change of a trajectory between contacts.
  TrajectoryOptions::Smoothness smoothness = TrajectoryOptions::Smoothness::Smooth;
  int keyframe_interval = 1;  ///< see keyframe_mask(); both ends of contacts are keyframes too
};

/// Plants feet: in each frame of contact j of foot f, the centroid is exactly to[f][j].at. The foot
/// is rotated by the change of rotation from its original contact to to[f][j]. Between contacts the
/// change blends smoothly (edited()). Feet without contacts are not prescribed.
///
/// `moved`: trajectories of the feet at the start of the edit; feet.trajectories, if the frames are
/// the original ones. `to`: one contact for each of feet.contacts. `times`: of the frames. Throws
/// InputError: no foot has a contact; contacts that check() rejects, naming the foot. O(feet ·
/// frames).
PrescribedMotion plant_feet(const FootTracks& feet, const std::vector<Trajectory>& moved,
                            const std::vector<std::vector<FootContact>>& to,
                            const std::vector<double>& times, const FootPlantOptions& options = {});

/// Plants feet in a sequence whose frames were moved rigidly, such as by path_motions(): every foot
/// stays at the mean of the positions to which the motions move its contact (averaged()). The result
/// is for an editor of the moved frames. `motions`: one per frame. Throws InputError like
/// plant_feet().
PrescribedMotion plant_feet_along(const FootTracks& feet, const std::vector<RigidMotion>& motions,
                                  const std::vector<double>& times,
                                  const FootPlantOptions& options = {});

}  // namespace batten
