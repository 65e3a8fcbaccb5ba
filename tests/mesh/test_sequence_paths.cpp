// SPDX-License-Identifier: MPL-2.0
// Foot plants, terrain and paths on the ground: properties of mesh/sequence.
#include <cmath>
#include <numbers>

#include "batten/mesh/sequence/trajectories/foot_contact.h"
#include "batten/mesh/sequence/trajectories/ground_path.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/random_motion.h"
#include "batten/tests/support/sample_meshes.h"

using namespace batten;
using namespace batten_test;

namespace {

using std::numbers::pi;

/// Frames of steps: at rest in [5, 14], [25, 31], [40, 49] with noise of at most `noise`, otherwise
/// moving.
Trajectory steps(double noise) {
  Random random(21);
  Trajectory t{Points(50, 3), std::vector<Mat3>(50, Mat3::Identity())};
  double x = 0;
  for (int k = 0; k < 50; ++k) {
    const bool still = (k > 5 && k <= 14) || (k > 25 && k <= 31) || (k > 40);
    if (!still) x += 0.3;
    t.centres.row(k) = Vec3(x, 0, 0) + noise / std::sqrt(3.0) * random.point();
  }
  return t;
}

/// Centroids along a curve on the ground, with lateral sway and vertical bob.
Points walk(int frames, const RigidMotion& world = {}) {
  Points p(frames, 3);
  for (int k = 0; k < frames; ++k) {
    const double t = k / (frames - 1.0);
    p.row(k) = world(
        Vec3(8 * t, 2 * std::sin(2 * t) + 0.05 * std::sin(1.3 * k), 1 + 0.1 * std::cos(1.1 * k)));
  }
  return p;
}

Points straight_walk(int frames, const Vec3& step) {
  Points p(frames, 3);
  for (int k = 0; k < frames; ++k) p.row(k) = Vec3(3, -2, 1) + (k + 0.4 * std::sin(0.5 * k)) * step;
  return p;
}

}  // namespace

TEST_CASE("foot plants are the intervals in which a handle stays at rest", "[mesh][sequences]") {
  for (const double noise : {0.0, 0.01}) {
    FootContactOptions options;
    options.max_spread = 0.021;
    const std::vector<FootContact> found = detect_foot_contacts(steps(noise), options);
    REQUIRE(found.size() == 3);
    const int first[] = {5, 25, 40}, last[] = {14, 31, 49};
    for (int i = 0; i < 3; ++i) {
      CHECK(found[i].first == first[i]);
      CHECK(found[i].last == last[i]);
      CHECK((found[i].at - steps(0).centres.row(first[i]).transpose()).norm() <= noise + 1e-14);
      CHECK((found[i].rotation - Mat3::Identity()).norm() < 1e-14);
    }
    options.frames = 8;
    CHECK(detect_foot_contacts(steps(noise), options).size() == 2);
    options.max_spread = 100;
    CHECK(detect_foot_contacts(steps(noise), options).size() == 1);
    options.speed = 0.1;
    CHECK(detect_foot_contacts(steps(noise), options).size() == 2);
  }
  // The centroids of a foot plant stay within the distance, however slowly it slides.
  Trajectory slow{straight_walk(60, Vec3(0.01, 0, 0)), std::vector<Mat3>(60, Mat3::Identity())};
  FootContactOptions options;
  options.max_spread = 0.05;
  int last = -1;
  for (const FootContact& f : detect_foot_contacts(slow, options)) {
    CHECK(f.first > last);
    last = f.last;
    for (int k = f.first; k <= f.last; ++k)
      CHECK((slow.centres.row(k) - slow.centres.row(f.first)).norm() <= 0.05);
  }
  CHECK(last > 0);
  CHECK(!error_message([&] { detect_foot_contacts(slow, {}); }).empty());
}

TEST_CASE("the lowest vertices of a handle are its sole in the mean", "[mesh][sequences]") {
  Points low(5, 3), high(5, 3);
  low << 0, 0, 3, 0, 0, 1, 0, 0, 5, 0, 0, 2, 0, 0, 0;
  high = low.array() + 1;
  high(4, 2) = 100;
  CHECK(lowest_vertices({low}, {0, 1, 2, 3, 4}, Vec3::UnitZ(), 0.4) == std::vector<int>{1, 4});
  CHECK(lowest_vertices({low, high}, {0, 1, 2, 3, 4}, Vec3::UnitZ(), 0.4) ==
        std::vector<int>{1, 3});
  CHECK(lowest_vertices({low}, {0, 2}, -Vec3::UnitZ(), 0.01) == std::vector<int>{2});
  CHECK(!error_message([&] { lowest_vertices({low}, {5}, Vec3::UnitZ()); }).empty());
}

