// SPDX-License-Identifier: MPL-2.0
// Rotations and centroids over time: properties of mesh/sequence that do not involve a deformer.

#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/core/op_counter.h"
#include "batten/mesh/sequence/trajectories/handle_trajectory.h"
#include "batten/tests/support/allocations.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/random_motion.h"
#include "batten/tests/support/sample_meshes.h"

using namespace batten;
using namespace batten_test;

namespace {

using Smoothness = TrajectoryOptions::Smoothness;

double value(const KeyframeWeights::Row& row, const std::vector<double>& at_keyframes) {
  double sum = 0;
  for (int j = 0; j < row.count; ++j) sum += row.weights[j] * at_keyframes[row.first + j];
  return sum;
}

/// Values and slopes (by the same small step to both sides) at times.
struct Sampled {
  std::vector<double> value, left, right;
};

Sampled sample(const std::vector<double>& keys, const std::vector<double>& values,
               const std::vector<double>& at, KeyframeExtrapolation ends,
               std::optional<double> from = {}, std::optional<double> to = {}) {
  constexpr double h = 1e-6;
  std::vector<double> times;
  for (const double t : at) times.insert(times.end(), {t - h, t, t + h});
  const KeyframeWeights weights(times, keys, ends, from, to);
  Sampled s;
  for (int k = 0; k < weights.frame_count(); k += 3) {
    const double a = value(weights.row(k), values), b = value(weights.row(k + 1), values),
                 c = value(weights.row(k + 2), values);
    s.value.push_back(b);
    s.left.push_back((b - a) / h);
    s.right.push_back((c - b) / h);
  }
  return s;
}

const std::vector<double> uneven = {-1, 0.3, 0.8, 3, 4.5}, values = {2, -1, 0.5, 0.7, -3};

}  // namespace

TEST_CASE("rigid motions compose, turn back, and are found again in trajectories",
          "[mesh][sequences]") {
  Random random(1);
  const RigidMotion a = random_motion(random), b = random_motion(random);
  const Vec3 p = random.point();
  CHECK(((a * b)(p)-a(b(p))).norm() < 1e-14);
  CHECK(distance(a * a.inverse(), RigidMotion{}) < 1e-14);
  Points mesh(30, 3);
  for (int v = 0; v < 30; ++v) mesh.row(v) = Vec3(1e5, 0, 0) + random.point();
  std::vector<Points> frames = {mesh};
  std::vector<RigidMotion> motions = {{}};
  for (int k = 1; k < 8; ++k) {
    motions.push_back(random_motion(random));
    frames.push_back(moved(motions.back(), mesh));
  }
  const std::vector<int> some = {3, 4, 9, 20, 11};
  const Trajectory t = trajectory_of(frames, some);
  Trajectory still = t;
  for (int k = 0; k < 8; ++k) {
    still.centres.row(k) = t.centres.row(0);
    still.rotations[k].setIdentity();
  }
  CHECK(distance(t, moved(motions, still)) < 1e-9);
  const std::vector<RigidMotion> found = motions_between(still, t);
  for (int k = 0; k < 8; ++k)
    CHECK((found[k](mesh.row(7).transpose()) - frames[k].row(7).transpose()).norm() < 1e-9);
  CHECK(error_message([&] {
          trajectory_of(frames, {3, 30});
        }) == "trajectory: found vertex 31, but frame 1 has 30 vertices");
  const std::vector<RigidMotion> again = motions_between(t, moved(motions, t));
  for (int k = 0; k < 8; ++k) CHECK((again[k].rotation - motions[k].rotation).norm() < 1e-14);
  CHECK(!error_message([&] { trajectory_of(frames, {}); }).empty());
}

