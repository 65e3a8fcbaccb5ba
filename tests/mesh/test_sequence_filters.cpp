// SPDX-License-Identifier: MPL-2.0
// Filters of trajectories, and alignment of trajectories: properties of mesh/sequence.
#include <cmath>
#include <numbers>

#include "batten/mesh/sequence/trajectories/handle_trajectory.h"
#include "batten/mesh/sequence/trajectories/trajectory_filters.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/random_motion.h"

using namespace batten;
using namespace batten_test;

namespace {

using std::numbers::pi;

std::vector<SignalFilter> all_filters() {
  return {SignalFilter::low_pass(2), SignalFilter::high_pass(3), SignalFilter::cartoon(1.5, 0.8)};
}

Points straight(int frames) {
  Points p(frames, 3);
  for (int k = 0; k < frames; ++k) p.row(k) = Vec3(1, 2, 3) + k * Vec3(0.1, -0.2, 0.3);
  return p;
}

/// A root, a body attached to it, and an arm attached to the body.
std::vector<FilteredHandle> body_and_arm(int frames) {
  return {{"arm", {smooth_path(frames, 2), smooth_rotations(frames, 3)}, 1, {}},
          {"body", {smooth_path(frames, 4), smooth_rotations(frames, 5)}, -1, {}}};
}

}  // namespace

TEST_CASE("filters multiply sinusoids by their response", "[mesh][sequences]") {
  const int F = 200;
  for (const SignalFilter& filter : all_filters())
    for (const double omega : {0.0, 0.05, 0.4, 1.1, 2.9, pi}) {
      Points x(F, 3);
      for (int k = 0; k < F; ++k)
        x.row(k) << std::cos(omega * k), std::cos(omega * k + 1), -3 * std::sin(omega * k);
      for (const Padding padding : {Padding::Even, Padding::Odd}) {
        const Points away =
            (filter(x, padding) - filter.response(omega) * x).middleRows(40, F - 80);
        CHECK(away.cwiseAbs().maxCoeff() < 1e-10);
      }
    }
}

TEST_CASE("responses are those of the continuous kernels", "[mesh][sequences]") {
  for (const double sigma : {1.0, 2.0, 7.5})
    for (double omega = 0; omega < 1.5; omega += 0.1) {
      const double s = sigma * omega, gauss = std::exp(-s * s / 2);
      CHECK(std::abs(SignalFilter::low_pass(sigma).response(omega) - gauss) <
            2e-4 * (sigma < 2) + 1e-9);
      CHECK(std::abs(SignalFilter::high_pass(sigma).response(omega) - 1 + gauss) <
            2e-4 * (sigma < 2) + 1e-9);
      CHECK(std::abs(SignalFilter::cartoon(sigma, 0.7).response(omega) - 1 - 0.7 * s * s * gauss) <
            2e-2 * (sigma < 2) + 1e-7);
    }
  CHECK(std::abs(SignalFilter::cartoon(4, 1).response(std::sqrt(2.0) / 4) - 1 -
                 2 / std::numbers::e) < 1e-7);
  CHECK(error_message([] { SignalFilter::low_pass(0); }) ==
        "filter: found sigma = 0, expected a number above 0, up to 1e5 frames");
}

TEST_CASE("filters keep constants, and uniform motion if the ends are mirrored",
          "[mesh][sequences]") {
  for (const int F : {1, 2, 3, 50}) {
    const Points constant = Points::Constant(F, 3, 0.1 + 1e3), line = straight(F);
    for (const Padding padding : {Padding::Even, Padding::Odd}) {
      CHECK(distance(SignalFilter::low_pass(3)(constant, padding), constant) < 1e-14);
      CHECK(distance(SignalFilter::cartoon(3, 2)(constant, padding), constant) < 1e-14);
      CHECK(SignalFilter::high_pass(3)(constant, padding).norm() < 1e-14);
    }
    CHECK(distance(SignalFilter::low_pass(3)(line, Padding::Odd), line) < 1e-12);
    CHECK(distance(SignalFilter::cartoon(3, 2)(line, Padding::Odd), line) < 1e-12);
  }
}

