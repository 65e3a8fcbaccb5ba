// SPDX-License-Identifier: MPL-2.0
// Curves through the vertices of a mesh, faired and shaped by loads.
#include "batten/sculpting/curves/deformable_curve.h"

#include <cmath>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/tests/support/catch.h"

using namespace batten;

namespace {

/// Half a sine wave between (0, 0, 0) and (10, 0, 0), symmetric about x = 5.
std::vector<Vec3> wave(double noise = 0) {
  std::vector<Vec3> points;
  for (int i = 0; i <= 20; ++i)
    points.emplace_back(0.5 * i, 0,
                        std::sin(i * std::numbers::pi / 20) +
                            noise * ((i % 2) * 2 - 1) * (i > 0 && i < 20 ? 1 : 0));
  return points;
}

}  // namespace

TEST_CASE("without fairing and loads the targets are the points", "[sculpting][curves]") {
  SculptedCurveOptions options;
  options.faired = false;
  const std::vector<Vec3> points = wave(0.05);
  const SculptedCurve found = sculpt_curve("wave", points, options);
  REQUIRE(found.targets.size() == points.size());
  for (size_t i = 0; i < points.size(); ++i) CHECK((found.targets[i] - points[i]).norm() < 1e-6);
  CHECK(found.largest_shift == 0);
  CHECK(found.fairing.max < 1e-6);
}

TEST_CASE("fairing removes noise and keeps the ends", "[sculpting][curves]") {
  SculptedCurveOptions options;
  options.fair.smoothing = FairOptions::Smoothing::Wavelength;
  options.fair.wavelength = 4;
  const std::vector<Vec3> points = wave(0.05);
  const SculptedCurve found = sculpt_curve("wave", points, options);
  CHECK(found.fairing.max > 0.03);
  CHECK(found.fairing.max < 0.1);
  CHECK((found.targets.front() - points.front()).norm() < 1e-12);
  CHECK((found.targets.back() - points.back()).norm() < 1e-12);
}

TEST_CASE("a symmetric load moves the targets symmetrically", "[sculpting][curves]") {
  SculptedCurveOptions options;
  options.faired = false;
  options.loads = {{"push", 20, CurveLoad::Uniform{Vec3::UnitY()}}};
  const SculptedCurve found = sculpt_curve("wave", wave(), options);
  CHECK(found.largest_shift > 1e-3);
  CHECK((found.targets.front() - Vec3(0, 0, 0)).norm() < 1e-10);
  for (int i = 0; i <= 20; ++i)
    CHECK(std::abs(found.targets[i].y() - found.targets[20 - i].y()) < 1e-6 * found.largest_shift);
  // Twice the load, twice the displacement.
  options.loads[0].value = 40;
  CHECK(std::abs(sculpt_curve("wave", wave(), options).largest_shift - 2 * found.largest_shift) <
        1e-9 * found.largest_shift);
  // Pinned ends resist less than clamped ones.
  options.ends = SculptedCurveOptions::Ends::Pinned;
  CHECK(sculpt_curve("wave", wave(), options).largest_shift > 2 * found.largest_shift);
}

TEST_CASE("free ends need springs", "[sculpting][curves]") {
  SculptedCurveOptions options;
  options.ends = SculptedCurveOptions::Ends::Free;
  options.loads = {{"push", 1, CurveLoad::Uniform{Vec3::UnitY()}}};
  CHECK_THROWS_AS(sculpt_curve("wave", wave(), options), NoSolutionError);
  CHECK_THROWS_AS(sculpt_curve("wave", {Vec3::Zero()}, {}), InputError);
}
