// SPDX-License-Identifier: MPL-2.0
// Handles with prescribed trajectories: foot plants, motion of other sequences, measures of frames.
#include "batten/mesh/sequence/prescribed_motion.h"

#include <algorithm>

#include "batten/mesh/sequence/foot_plants.h"
#include "batten/mesh/sequence/mesh_sequence.h"
#include "batten/mesh/sequence/morph.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/reference_frame_solver.h"

using namespace batten;
using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

/// A bar whose left end rests in frames 3 to 8, except for jitter, and moves in the others.
struct SlidingBar {
  SlidingBar()
      : mesh(bar(10, 2, 3, 0.6)),
        handles{{"foot", nodes_where(mesh.points(), [](const Vec3& x) { return x.x() < 0.01; })},
                {"head", nodes_where(mesh.points(), [](const Vec3& x) { return x.x() > 2.99; })}} {
    for (int k = 0; k < 14; ++k) {
      const double resting = std::clamp(k, 3, 8);
      const Vec3 shift(0.4 * (k - resting) + 0.01 * std::sin(2.0 * k), 0,
                       0.05 * std::abs(k - resting));
      sequence.frames.push_back(
          moved(RigidMotion{rotation_matrix(Vec3(0, 0.01 * k, 0)), shift}, mesh.points()));
      sequence.times.push_back(k);
    }
    for (const auto& t : mesh.triangles()) sequence.shells.add_face(t);
    sequence.shells.points = sequence.frames.front();
    mesh = mesh.with_points(sequence.frames.front());
  }
  FootTracks feet() const {
    FootContactOptions options;
    options.max_spread = 0.1;
    return track_feet(sequence.frames, handles, {0}, options);
  }
  TriangleMesh mesh;
  std::vector<Handle> handles;
  MeshSequence sequence;
};

/// A square of the plane z = height, from -10 to 10.
TriangleMesh level_ground(double height) {
  Points p(4, 3);
  p << -10, -10, height, 10, -10, height, 10, 10, height, -10, 10, height;
  return {p, {{0, 1, 2}, {0, 2, 3}}};
}

std::string marks(const std::vector<char>& mask) {
  std::string text;
  for (const char c : mask) text += c ? 'x' : '.';
  return text;
}

}  // namespace

TEST_CASE("keyframes are every n-th frame and both ends of what is needed", "[mesh][sequences]") {
  CHECK(marks(keyframe_mask(7, 3)) == "x..x..x");
  CHECK(marks(keyframe_mask(6, 4)) == "x...xx");
  CHECK(marks(keyframe_mask(8, 100, {0, 0, 1, 1, 1, 0, 1, 0})) == "x.x.x.xx");
  CHECK(keyframe_mask(0, 3).empty());
}

TEST_CASE("planted feet do not slide, and nothing else changes a foot at rest",
          "[mesh][sequences]") {
  const SlidingBar given;
  const FootTracks feet = given.feet();
  REQUIRE(feet.contacts[0].size() == 1);
  const FootContact contact = feet.contacts[0][0];
  CHECK(contact.first <= 3);
  CHECK(contact.last >= 8);
  CHECK(foot_skate(feet.trajectories[0], contact) > 0.005);
  FootPlantOptions options;
  options.keyframe_interval = 5;
  const PrescribedMotion plan =
      plant_feet(feet, feet.trajectories, feet.contacts, given.sequence.times, options);
  CHECK(plan.handles == std::vector<int>{0});
  CHECK(plan.is_keyframe[contact.first]);
  CHECK(plan.is_keyframe[contact.last]);
  for (int k = contact.first; k <= contact.last; ++k)
    CHECK((plan.targets[0].centres.row(k).transpose() - contact.at).norm() < 1e-13);
  FrameConstraints constraints;
  constraints.handles = given.handles;
  const auto editor = prescribed_motion_editor(given.sequence, given.mesh, constraints, plan);
  FrameMeasures measures(given.mesh, {{given.handles[0].vertices, contact.first, contact.last}});
  const std::vector<Points> after = editor->frames();
  for (int k = 0; k < given.sequence.frame_count(); ++k) measures.add(k, after[k]);
  CHECK(measures.foot_skate(0) < 1e-12);
  CHECK(measures.inverted_triangles() == 0);
}