TEST_CASE("ends are mirrored as often as the kernel is long", "[mesh][sequences]") {
  // With symmetric extension, a signal is a sum of cosines of whole half waves: these are scaled up
  // to the ends.
  const int F = 6;
  for (const SignalFilter& filter : {SignalFilter::low_pass(4), SignalFilter::cartoon(3, 1)})
    for (int wave = 0; wave < F; ++wave) {
      const double omega = pi * wave / (F - 1);
      Points x(F, 3);
      for (int k = 0; k < F; ++k) x.row(k).setConstant(std::cos(omega * k));
      CHECK(distance(filter(x), filter.response(omega) * x) < 1e-13);
    }
  // With antisymmetric extension, sines of whole half waves.
  for (int wave = 1; wave < F; ++wave) {
    const SignalFilter filter = SignalFilter::low_pass(4);
    const double omega = pi * wave / (F - 1);
    Points x(F, 3);
    for (int k = 0; k < F; ++k) x.row(k).setConstant(std::sin(omega * k));
    CHECK(distance(filter(x, Padding::Odd), filter.response(omega) * x) < 1e-13);
  }
}

TEST_CASE("rotations about one axis are filtered as their angles", "[mesh][sequences]") {
  const int F = 60;
  const Vec3 axis = Vec3(1, -2, 0.5).normalized();
  std::vector<Mat3> rotations;
  Points angles = Points::Zero(F, 3);
  for (int k = 0; k < F; ++k) {
    angles(k, 0) = 0.4 * k + std::sin(0.3 * k);
    rotations.push_back(rotation_matrix(to_rotation_vector(axis, angles(k, 0))));
  }
  const SignalFilter filter = SignalFilter::cartoon(2);
  const std::vector<Mat3> found = filter(rotations, Padding::Odd);
  const Points expected = filter(angles, Padding::Odd);
  for (int k = 0; k < F; ++k)
    CHECK((found[k] - rotation_matrix(to_rotation_vector(axis, expected(k, 0)))).norm() < 1e-12);
}

TEST_CASE("rotations of many turns about any axes are filtered without jumps",
          "[mesh][sequences]") {
  // A filter close to the identity has a small effect, also across a full turn.
  const std::vector<Mat3> rotations = smooth_rotations(200, 3);
  for (const Padding padding : {Padding::Even, Padding::Odd}) {
    CHECK(distance(SignalFilter(1, {1e-6, -1e-6})(rotations, padding), rotations) < 1e-5);
    const std::vector<Mat3> found = SignalFilter::low_pass(0.8)(rotations, padding);
    double farthest = 0;
    for (int k = 6; k < 194; ++k) farthest = std::max(farthest, (found[k] - rotations[k]).norm());
    CHECK(farthest < 0.1);
    // From either side.
    const Mat3 a = smooth_rotations(9, 1)[8], b = smooth_rotations(9, 2)[8];
    std::vector<Mat3> seen;
    for (const Mat3& R : rotations) seen.push_back(a * R * b);
    const std::vector<Mat3> other = SignalFilter::low_pass(0.8)(seen, padding);
    for (size_t k = 0; k < rotations.size(); ++k)
      CHECK((other[k] - a * found[k] * b).norm() < 1e-12);
  }
}

TEST_CASE("trajectories relative to others come back, and are still where they go along",
          "[mesh][sequences]") {
  const int F = 40;
  const Trajectory parent{smooth_path(F, 1), smooth_rotations(F, 2)},
      child{smooth_path(F, 3), smooth_rotations(F, 4)};
  CHECK(distance(composed(relative(child, parent), parent), child) < 1e-14);
  std::vector<RigidMotion> motions;
  for (int k = 0; k < F; ++k)
    motions.push_back({parent.rotations[k], parent.centres.row(k).transpose()});
  Trajectory still{Points::Constant(F, 3, 0.7), std::vector<Mat3>(F, smooth_rotations(2, 7)[1])};
  CHECK(distance(relative(moved(motions, still), parent), still) < 1e-13);
}

TEST_CASE("filtered handles go along with their parents", "[mesh][sequences]") {
  const int F = 50;
  std::vector<FilteredHandle> handles = body_and_arm(F);
  const Trajectory root{smooth_path(F, 6), std::vector<Mat3>(F, Mat3::Identity())};
  const SignalFilter nothing(1, {}), filter = SignalFilter::cartoon(2);
  const FilteredTrajectories same = filtered(root, handles, nothing);
  CHECK(distance(same.root, root) < 1e-14);
  for (int h = 0; h < 2; ++h) CHECK(distance(same.handles[h], handles[h].trajectory) < 1e-13);
  // A part that is rigid relative to its parent stays so, although the parent is filtered.
  std::vector<RigidMotion> motions;
  for (int k = 0; k < F; ++k)
    motions.push_back(
        {handles[1].trajectory.rotations[k], handles[1].trajectory.centres.row(k).transpose()});
  const Trajectory still{Points::Constant(F, 3, 0.7), std::vector<Mat3>(F, Mat3::Identity())};
  handles[0].trajectory = moved(motions, still);
  const FilteredTrajectories found = filtered(root, handles, filter);
  CHECK(distance(found.handles[1], handles[1].trajectory) > 0.1);
  CHECK(distance(relative(found.handles[0], found.handles[1]), still) < 1e-13);
  // The body relative to the root, computed directly.
  CHECK(distance(relative(found.handles[1], found.root).centres,
                 filter(relative(handles[1].trajectory, root).centres)) < 1e-13);
  CHECK(distance(found.root.centres, filter(root.centres)) == 0);
}