TEST_CASE("weights of keyframes give the values there, and parabolas between inner ones",
          "[mesh][sequences]") {
  const std::vector<double> keys = uneven;
  const KeyframeWeights at(keys, keys);
  for (int m = 0; m < 5; ++m) {
    CHECK(at.row(m).count == 1);
    CHECK(value(at.row(m), values) == values[m]);
  }
  std::vector<double> times, parabola, line;
  for (const double t : keys) {
    parabola.push_back(1 - t + 3 * t * t);
    line.push_back(2 - t);
  }
  for (double t = 0.3; t < 3; t += 0.1) times.push_back(t);
  const KeyframeWeights inner(times, keys);
  for (int k = 0; k < inner.frame_count(); ++k) {
    const double t = times[k];
    CHECK(std::abs(value(inner.row(k), parabola) - (1 - t + 3 * t * t)) < 1e-13);
    CHECK(std::abs(value(inner.row(k), {1, 1, 1, 1, 1}) - 1) < 1e-14);
  }
  const std::vector<double> everywhere = {-7, -1, -0.4, 0.3, 2, 3.7, 4.5, 9};
  const KeyframeWeights linear(everywhere, keys, KeyframeExtrapolation::Linear);
  for (int k = 0; k < 8; ++k)
    CHECK(std::abs(value(linear.row(k), line) - (2 - everywhere[k])) < 1e-13);
}

TEST_CASE("values between keyframes have no kinks and are constant outside or zero",
          "[mesh][sequences]") {
  const Sampled s = sample(uneven, values, uneven, KeyframeExtrapolation::None);
  for (int m = 0; m < 5; ++m) CHECK(std::abs(s.left[m] - s.right[m]) < 1e-4);
  for (const int end : {0, 4}) CHECK(std::abs(s.left[end]) + std::abs(s.right[end]) < 1e-4);
  const Sampled outside = sample(uneven, values, {-50, 60}, KeyframeExtrapolation::None);
  CHECK(outside.value == std::vector<double>{values.front(), values.back()});
  const Sampled bump =
      sample(uneven, values, {-2, -1, 0.3, 0.8, 3, 4.5, 6}, KeyframeExtrapolation::None, -2, 6);
  for (size_t i = 0; i < 7; ++i) CHECK(std::abs(bump.left[i] - bump.right[i]) < 1e-4);
  for (const size_t end : {size_t{0}, size_t{6}}) {
    CHECK(bump.value[end] == 0);
    CHECK(std::abs(bump.left[end]) + std::abs(bump.right[end]) < 1e-4);
  }
  CHECK(sample(uneven, values, {-2.1, 7}, KeyframeExtrapolation::None, -2, 6).value ==
        std::vector<double>{0, 0});
}

TEST_CASE("an influence ends flat also where the other end goes straight on", "[mesh][sequences]") {
  const Sampled s = sample(uneven, values, {-2, 4.5, 5, 7}, KeyframeExtrapolation::Linear, -2);
  CHECK(s.value[0] == 0);
  CHECK(std::abs(s.left[0]) + std::abs(s.right[0]) < 1e-4);
  for (const size_t i : {1, 2, 3}) CHECK(std::abs(s.right[i] + 3.7 / 1.5) < 1e-4);
}

TEST_CASE("keyframes that cannot be are refused by name", "[mesh][sequences]") {
  const std::vector<double> t = frame_numbers(10);
  const auto message = [&](std::vector<int> keys, InfluenceInterval interval = {}) {
    return error_message(
        [&] { KeyframeWeights::of_frames(t, keys, KeyframeExtrapolation::None, interval); });
  };
  CHECK(message({}) == "found no keyframes, expected one or more");
  CHECK(message({3, 10}) == "keyframe 11 is not one of the frames 1-10");
  CHECK(message({5, 5}) == "found keyframe 6 after keyframe 6, expected increasing frames");
  CHECK(message({3, 5}, {3, 9}) ==
        "found the influence start at frame 4, expected it before the first keyframe, 4");
  CHECK(message({3, 5}, {{}, 5}) ==
        "found the influence end at frame 6, expected it after the last keyframe, 6");
  CHECK(message({3, 5}, {2, 6}).empty());
}