TEST_CASE("all frames of a moved foot plant become keyframes that move the same way",
          "[mesh][sequences]") {
  Random random(22);
  Trajectory t = steps(0.01);
  t.rotations.assign(50, random_rotation_matrix(random));
  FootContactOptions options;
  options.max_spread = 0.021;
  const std::vector<FootContact> before = detect_foot_contacts(t, options);
  std::vector<FootContact> after = before;
  std::vector<RigidMotion> motions;
  for (FootContact& f : after) {
    motions.push_back(random_motion(random));
    f = moved(motions.back(), f);
  }
  const std::vector<HandleKeyframe> keyframes = keyframes_of(before, after, 50, "foot");
  CHECK(keyframes.size() == 27);
  const Trajectory found = edited(t, keyframes);
  for (int i = 0; i < 3; ++i)
    for (int k = before[i].first; k <= before[i].last; ++k)
      CHECK((found.centres.row(k).transpose() - motions[i](t.centres.row(k).transpose())).norm() <
            1e-13);
  CHECK(distance(edited(t, keyframes_of(before, before, 50, "foot")), t) < 1e-14);
}

TEST_CASE("invalid foot plants are refused by name and frames", "[mesh][sequences]") {
  const Vec3 a(1, 2, 3), b(1, 2, 3.5);
  const auto message = [](const std::vector<FootContact>& all) {
    return error_message([&] { check(all, 10, "left foot"); });
  };
  CHECK(message({{2, 5, a}, {6, 9, b}}).empty());
  CHECK(message({{2, 6, a}, {5, 9, a}}).empty());
  CHECK(
      message({{2, 6, a}, {6, 9, b}}) ==
      "left foot: the foot plants in frames 3-7 and frames 7-10 overlap at positions that are 0.5 "
      "apart");
  CHECK(message({{2, 6, a}, {6, 10, a}}) ==
        "left foot: the foot plant in frames 7-11 is outside of frames 1-10");
  CHECK(message({{6, 2, a}}) == "left foot: the foot plant in frames 7-3 ends before it starts");
  CHECK(message({{2, 6, a}, {6, 9, a, rotation_matrix(Vec3(0, 0, 0.1))}})
            .find("different rotations") != std::string::npos);
  CHECK(!error_message([&] { keyframes_of({{2, 5, a}}, {{2, 6, a}}, 10, "left foot"); }).empty());
}

TEST_CASE("the height of a terrain is that of the highest triangle on a vertical line",
          "[mesh][sequences]") {
  Random random(23);
  const TriangleMesh low = sheet(12), shell = sphere(2);
  Points lifted = shell.points() * 0.8;
  lifted.rowwise() += Eigen::RowVector3d(2, 2, 1);
  const TriangleMesh both = disjoint_union(low, shell.with_points(lifted));
  const RigidMotion world = random_motion(random);
  const Vec3 up = world.rotation.col(2);
  const Terrain terrain(both.with_points(moved(world, both.points())), 2 * up);
  for (int i = 0; i < 300; ++i) {
    const Vec3 p(random.between(-0.2, 4.2), random.between(-0.2, 4.2), 3 * random());
    // Brute force over all triangles, with the plane of each.
    std::optional<double> height;
    for (int t = 0; t < both.triangle_count(); ++t) {
      const auto& [a, b, c] = both.triangles()[t];
      Mat3 M;
      M << both.point(a), both.point(b), both.point(c);
      Mat3 flat = M;
      flat.row(2).setOnes();
      const Vec3 L = flat.inverse() * Vec3(p.x(), p.y(), 1);
      if (L.minCoeff() > 0 && (!height || M.row(2) * L > *height)) height = M.row(2) * L;
    }
    const auto found = terrain.surface_point(world(p));
    CHECK(found.has_value() == height.has_value());
    if (!found || !height) continue;
    CHECK((found->at - world(Vec3(p.x(), p.y(), *height))).norm() < 1e-12);
    CHECK(found->normal.dot(up) > 0);
  }
  CHECK(!error_message([&] { Terrain(low, Vec3::Zero()); }).empty());
}

TEST_CASE("normals of a terrain come near to those of the surface, whichever way its triangles run",
          "[mesh][sequences]") {
  const TriangleMesh shell = sphere(4);
  auto turned_over = shell.triangles();
  for (auto& t : turned_over) std::swap(t[0], t[1]);
  const Terrain terrain(shell), other(TriangleMesh(shell.points(), turned_over));
  Random random(24);
  for (int i = 0; i < 100; ++i) {
    const Vec3 p(0.6 * random(), 0.6 * random(), random());
    const auto found = terrain.surface_point(p);
    REQUIRE(found);
    CHECK((found->normal - found->at.normalized()).norm() < 8e-3);
    CHECK((found->normal - other.surface_point(p)->normal).norm() < 1e-14);
  }
}