TEST_CASE("filtering does not depend on the frame of reference", "[mesh][sequences]") {
  Random random(11);
  const int F = 40;
  std::vector<FilteredHandle> handles = body_and_arm(F), seen = handles;
  const Trajectory root{smooth_path(F, 6), smooth_rotations(F, 7)};
  const Similarity view{1, random_rotation_matrix(random), random.point()};
  for (FilteredHandle& handle : seen) handle.trajectory = aligned(handle.trajectory, view);
  const SignalFilter filter = SignalFilter::low_pass(2);
  const FilteredTrajectories a = filtered(root, handles, filter),
                             b = filtered(aligned(root, view), seen, filter);
  for (int h = 0; h < 2; ++h) CHECK(distance(aligned(a.handles[h], view), b.handles[h]) < 1e-12);
}

TEST_CASE("foot plants are unchanged and blend into what is filtered", "[mesh][sequences]") {
  const int F = 60;
  std::vector<FilteredHandle> handles = body_and_arm(F);
  const Trajectory root{smooth_path(F, 6), smooth_rotations(F, 7)};
  const SignalFilter filter = SignalFilter::cartoon(2);
  const FilteredTrajectories plain = filtered(root, handles, filter);
  handles[0].foot_contacts = {{20, 27, Vec3::Zero()}, {40, 45, Vec3::Zero()}};
  FilterOptions options;
  options.blend = 4;
  const FilteredTrajectories found = filtered(root, handles, filter, options);
  CHECK(distance(found.handles[1], plain.handles[1]) == 0);
  for (int k = 0; k < F; ++k) {
    const Eigen::RowVector3d before = handles[0].trajectory.centres.row(k);
    const double left = (found.handles[0].centres.row(k) - before).norm(),
                 whole = (plain.handles[0].centres.row(k) - before).norm();
    const double turned =
        (found.handles[0].rotations[k] - handles[0].trajectory.rotations[k]).norm();
    const int away = k < 34 ? std::max({20 - k, k - 27, 0}) : std::max({40 - k, k - 45, 0});
    if (away == 0) {
      CHECK(left == 0);
      CHECK(turned == 0);
    } else if (away > 4) {
      CHECK(left == whole);
      CHECK(found.handles[0].rotations[k] == plain.handles[0].rotations[k]);
    } else {
      const double t = away / 5.0;
      CHECK(std::abs(left - t * t * (3 - 2 * t) * whole) < 1e-13);
      CHECK(turned < (plain.handles[0].rotations[k] - handles[0].trajectory.rotations[k]).norm());
    }
  }
}

TEST_CASE("hierarchies that cannot be are refused by the handle's name", "[mesh][sequences]") {
  const int F = 10;
  const Trajectory root{smooth_path(F, 6), smooth_rotations(F, 7)};
  const auto message = [&](auto change) {
    std::vector<FilteredHandle> handles = body_and_arm(F);
    change(handles);
    return error_message([&] { filtered(root, handles, SignalFilter::low_pass(1)); });
  };
  CHECK(message([](auto& h) { h[1].parent = 2; }) ==
        "body: found parent 2, expected one of the 2 handles");
  CHECK(message([](auto& h) { h[1].parent = 0; }) == "arm: its parents form a cycle");
  CHECK(message([](auto& h) {
          h[0].trajectory = {smooth_path(9, 1), smooth_rotations(9, 1)};
        }) == "arm: found 9 frames, expected 10 as the root has");
  CHECK(message([](auto& h) {
          h[0].foot_contacts = {{3, 10, Vec3::Zero()}};
        }) == "arm: the foot plant in frames 4-11 is outside of frames 1-10");
}