TEST_CASE("feet are planted on a terrain at their height or at a clearance", "[mesh][sequences]") {
  const SlidingBar given;
  const FootTracks feet = given.feet();
  const Terrain terrain(level_ground(0.7));
  ContactPlacement placement;
  placement.translation = Vec3(0.2, -0.1, 0.3);
  const Vec3 shifted = feet.contacts[0][0].at + placement.translation;
  CHECK((placed_contacts(feet, placement)[0][0].at - shifted).norm() < 1e-15);
  placement.terrain = &terrain;
  placement.ground = 0.1;
  CHECK((placed_contacts(feet, placement)[0][0].at -
         Vec3(shifted.x(), shifted.y(), 0.7 + shifted.z() - 0.1))
            .norm() < 1e-14);
  placement.clearance = 0.25;
  CHECK((placed_contacts(feet, placement)[0][0].at - Vec3(shifted.x(), shifted.y(), 0.95)).norm() <
        1e-14);
  placement.translation.x() = 100;
  CHECK_THAT(error_message([&] { placed_contacts(feet, placement); }), Contains("foot: "));
}

TEST_CASE("along a path that does not move the frames, feet are planted as on the spot",
          "[mesh][sequences]") {
  const SlidingBar given;
  const FootTracks feet = given.feet();
  const std::vector<RigidMotion> still(given.sequence.frame_count());
  const auto times = given.sequence.times;
  const PrescribedMotion along = plant_feet_along(feet, still, times),
                         spot = plant_feet(feet, feet.trajectories, feet.contacts, times);
  CHECK(distance(along.targets[0], spot.targets[0]) < 1e-13);
  // The same motion in all frames moves the foot plants by it.
  Random random(5);
  const RigidMotion motion = random_motion(random);
  const PrescribedMotion there =
      plant_feet_along(feet, std::vector(given.sequence.frames.size(), motion), times);
  CHECK(distance(there.targets[0].centres, moved(motion, spot.targets[0].centres)) < 1e-12);
  FootTracks none = feet;
  none.contacts[0].clear();
  CHECK_THAT(error_message([&] { plant_feet_along(none, still, times); }),
             Contains("no foot on the ground"));
}

TEST_CASE("handles that do not rotate follow the mean of the others", "[mesh][sequences]") {
  const SlidingBar given;
  const auto& frames = given.sequence.frames;
  PrescribedMotion plan;
  plan.handles = {0};
  plan.targets = {trajectory_of(frames, given.handles[0].vertices)};
  plan.targets[0].centres.rowwise() += Eigen::RowVector3d(0, 1, 2);
  const Points shifts = mean_shift(frames, given.handles, plan);
  CHECK((shifts.rowwise() - Eigen::RowVector3d(0, 1, 2)).norm() < 1e-13);
  add_unrotated_handles(frames, given.handles, {1}, shifts, plan);
  const Trajectory head = trajectory_of(frames, given.handles[1].vertices);
  CHECK(plan.handles == std::vector<int>{0, 1});
  CHECK(distance(plan.targets[1].rotations, head.rotations) == 0);
  CHECK(distance(plan.targets[1].centres, head.centres + shifts) < 1e-15);
  CHECK_THAT(
      error_message([&] { add_unrotated_handles(frames, given.handles, {0}, shifts, plan); }),
      Contains("'foot' has a prescribed motion already"));
}

TEST_CASE("a prescribed motion that changes nothing changes nothing", "[mesh][sequences]") {
  const SlidingBar given;
  PrescribedMotion plan;
  for (int h = 0; h < 2; ++h) {
    plan.handles.push_back(1 - h);
    plan.targets.push_back(trajectory_of(given.sequence.frames, given.handles[1 - h].vertices));
  }
  plan.is_keyframe = keyframe_mask(given.sequence.frame_count(), 6);
  FrameConstraints constraints;
  constraints.handles = given.handles;
  const auto editor = prescribed_motion_editor(given.sequence, given.mesh, constraints, plan);
  const std::vector<Points> after = editor->frames();
  for (size_t k = 0; k < after.size(); ++k)
    CHECK(distance(after[k], given.sequence.frames[k]) < 1e-12);
  plan.handles[0] = 7;
  CHECK_THAT(error_message(
                 [&] { prescribed_motion_editor(given.sequence, given.mesh, constraints, plan); }),
             Contains("handle 7"));
}