TEST_CASE("logarithms follow rotations through many turns", "[mesh][sequences]") {
  Random random(5);
  const Vec3 axis = random.point().normalized();
  std::vector<Mat3> rotations;
  for (int k = 0; k < 40; ++k)
    rotations.push_back(rotation_matrix(to_rotation_vector(axis, 0.9 * k)));
  const Points logs = unwrapped_logs(rotations);
  for (int k = 0; k < 40; ++k)
    CHECK((logs.row(k).transpose() - to_rotation_vector(axis, 0.9 * k)).norm() < 1e-12);
  // A full turn has no axis.
  CHECK((nearest_log(Mat3::Identity(), to_rotation_vector(axis, 6)) -
         to_rotation_vector(axis, 2 * std::numbers::pi))
            .norm() < 1e-14);
  // Each vertex separately; every logarithm is one of its rotation.
  std::vector<std::vector<Mat3>> at_keyframes(4);
  for (std::vector<Mat3>& of : at_keyframes)
    for (int v = 0; v < 9; ++v) of.push_back(random_rotation_matrix(random, 6));
  const std::vector<Points> all = unwrapped_logs(at_keyframes);
  for (int v = 0; v < 9; ++v) {
    std::vector<Mat3> one;
    for (int m = 0; m < 4; ++m) {
      one.push_back(at_keyframes[m][v]);
      CHECK((rotation_matrix(all[m].row(v).transpose()) - one.back()).norm() < 1e-14);
    }
    const Points followed = unwrapped_logs(one);
    for (int m = 0; m < 4; ++m) CHECK(followed.row(m) == all[m].row(v));
    for (int m = 1; m < 4; ++m)
      CHECK((followed.row(m) - followed.row(m - 1)).norm() <
            std::hypot(std::numbers::pi, 4 * std::numbers::pi));
  }
}

TEST_CASE("a twist of more than a turn is followed over the mesh", "[mesh][sequences]") {
  const TriangleMesh mesh = disjoint_union(sheet(30), sheet(9));
  const Vec3 axis = Vec3(1, 2, -1).normalized();
  std::vector<std::vector<Mat3>> at(3);
  const auto angle = [&](int m, int v) {
    return (m + 1) * 1.5 * (mesh.point(v).x() - 1) + 0.3 * mesh.point(v).y();
  };
  for (int m = 0; m < 3; ++m)
    for (int v = 0; v < mesh.vertex_count(); ++v)
      at[m].push_back(rotation_matrix(to_rotation_vector(axis, angle(m, v))));
  const std::vector<Points> logs = unwrapped_logs(at, mesh.topology());
  for (int m = 0; m < 3; ++m)
    for (int v = 0; v < mesh.vertex_count(); ++v)
      CHECK((logs[m].row(v).transpose() - to_rotation_vector(axis, angle(m, v))).norm() < 1e-12);
  CHECK(error_message([&] { unwrapped_logs(at, sheet(2).topology()); }) ==
        "found 1061 rotations for 9 vertices, expected one for each");
}

TEST_CASE("a sequence of one frame is edited too", "[mesh][sequences]") {
  const Trajectory t{Points::Ones(1, 3), {Mat3::Identity()}};
  Random random(31);
  const RigidMotion motion = random_motion(random);
  CHECK(distance(edited(t, {{0, motion}}), moved({motion}, t)) < 1e-15);
}

