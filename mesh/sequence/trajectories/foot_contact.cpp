// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/sequence/trajectories/foot_contact.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {
namespace {

/// For messages: "frames 3-8", 1-based.
std::string frames_of(const FootContact& f) {
  return "frames " + std::to_string(f.first + 1) + "-" + std::to_string(f.last + 1);
}

Mat3 mean(const std::vector<Mat3>& rotations) {
  return mean_rotation(rotations, std::vector<double>(rotations.size(), 1.0));
}

/// For each first frame, the last frame of an interval that still counts as one contact.
std::vector<int> last_frames_of_contact(const Points& c, const FootContactOptions& options) {
  const int n = static_cast<int>(c.rows());
  std::vector<int> last(n);
  for (int first = 0, end = 0; first < n; ++first) {
    end = std::max(end, first);
    for (; end + 1 < n && (c.row(end + 1) - c.row(end)).norm() <= options.speed; ++end) {
      bool near = true;
      for (int k = first; k <= end && near; ++k)
        near = (c.row(end + 1) - c.row(k)).norm() <= options.max_spread;
      if (!near) break;
    }
    last[first] = end;
  }
  return last;
}

FootContact mean_contact(const Trajectory& t, int first, int last) {
  FootContact f{first, last, t.centres.middleRows(first, last - first + 1).colwise().mean(), {}};
  f.rotation = mean({t.rotations.begin() + first, t.rotations.begin() + last + 1});
  return f;
}

}  // namespace

std::vector<int> lowest_vertices(const std::vector<Points>& frames,
                                 const std::vector<int>& vertices, const Vec3& up,
                                 double fraction) {
  if (vertices.empty() || frames.empty())
    throw InputError("lowest vertices: found no vertices or no frames, expected one or more");
  std::vector<double> height(vertices.size(), 0);
  for (size_t k = 0; k < frames.size(); ++k)
    for (size_t i = 0; i < vertices.size(); ++i) {
      if (vertices[i] < 0 || vertices[i] >= frames[k].rows())
        throw InputError("frame " + std::to_string(k + 1) + " has no vertex " +
                         std::to_string(vertices[i] + 1));
      height[i] += frames[k].row(vertices[i]).dot(up);
    }
  std::vector<size_t> order(vertices.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return height[a] < height[b]; });
  const double count = std::ceil(fraction * static_cast<double>(vertices.size()) - 1e-9);
  order.resize(
      static_cast<size_t>(std::clamp<double>(count, 1, static_cast<double>(order.size()))));
  std::vector<int> lowest;
  for (const size_t i : order) lowest.push_back(vertices[i]);
  std::sort(lowest.begin(), lowest.end());
  return lowest;
}

std::vector<FootContact> detect_foot_contacts(const Trajectory& trajectory,
                                              const FootContactOptions& options) {
  if (!(options.max_spread > 0) || !(options.speed > 0) || options.frames < 1)
    throw InputError("contact_detection: distance, speed and min_frames must be above 0");
  const std::vector<int> last = last_frames_of_contact(trajectory.centres, options);
  std::vector<FootContact> found;
  std::vector<std::pair<int, int>> open = {{0, trajectory.frame_count() - 1}};
  while (!open.empty()) {
    const auto [from, to] = open.back();
    open.pop_back();
    int first = from, longest = 0;
    for (int k = from; k <= to; ++k)
      if (const int length = std::min(last[k], to) - k + 1; length > longest) {
        first = k;
        longest = length;
      }
    if (longest < options.frames) continue;
    found.push_back(mean_contact(trajectory, first, first + longest - 1));
    open.push_back({from, first - 1});
    open.push_back({first + longest, to});
  }
  std::sort(found.begin(), found.end(),
            [](const FootContact& a, const FootContact& b) { return a.first < b.first; });
  return found;
}

FootContact moved(const RigidMotion& motion, const FootContact& contact) {
  FootContact result = contact;
  result.at = motion(contact.at);
  result.rotation = motion.rotation * contact.rotation;
  return result;
}

FootContact projected(const FootContact& contact, const Terrain& terrain,
                      const ContactPose& contact_pose, const std::string& name) {
  const std::optional<Terrain::SurfacePoint> surface_point = terrain.surface_point(contact.at);
  if (!surface_point)
    throw InputError(name + ": the foot plant in " + frames_of(contact) +
                     " has no terrain above or below it");
  FootContact result = contact;
  const Vec3 direction = contact_pose.rotations ? surface_point->normal : terrain.up();
  result.at = surface_point->at + contact_pose.clearance * direction;
  result.rotation = Eigen::Quaterniond::FromTwoVectors(terrain.up(), direction) * contact.rotation;
  return result;
}

std::vector<FootContact> averaged(const std::vector<FootContact>& foot_contacts,
                                  const std::vector<RigidMotion>& motions) {
  std::vector<FootContact> result;
  for (const FootContact& f : foot_contacts) {
    check({f}, isize(motions), "averaged");
    Vec3 at = Vec3::Zero();
    std::vector<Mat3> rotations;
    for (int k = f.first; k <= f.last; ++k) {
      at += motions[k](f.at) / (f.last - f.first + 1);
      rotations.push_back(motions[k].rotation);
    }
    result.push_back({f.first, f.last, at, mean(rotations) * f.rotation});
  }
  return result;
}