TEST_CASE("similar trajectories are aligned, rotations with them", "[mesh][sequences]") {
  Random random(12);
  const Trajectory t{smooth_path(35, 1), smooth_rotations(35, 2)};
  for (const bool upright : {false, true}) {
    const Vec3 axis = random.point().normalized();
    AlignmentOptions options;
    if (upright) options.about = 3 * axis;
    const Similarity s{
        0.4,
        upright ? rotation_matrix(to_rotation_vector(axis, 2.2)) : random_rotation_matrix(random),
        random.point()};
    const Similarity found = alignment(t, aligned(t, s), options);
    CHECK(distance(aligned(t, found), aligned(t, s)) < 1e-13);
    CHECK(std::abs(found.scale - s.scale) < 1e-13);
    CHECK(found.max_error < 1e-13);
    // No other similarity of the same type is closer.
    Trajectory other{smooth_path(35, 9), smooth_rotations(35, 2)};
    const auto off = [&](const Similarity& by) {
      return (aligned(t, by).centres - other.centres).squaredNorm();
    };
    const Similarity best = alignment(t, other, options);
    for (int i = 0; i < 20; ++i) {
      const Vec3 about = upright ? axis : random.point();
      const Mat3 R =
          rotation_matrix(to_rotation_vector(about, i < 10 ? 1e-3 * random() : 3 * random()));
      Similarity near{best.scale * (1 + 1e-3 * random()), R * best.R, best.translation};
      near.translation += 1e-3 * random.point();
      CHECK(off(best) < off(near));
    }
    options.scales = false;
    CHECK(alignment(t, other, options).scale == 1);
  }
  // Rotating and scaling all frames gives the aligned trajectory.
  const Similarity s{2, random_rotation_matrix(random), random.point()};
  std::vector<Points> frames, seen;
  Points group(6, 3);
  for (int v = 0; v < 6; ++v) group.row(v) = random.point();
  for (int k = 0; k < 35; ++k) {
    frames.push_back(moved({t.rotations[k], t.centres.row(k).transpose()}, group));
    seen.push_back(moved({s.R, s.translation}, Points(s.scale * frames.back())));
  }
  const std::vector<int> all = {0, 1, 2, 3, 4, 5};
  CHECK(distance(trajectory_of(seen, all), aligned(trajectory_of(frames, all), s)) < 1e-13);
}

TEST_CASE("trajectories without rotation are translated", "[mesh][sequences]") {
  const Trajectory still{Points::Constant(5, 3, 2.0), std::vector<Mat3>(5, Mat3::Identity())};
  const Trajectory t{smooth_path(8, 1), smooth_rotations(8, 2)};
  const Similarity s = alignment(still, t);
  CHECK(s.R == Mat3::Identity());
  CHECK(s.scale == 1);
  CHECK((s.translation - (t.centres.colwise().mean().transpose() - Vec3(2, 2, 2))).norm() < 1e-14);
}

TEST_CASE("resampled trajectories keep their ends and even motion", "[mesh][sequences]") {
  const int F = 12;
  std::vector<Mat3> rotations;
  for (int k = 0; k < F; ++k)
    rotations.push_back(rotation_matrix(to_rotation_vector(Vec3(1, 2, 3), 0.5 * k)));
  const Trajectory even{straight(F), rotations}, t{smooth_path(F, 1), smooth_rotations(F, 2)};
  for (const Resampling how : {Resampling::Linear, Resampling::Hermite}) {
    CHECK(distance(resampled(t, F, how), t) == 0);
    for (const int frames : {1, 2, 5, 23, 34}) {
      const Trajectory found = resampled(even, frames, how), other = resampled(t, frames, how);
      for (int k = 0; k < frames; ++k) {
        const double at = frames > 1 ? 11.0 * k / (frames - 1) : 0;
        CHECK(
            (found.centres.row(k).transpose() - Vec3(1, 2, 3) - at * Vec3(0.1, -0.2, 0.3)).norm() <
            1e-13);
        CHECK((found.rotations[k] - rotation_matrix(to_rotation_vector(Vec3(1, 2, 3), 0.5 * at)))
                  .norm() < 1e-13);
      }
      CHECK((other.centres.row(0) - t.centres.row(0)).norm() < 1e-14);
      if (frames > 1) CHECK((other.centres.row(frames - 1) - t.centres.row(F - 1)).norm() < 1e-13);
    }
  }
  // With twice as many segments it interpolates every frame.
  const Trajectory finer = resampled(t, 2 * F - 1);
  for (int k = 0; k < F; ++k) CHECK((finer.centres.row(2 * k) - t.centres.row(k)).norm() < 1e-13);
  // Hermite interpolation is more accurate for smooth motion.
  const Trajectory fine{smooth_path(23, 1), smooth_rotations(23, 2)};
  Trajectory coarse;
  coarse.centres.resize(12, 3);
  for (int k = 0; k < 12; ++k) {
    coarse.centres.row(k) = fine.centres.row(2 * k);
    coarse.rotations.push_back(fine.rotations[2 * k]);
  }
  CHECK(distance(resampled(coarse, 23), fine) <
        0.5 * distance(resampled(coarse, 23, Resampling::Linear), fine));
}