TEST_CASE("interpolated rotations are exact at keyframes and the same in any frame of reference",
          "[mesh][sequences]") {
  Random random(6);
  const std::vector<int> keys = {2, 5, 6, 14};
  std::vector<Mat3> at;
  for (int m = 0; m < 4; ++m) at.push_back(random_rotation_matrix(random, 1.5));
  const std::vector<double> times = frame_numbers(20);
  const auto weights = KeyframeWeights::of_frames(times, keys, KeyframeExtrapolation::Linear);
  const std::vector<Mat3> rotations = interpolated_rotations(weights, at);
  for (int m = 0; m < 4; ++m) CHECK(rotations[keys[m]] == at[m]);
  for (const Mat3& R : rotations) {
    CHECK((R.transpose() * R - Mat3::Identity()).norm() < 1e-14);
    CHECK(R.determinant() > 0);
  }
  const Mat3 Q = random_rotation_matrix(random);
  std::vector<Mat3> seen;
  for (const Mat3& R : at) seen.push_back(Q * R * Q.transpose());
  const std::vector<Mat3> other = interpolated_rotations(weights, seen);
  for (int k = 0; k < 20; ++k) CHECK((other[k] - Q * rotations[k] * Q.transpose()).norm() < 1e-12);
  // Between two: about one axis, half of the angle in the middle.
  const auto pair = KeyframeWeights::of_frames(times, std::vector<int>{4, 10});
  const std::vector<Mat3> ends = {Mat3::Identity(),
                                  rotation_matrix(to_rotation_vector(Vec3(1, 2, 3), 2.5))};
  CHECK((interpolated_rotations(pair, ends)[7] -
         rotation_matrix(to_rotation_vector(Vec3(1, 2, 3), 1.25)))
            .norm() < 1e-14);
}

TEST_CASE("interpolating a frame allocates nothing", "[mesh][sequences]") {
  Random random(7);
  std::vector<std::vector<Mat3>> at(3);
  for (std::vector<Mat3>& of : at)
    for (int v = 0; v < 100; ++v) of.push_back(random_rotation_matrix(random, 1));
  const std::vector<Points> logs = unwrapped_logs(at);
  const auto weights = KeyframeWeights::of_frames(frame_numbers(10), std::vector<int>{1, 4, 8});
  Points result(100, 3);
  const ScopedOpCount work;
  for (int k = 0; k < 10; ++k) interpolate_logs(weights.row(k), logs, result);
  if (counts_allocations()) CHECK(work.of(OpCounter::Allocation) == 0);
  interpolate_logs(weights.row(4), logs, result);
  CHECK(result == logs[1]);
}

TEST_CASE("centroids after an edit are the minimum of the formula", "[mesh][sequences]") {
  Random random(8);
  const int F = 17;
  const Points c = smooth_path(F, 3);
  const std::vector<Mat3> rotations = smooth_rotations(F, 4);
  const std::vector<int> keys = {3, 4, 11};
  Points at(3, 3);
  for (int m = 0; m < 3; ++m) at.row(m) = random.point();
  TrajectoryOptions options;
  options.smoothness = Smoothness::PiecewiseLinear;
  const Points found = edited_centres(c, rotations, keys, at, options);
  // Two equations per pair of neighbours, one with the rotation of each; keyframes by substitution.
  MatX A = MatX::Zero(2 * (F - 1), F), b(2 * (F - 1), 3);
  for (int k = 0; k + 1 < F; ++k)
    for (int j = 0; j < 2; ++j) {
      A(2 * k + j, k) = -1;
      A(2 * k + j, k + 1) = 1;
      b.row(2 * k + j) = (c.row(k + 1) - c.row(k)) * rotations[k + j].transpose();
    }
  for (int m = 0; m < 3; ++m) {
    b -= A.col(keys[m]) * at.row(m);
    A.col(keys[m]).setZero();
  }
  Points dense = least_squares(A, b);
  for (int m = 0; m < 3; ++m) dense.row(keys[m]) = at.row(m);
  CHECK(distance(found, dense) < 1e-12);
}