void check(const std::vector<FootContact>& foot_contacts, int frames, const std::string& name) {
  double size = 0;
  for (const FootContact& f : foot_contacts) {
    if (f.last < f.first)
      throw InputError(name + ": the foot plant in " + frames_of(f) + " ends before it starts");
    if (f.first < 0 || f.last >= frames)
      throw InputError(name + ": the foot plant in " + frames_of(f) + " is outside of frames 1-" +
                       std::to_string(frames));
    size = std::max(size, f.at.cwiseAbs().maxCoeff());
  }
  for (size_t i = 0; i < foot_contacts.size(); ++i)
    for (size_t j = 0; j < i; ++j) {
      const FootContact &a = foot_contacts[j], &b = foot_contacts[i];
      if (a.last < b.first || b.last < a.first) continue;
      const double apart = (a.at - b.at).norm();
      const std::string overlap =
          name + ": the foot plants in " + frames_of(a) + " and " + frames_of(b) + " overlap ";
      if (apart > 1e-9 * size)
        throw InputError(overlap + "at positions that are " + format_number(apart) + " apart");
      if ((a.rotation - b.rotation).norm() > 1e-9)
        throw InputError(overlap + "with different rotations");
    }
}

std::vector<HandleKeyframe> keyframes_of(const std::vector<FootContact>& from,
                                         const std::vector<FootContact>& to, int frames,
                                         const std::string& name) {
  check(to, frames, name);
  if (from.size() != to.size())
    throw InputError(name + ": found " + std::to_string(to.size()) +
                     " foot plants after an edit, expected " + std::to_string(from.size()) +
                     " as before it");
  std::map<int, RigidMotion> motions;
  for (size_t i = 0; i < to.size(); ++i) {
    const FootContact &a = from[i], &b = to[i];
    if (a.first != b.first || a.last != b.last)
      throw InputError(name + ": found a foot plant in " + frames_of(b) + ", expected it in " +
                       frames_of(a) + " as before the edit");
    for (int k = b.first; k <= b.last; ++k)
      motions.emplace(k, RigidMotion::about(a.at, b.rotation * a.rotation.transpose(), b.at));
  }
  std::vector<HandleKeyframe> keyframes;
  for (const auto& [frame, motion] : motions) keyframes.push_back({frame, motion});
  return keyframes;
}

namespace {

Vec3 unit_up(const Vec3& up) {
  if (!(up.norm() > 0) || !up.allFinite())
    throw InputError("terrain: the up direction has length 0 or is not finite");
  return up.normalized();
}

}  // namespace

Terrain::Terrain(TriangleMesh mesh, const Vec3& up) : mesh_(std::move(mesh)), up_(unit_up(up)) {
  across_[0] = up_.unitOrthogonal();
  across_[1] = up_.cross(across_[0]);
  const MeshTopology& topology = mesh_.topology();
  normals_ = Points::Zero(topology.node_count(), 3);
  std::vector<Box2> boxes;
  Box2 box;
  bool seen = false;
  for (int t = 0; t < mesh_.triangle_count(); ++t) {
    const Vec3 area = mesh_.area_vector(t);
    seen = seen || area.dot(up_) != 0;
    Box2& around = boxes.emplace_back();
    for (const int v : mesh_.triangles()[t]) {
      normals_.row(topology.node_of(v)) += (area.dot(up_) < 0 ? -1 : 1) * area.transpose();
      around.extend(to_plane(mesh_.point(v)));
    }
    box.extend(around);
  }
  if (!seen) throw InputError("terrain: no triangle is visible from above");
  size_ = box.sizes().maxCoeff();
  tree_ = BoxTree<2>(boxes);
}

std::optional<Terrain::SurfacePoint> Terrain::surface_point(const Vec3& p) const {
  const Vec2 q = to_plane(p);
  // Tolerance on barycentric coordinates, so that no line passes between two triangles.
  constexpr double hair = 1e-12;
  std::vector<int> near;
  tree_.for_each_near(Box2(q), 10 * hair * size_, [&](int t) { near.push_back(t); });
  std::sort(near.begin(), near.end());  // of equally high points, that of the first triangle
  std::optional<SurfacePoint> highest;
  for (const int t : near) {
    const std::array<int, 3>& corners = mesh_.triangles()[t];
    Vec2 corner[3];
    for (int j = 0; j < 3; ++j) corner[j] = to_plane(mesh_.point(corners[j])) - q;
    Vec3 L(cross(corner[1], corner[2]), cross(corner[2], corner[0]), cross(corner[0], corner[1]));
    if (L.sum() == 0) continue;
    L /= L.sum();
    if (!(L.minCoeff() >= -hair)) continue;
    Vec3 at = Vec3::Zero(), normal = Vec3::Zero();
    for (int j = 0; j < 3; ++j) {
      at += L[j] * mesh_.point(corners[j]);
      normal += L[j] * normals_.row(mesh_.topology().node_of(corners[j])).transpose().normalized();
    }
    if (!highest || at.dot(up_) > highest->at.dot(up_))
      highest = SurfacePoint{at, normal.normalized()};
  }
  return highest;
}

}  // namespace batten
