// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/sequence/foot_plants.h"

#include <algorithm>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"

namespace batten {

FootTracks track_feet(const std::vector<Points>& frames, const std::vector<Handle>& handles,
                      const std::vector<int>& feet, const FootContactOptions& options) {
  FootTracks tracks;
  for (const int h : feet) {
    tracks.handles.push_back(h);
    tracks.names.push_back(handles[h].name);
    tracks.trajectories.push_back(trajectory_of(frames, handles[h].vertices));
    tracks.contacts.push_back(detect_foot_contacts(tracks.trajectories.back(), options));
  }
  return tracks;
}

double foot_skate(const Trajectory& foot, const FootContact& contact) {
  const auto rows = foot.centres.middleRows(contact.first, contact.last - contact.first + 1);
  const Eigen::RowVector3d mean = rows.colwise().mean();
  return (rows.rowwise() - mean).rowwise().norm().maxCoeff();
}

std::vector<std::vector<FootContact>> placed_contacts(const FootTracks& feet,
                                                      const ContactPlacement& placement) {
  std::vector<std::vector<FootContact>> placed = feet.contacts;
  for (size_t f = 0; f < placed.size(); ++f)
    for (FootContact& contact : placed[f]) {
      contact = moved({Mat3::Identity(), placement.translation}, contact);
      if (!placement.terrain) continue;
      const double height = contact.at.dot(placement.terrain->up()) - placement.ground;
      contact =
          projected(contact, *placement.terrain,
                    {placement.clearance.value_or(height), placement.rotations}, feet.names[f]);
    }
  return placed;
}

PrescribedMotion plant_feet(const FootTracks& feet, const std::vector<Trajectory>& moved,
                            const std::vector<std::vector<FootContact>>& to,
                            const std::vector<double>& times, const FootPlantOptions& options) {
  PrescribedMotion prescribed;
  std::vector<char> needed(times.size(), 0);
  TrajectoryOptions trajectory_options;
  trajectory_options.smoothness = options.smoothness;
  trajectory_options.times = times;
  for (size_t f = 0; f < feet.handles.size(); ++f) {
    if (feet.contacts[f].empty()) continue;
    check(to[f], isize(times), feet.names[f]);
    std::vector<HandleKeyframe> keys;
    for (size_t j = 0; j < to[f].size(); ++j) {
      const FootContact &now = feet.contacts[f][j], &then = to[f][j];
      for (int k = now.first; k <= now.last; ++k) {
        needed[k] = 1;
        const Mat3 rotation =
            then.rotation * now.rotation.transpose() * feet.trajectories[f].rotations[k];
        keys.push_back(
            {k, RigidMotion::about(moved[f].centres.row(k).transpose(),
                                   rotation * moved[f].rotations[k].transpose(), then.at)});
      }
    }
    std::sort(keys.begin(), keys.end(),
              [](const auto& a, const auto& b) { return a.frame < b.frame; });
    prescribed.handles.push_back(feet.handles[f]);
    prescribed.targets.push_back(edited(moved[f], keys, trajectory_options));
  }
  if (prescribed.handles.empty())
    throw InputError(
        "found no foot on the ground in any frame, expected a contact of at least one");
  prescribed.is_keyframe = keyframe_mask(isize(times), options.keyframe_interval, needed);
  return prescribed;
}

PrescribedMotion plant_feet_along(const FootTracks& feet, const std::vector<RigidMotion>& motions,
                                  const std::vector<double>& times,
                                  const FootPlantOptions& options) {
  std::vector<Trajectory> there;
  std::vector<std::vector<FootContact>> to;
  for (size_t f = 0; f < feet.handles.size(); ++f) {
    there.push_back(moved(motions, feet.trajectories[f]));
    to.push_back(averaged(feet.contacts[f], motions));
  }
  PrescribedMotion prescribed = plant_feet(feet, there, to, times, options);
  // The editor measures rotations from its own first frame, which has rotated with the path.
  for (Trajectory& target : prescribed.targets)
    for (Mat3& rotation : target.rotations)
      rotation = rotation * motions.front().rotation.transpose();
  return prescribed;
}

}  // namespace batten