TEST_CASE("foot plants stand on a terrain unrotated or along its normal", "[mesh][sequences]") {
  // A slope z = 0.5 x + 0.1 y + 1.
  Points p(4, 3);
  p << -5, -5, -2, 5, -5, 3, 5, 5, 4, -5, 5, -1;
  const Terrain slope(TriangleMesh(p, {{0, 1, 2}, {0, 2, 3}}));
  const Vec3 normal = Vec3(-0.5, -0.1, 1).normalized();
  const FootContact f{3, 8, Vec3(1, 2, 7), rotation_matrix(Vec3(0.1, 0.2, 0.3))};
  const FootContact upright = projected(f, slope, {0.3, false}, "foot");
  CHECK((upright.at - Vec3(1, 2, 1.7 + 0.3)).norm() < 1e-14);
  CHECK((upright.rotation - f.rotation).norm() < 1e-15);
  const FootContact turned = projected(f, slope, {0.3, true}, "foot");
  CHECK((turned.at - Vec3(1, 2, 1.7) - 0.3 * normal).norm() < 1e-14);
  const Mat3 R = turned.rotation * f.rotation.transpose();
  CHECK((R * Vec3::UnitZ() - normal).norm() < 1e-14);
  CHECK((R * Vec3::UnitZ().cross(normal) - Vec3::UnitZ().cross(normal)).norm() < 1e-14);
  CHECK(turned.first == 3);
  CHECK(turned.last == 8);
  CHECK(error_message([&] {
          projected({3, 8, Vec3(9, 0, 0)}, slope, {}, "left foot");
        }) == "left foot: the foot plant in frames 4-9 has no terrain above or below it");
}

TEST_CASE("images of a foot plant are averaged to one", "[mesh][sequences]") {
  Random random(25);
  const FootContact f{2, 5, random.point(), random_rotation_matrix(random)};
  const RigidMotion motion = random_motion(random);
  const FootContact same = averaged({f}, std::vector(8, motion))[0];
  CHECK((same.at - moved(motion, f).at).norm() < 1e-14);
  CHECK((same.rotation - moved(motion, f).rotation).norm() < 1e-14);
  // The mean of motions distributed evenly about one is that one; frames outside do not count.
  std::vector<RigidMotion> motions(8, random_motion(random));
  const Vec3 log(0.1, 0.2, -0.1), translation(1, 2, 3);
  for (int k = 2; k <= 5; ++k)
    motions[k] = RigidMotion::about(f.at, rotation_matrix((k - 3.5) * log) * motion.rotation,
                                    motion(f.at) + (k - 3.5) * translation);
  const FootContact mean = averaged({f}, motions)[0];
  CHECK((mean.at - moved(motion, f).at).norm() < 1e-13);
  CHECK((mean.rotation - moved(motion, f).rotation).norm() < 1e-13);
  CHECK(!error_message([&] { averaged({f}, std::vector(5, motion)); }).empty());
}

TEST_CASE("one straight path on the line of another moves nothing", "[mesh][sequences]") {
  for (const Vec3& step : {Vec3(0.1, 0, 0), Vec3(-0.3, 0.2, 0)})
    for (const int spans : {0, 1, 7}) {
      const Points c = straight_walk(64, step);
      const FittedPath path = fit_path(c, {Vec3::UnitZ(), spans});
      const Vec3 start = c.row(0);
      for (const double far : {5.0, 63.0, 100.0})
        for (const RigidMotion& motion : path_motions(
                 path, GroundPath::through({start, start + far / 3 * step, start + far * step})))
          CHECK(distance(motion, RigidMotion{}) < 1e-12);
    }
}