TEST_CASE("motion transferred from a similar image is the motion itself", "[mesh][sequences]") {
  std::vector<Trajectory> own;
  for (unsigned seed = 1; seed <= 2; ++seed)
    own.push_back({smooth_path(20, seed), smooth_rotations(20, seed)});
  Similarity image;
  image.R = rotation_matrix(Vec3(0, 0, 1.1));
  image.scale = 2.5;
  image.translation = Vec3(3, -1, 4);
  std::vector<Trajectory> similar, shifted;
  for (const Trajectory& t : own) {
    similar.push_back(aligned(t, image));
    shifted.push_back(t);
    shifted.back().centres.rowwise() += Eigen::RowVector3d(1, 2 + shifted.size(), 3);
  }
  using Align = MotionTransferOptions::Align;
  for (const Align align : {Align::All, Align::Each}) {
    const auto found = transferred(similar, own, {align, Vec3::UnitZ(), true});
    for (size_t p = 0; p < own.size(); ++p) CHECK(distance(found[p], own[p]) < 1e-10);
  }
  const auto found = transferred(shifted, own, {Align::Shift, {}, false});
  for (size_t p = 0; p < own.size(); ++p) CHECK(distance(found[p], own[p]) < 1e-12);
  CHECK_THAT(error_message([&] { transferred({}, own); }), Contains("0 trajectories for 2"));
}

TEST_CASE("the root of a sequence is the mean of its nodes", "[mesh][sequences]") {
  const SlidingBar given;
  const Trajectory root = root_trajectory(given.sequence.frames);
  CHECK(root.frame_count() == given.sequence.frame_count());
  for (int k = 0; k < root.frame_count(); ++k) {
    CHECK((root.centres.row(k) - given.sequence.frames[k].colwise().mean()).norm() < 1e-15);
    CHECK(root.rotations[k] == Mat3::Identity());
  }
}

TEST_CASE("uniform motion has no second difference, and a pushed node inverts triangles",
          "[mesh][sequences]") {
  const TriangleMesh mesh = flat_square(6, 0, 1);
  FrameMeasures uniform(mesh), pushed(mesh), feet(mesh, {{{0}, 1, 2}, {{1}, 7, 9}});
  for (int k = 0; k < 5; ++k) {
    Points p = mesh.points();
    p.rowwise() += Eigen::RowVector3d(0.5 * k, 0, 0);
    uniform.add(k, p);
    feet.add(k, p);
    if (k == 2) p.row(3 * 7 + 3) += Eigen::RowVector3d(0.3, 0, 0);  // beyond its neighbour
    pushed.add(k, p);
  }
  CHECK(uniform.max_second_difference() < 1e-15);
  CHECK(uniform.inverted_triangles() == 0);
  CHECK(std::abs(pushed.max_second_difference() - 0.6) < 1e-14);
  CHECK(pushed.inverted_triangles() > 0);
  CHECK(std::abs(feet.foot_skate(0) - 0.25) < 1e-15);
  CHECK(feet.foot_skate(1) == 0);
}

TEST_CASE("a target with other faces gets the faces of the source", "[mesh][sequences]") {
  const SlidingBar given;
  MeshSequence target;
  const TriangleMesh finer = bar(14, 3, 3, 0.6);
  for (const auto& [a, b, c] : finer.triangles())
    target.shells.add_face(std::array{c, b, a});  // turned inside out
  const RigidMotion motion{rotation_matrix(Vec3(0.1, 0, 0.4)), Vec3(5, 0, 1)};
  target.frames = {moved(motion, finer.points()), finer.points()};
  target.times = {0, 1};
  target.shells.points = target.frames.front();
  std::vector<MorphLandmark> landmarks;
  for (const double x : {0.0, 3.0})
    for (const double y : {-0.3, 0.3})
      for (const double z : {-0.3, 0.3}) landmarks.push_back({{x, y, z}, motion(Vec3(x, y, z))});
  MeshSequence source = given.sequence;
  const TriangleMesh rest = bar(10, 2, 3, 0.6);
  source.frames[0] = rest.points();
  const RegisteredTarget found = registered_target(source, given.mesh, 0, target, 0, landmarks);
  const double size = found.target_size;
  CHECK(std::abs(size - Vec3(3, 0.6, 0.6).norm()) < size);
  CHECK(found.fit.mean_distance < 1e-3 * size);
  CHECK(found.fit.landmark_distance < 1e-3 * size);
  CHECK(found.fit.inverted == 0);
  CHECK(found.sequence.shells.face_count() == source.shells.face_count());
  REQUIRE(found.sequence.frame_count() == 2);
  // The fitted mesh follows the rigid motion of the target.
  CHECK(distance(moved(motion, found.sequence.frames[1]), found.sequence.frames[0]) < 1e-10 * size);
  CHECK_THAT(
      error_message([&] { registered_target(source, given.mesh, 99, target, 0, landmarks); }),
      Contains("frame 100"));
}