TEST_CASE("edits of trajectories keep the unedited components", "[mesh][sequences]") {
  Random random(9);
  const int F = 30;
  Trajectory t{smooth_path(F, 5), smooth_rotations(F, 6)};
  const RigidMotion motion = random_motion(random);
  for (const Smoothness smoothness : {Smoothness::PiecewiseLinear, Smoothness::Smooth}) {
    TrajectoryOptions options;
    options.smoothness = smoothness;
    const std::vector<HandleKeyframe> none = {{2, {}}, {9, {}}, {20, {}}};
    CHECK(distance(edited(t, none, options), t) == 0);
    std::vector<HandleKeyframe> same;
    for (const int k : {4, 5, 17, 29}) same.push_back({k, motion});
    CHECK(distance(edited(t, same, options), moved(std::vector(F, motion), t)) < 1e-13);
    const Trajectory shifted = edited(t, {{12, {Mat3::Identity(), {1, 2, 3}}}}, options);
    for (int k = 0; k < F; ++k)
      CHECK((shifted.centres.row(k) - t.centres.row(k) - Eigen::RowVector3d(1, 2, 3)).norm() <
            1e-14);
    // With an influence: the keyframe is exact, and there is no change outside.
    options.influence = {5, 21};
    const std::vector<HandleKeyframe> two = {{8, motion}, {15, random_motion(random)}};
    const Trajectory local = edited(t, two, options);
    for (const HandleKeyframe& keyframe : two) {
      const int k = keyframe.frame;
      CHECK((local.centres.row(k).transpose() - keyframe.motion(t.centres.row(k).transpose()))
                .norm() == 0);
      CHECK((local.rotations[k] - keyframe.motion.rotation * t.rotations[k]).norm() == 0);
    }
    for (int k = 0; k < F; ++k)
      if (k <= 5 || k >= 21)
        CHECK(local.centres.row(k) == t.centres.row(k));
      else
        CHECK(local.centres.row(k) != t.centres.row(k));
  }
}

TEST_CASE("smooth edits have no kink where those of the paper have one", "[mesh][sequences]") {
  // A resting handle that is displaced in the middle: the displacement itself is resolved in
  // detail.
  const int F = 2001;
  Points still = Points::Zero(F, 3);
  const std::vector<Mat3> rotations(F, Mat3::Identity());
  TrajectoryOptions options;
  options.influence = {200, 1800};
  options.times = frame_numbers(F);
  for (double& time : options.times) time /= 100;
  Points at(2, 3);
  at << 1, 0, 0, 0, 1, 0;
  const auto jump = [&](const Points& p, int k) {
    return ((p.row(k + 1) - p.row(k)) - (p.row(k) - p.row(k - 1))).norm() * 100;
  };
  const Points smooth = edited_centres(still, rotations, {900, 1100}, at, options);
  options.smoothness = Smoothness::PiecewiseLinear;
  const Points paper = edited_centres(still, rotations, {900, 1100}, at, options);
  for (const int k : {200, 900, 1100, 1800}) {
    CHECK(jump(smooth, k) < 0.02);
    CHECK(jump(paper, k) > 0.1);
  }
  // No curve through the same points has less bending: a bump between keyframes increases ∫ |x''|².
  const auto bending = [&](const Points& p) {
    return (p.bottomRows(F - 2) - 2 * p.middleRows(1, F - 2) + p.topRows(F - 2)).squaredNorm();
  };
  const auto bumped = [&](double height) {
    Points p = smooth;
    for (int k = 901; k < 1100; ++k)
      p(k, 2) += height * std::pow(std::sin(std::numbers::pi * (k - 900) / 200), 2);
    for (int k = 201; k < 900; ++k)
      p(k, 0) += height * std::pow(std::sin(std::numbers::pi * (k - 200) / 700), 2);
    return bending(p);
  };
  CHECK(bending(smooth) < std::min(bumped(0.01), bumped(-0.01)));
}

TEST_CASE("edits of trajectories that cannot be are refused", "[mesh][sequences]") {
  const Points c = smooth_path(5, 1);
  const std::vector<Mat3> rotations(5, Mat3::Identity());
  TrajectoryOptions options;
  CHECK(error_message([&] { edited_centres(c, rotations, {1}, Points(2, 3)); }) ==
        "found 2 centroids for 1 keyframes, expected one for each");
  CHECK(error_message([&] { edited_centres(c, {}, {1}, Points(1, 3)); }) ==
        "found 0 rotations for 5 frames, expected one for each");
  options.times = {0, 1, 1, 2, 3};
  CHECK(error_message([&] { edited_centres(c, rotations, {1}, Points(1, 3), options); }) ==
        "frame 3 has a time that is not after that of the frame before");
}
