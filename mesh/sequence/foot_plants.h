// SPDX-License-Identifier: MPL-2.0
// Foot plants: motions in which feet keep their positions while they touch the ground, also on a
// terrain or along another path.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/mesh/sequence/prescribed_motion.h"
#include "batten/mesh/sequence/trajectories/foot_contact.h"

namespace batten {

/// Feet of a sequence: handles with their trajectories and their contacts with the ground.
struct FootTracks {
  std::vector<int> handles;        ///< index of the handle of each foot
  std::vector<std::string> names;  ///< name of each foot, for messages
  std::vector<Trajectory> trajectories;
  /// Contacts of each foot; the list of a foot that never touches the ground is empty.
  std::vector<std::vector<FootContact>> contacts;
};

/// Computes the trajectories of feet and detects their contacts (detect_foot_contacts()). `feet`:
/// indices into `handles`. Throws InputError if an option is not above 0. O(frames · vertices).
FootTracks track_feet(const std::vector<Points>& frames, const std::vector<Handle>& handles,
                      const std::vector<int>& feet, const FootContactOptions& options);

/// Foot skate: largest distance of the centroid of a foot from the mean position of the centroid
/// during a contact, model units.
double foot_skate(const Trajectory& foot, const FootContact& contact);

/// Options of placed_contacts(): how the ground contacts of feet are moved before the feet are
/// planted.
struct ContactPlacement {
  Vec3 translation = Vec3::Zero();  ///< translation of every contact, applied before the projection
  /// Terrain onto which the translated contacts are projected; nullptr: no projection.
  const Terrain* terrain = nullptr;
  /// Distance of the foot centroids from the terrain, model units; empty: each centroid keeps its
  /// height above the original ground.
  std::optional<double> clearance;
  double ground = 0;       ///< height of the original ground along Terrain::up()
  bool rotations = false;  ///< true: feet are aligned with the terrain, see ContactPose::rotations
};

/// Moves the ground contacts of all feet as specified by `placement`, and returns the new contacts
/// of each foot. Throws InputError if there is no terrain above or below a contact; the message
/// names the foot.
std::vector<std::vector<FootContact>> placed_contacts(const FootTracks& feet,
                                                      const ContactPlacement& placement);

/// Options of plant_feet() and plant_feet_along().
struct FootPlantOptions {
  /// Smoothness of the trajectory changes between contacts.
  TrajectoryOptions::Smoothness smoothness = TrajectoryOptions::Smoothness::Smooth;
  /// Every n-th frame is a keyframe (see keyframe_mask()), in addition to the first and last frame
  /// of each contact.
  int keyframe_interval = 1;
};

/// Plants feet: in each frame of contact j of foot f, the centroid of the foot is exactly at
/// to[f][j].at. The foot is rotated by the change of rotation from the original contact to
/// to[f][j]. Between contacts, edited() interpolates the change of the trajectory. Feet without
/// contacts are not prescribed.
///
/// `moved`: trajectories of the feet in the sequence to be edited; these are feet.trajectories if
/// the original sequence is edited. `to`: new contacts, one for each contact in feet.contacts.
/// `times`: one per frame. Throws InputError if no foot has a contact, or if check() rejects the
/// contacts of a foot; the message names the foot. O(feet · frames).
PrescribedMotion plant_feet(const FootTracks& feet, const std::vector<Trajectory>& moved,
                            const std::vector<std::vector<FootContact>>& to,
                            const std::vector<double>& times, const FootPlantOptions& options = {});

/// Plants feet in a sequence whose frames were moved rigidly, for example by path_motions(). During
/// a contact, a foot is planted at the mean of the positions to which the motions move the contact;
/// see averaged(). Use the result with an editor of the moved frames. `motions`: one per frame.
/// Throws InputError like plant_feet().
PrescribedMotion plant_feet_along(const FootTracks& feet, const std::vector<RigidMotion>& motions,
                                  const std::vector<double>& times,
                                  const FootPlantOptions& options = {});

}  // namespace batten