TEST_CASE("curves by their length: circles, ends that go straight on", "[mesh][sequences]") {
  std::vector<Vec3> points;
  for (int i = 0; i <= 64; ++i)
    points.push_back(3 * Vec3(std::cos(i * pi / 64), std::sin(i * pi / 64), i));
  const GroundPath half = GroundPath::through(points);
  CHECK(std::abs(half.length() - 3 * pi) < 1e-4);
  for (double s = 0.5; s < 9; s += 0.37) {
    CHECK((half.at(s) - 3 * Vec3(std::cos(s / 3), std::sin(s / 3), 0)).norm() < 1e-4);
    CHECK((half.frame(s).rotation.col(0) - Vec3(-std::sin(s / 3), std::cos(s / 3), 0)).norm() <
          1e-3);
    CHECK((half.frame(s).rotation * Vec3(1, 1, 1) - half.frame(s).rotation.col(0) - Vec3::UnitZ() -
           Vec3::UnitZ().cross(half.frame(s).rotation.col(0)))
              .norm() < 1e-14);
    CHECK(std::abs(half.length_to(half.parameter(s)) - s) < 1e-14 * 9);
    // Parametrised by length: steps have their nominal length.
    CHECK(std::abs((half.at(s + 1e-4) - half.at(s - 1e-4)).norm() - 2e-4) < 1e-11);
  }
  for (const double s : {-2.0, half.length() + 2}) {
    const double end = s < 0 ? 0 : half.length();
    const RigidMotion at_end = half.frame(end), beyond = half.frame(s);
    CHECK((beyond.translation - at_end.translation - (s - end) * at_end.rotation.col(0)).norm() <
          1e-13);
    CHECK((beyond.rotation - at_end.rotation).norm() < 1e-13);
  }
  CHECK(error_message([] {
          GroundPath::through({Vec3(1, 2, 3), Vec3(0, 0, 0), Vec3(0, 0, 1)});
        }) == "path: points 2 and 3 coincide on the ground");
  CHECK(!error_message([] { GroundPath::through({Vec3(1, 2, 3)}); }).empty());
  CHECK(!error_message([] { fit_path(Points::Ones(9, 3)); }).empty());
}

TEST_CASE("frames keep their offset beside and above their path", "[mesh][sequences]") {
  Random random(26);
  const RigidMotion tilt = random_motion(random);
  const Vec3 up = tilt.rotation.col(2);
  const Points c = walk(120, tilt);
  const FittedPath from = fit_path(c, {up, 3});
  std::vector<Vec3> points;
  for (int i = 0; i < 5; ++i) points.push_back(tilt(Vec3(i, std::sin(i), 0)));
  const GroundPath to = GroundPath::through(points, up);
  for (const PathLengths lengths : {PathLengths::Absolute, PathLengths::Normalised}) {
    const std::vector<RigidMotion> motions = path_motions(from, to, lengths);
    const double scale = lengths == PathLengths::Absolute ? 1 : to.length() / from.path.length();
    REQUIRE(motions.size() == 120);
    for (int k = 0; k < 120; ++k) {
      const double s = from.lengths[k];
      const Vec3 at = c.row(k);
      CHECK((to.frame(scale * s).inverse()(motions[k](at)) - from.path.frame(s).inverse()(at))
                .norm() < 1e-12);
      CHECK((motions[k].rotation * up - up).norm() < 1e-13);
      CHECK(std::abs((motions[k](at) - at).dot(up)) < 1e-12);
    }
    CHECK((scale * from.lengths.back() > to.length() + 1) == (lengths == PathLengths::Absolute));
  }
  CHECK(from.lengths.front() == 0);
  CHECK(std::abs(from.lengths.back() - from.path.length()) < 1e-12);
}

TEST_CASE("a path that is moved over the ground moves its frames as it was moved",
          "[mesh][sequences]") {
  const RigidMotion world{rotation_matrix(to_rotation_vector(Vec3::UnitZ(), 2)), Vec3(5, -3, 0)};
  const FittedPath from = fit_path(walk(120)), to = fit_path(walk(120, world));
  for (const RigidMotion& motion : path_motions(from, to.path))
    CHECK(distance(motion, world) < 1e-10);
}

TEST_CASE("fitted paths leave sway in the frames and come near with more pieces",
          "[mesh][sequences]") {
  // A sway of 0.05 beside a straight path: with few segments it is removed from the path.
  const int F = 200;
  Points c(F, 3);
  for (int k = 0; k < F; ++k) c.row(k) << 0.1 * k, 0.05 * std::sin(2 * pi * k / 10), 1;
  const FittedPath few = fit_path(c, {Vec3::UnitZ(), 4}), many = fit_path(c, {Vec3::UnitZ(), 80});
  double disjoint_union = 0, near = 0;
  for (int k = 0; k < F; ++k) {
    disjoint_union = std::max(disjoint_union, std::abs(few.path.at(few.lengths[k]).y()));
    near = std::max(near, (many.path.at(many.lengths[k]) - Vec3(c(k, 0), c(k, 1), 0)).norm());
  }
  CHECK(disjoint_union < 0.02);
  CHECK(near < 0.01);
  // Frames without motion have the same length, and do not affect the path.
  Points waiting(F + 100, 3);
  waiting << c.topRows(100), c.row(99).replicate(100, 1), c.bottomRows(100);
  const FittedPath waits = fit_path(waiting, {Vec3::UnitZ(), 4});
  for (int k = 0; k < F; ++k)
    CHECK(
        (waits.path.at(waits.lengths[k < 100 ? k : k + 100]) - few.path.at(few.lengths[k])).norm() <
        2e-3);
  for (int k = 100; k < 200; ++k) CHECK(waits.lengths[k] == waits.lengths[99]);
}
