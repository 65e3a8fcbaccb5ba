// SPDX-License-Identifier: MPL-2.0
// Local fairing: joins with continuous curvature, and no additional curvature extrema.
#include "batten/fairing/curves/local_fairing.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "batten/core/errors.h"
#include "batten/fairing/curves/fair_curve.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"

using namespace batten;
using namespace batten_test;

namespace {

using std::numbers::pi;

double bump(double t, double at, double width) {
  return std::exp(-(t - at) * (t - at) / (width * width));
}

HermiteCurve through(const std::function<Vec3(double)>& curve, double end, int pieces,
                     bool closed = false) {
  std::vector<Vec3> points;
  for (int i = 0; i <= pieces; ++i) points.push_back(curve(end * i / pieces));
  if (closed) points.back() = points.front();
  return interpolating_spline("curve", points);
}

struct Bumpy {
  HermiteCurve curve;
  Vec3 at;
};

/// Curves with one bump each: a line, an arc, a parabola, a wave, a helix, a closed oval.
std::vector<Bumpy> bumpy_curves(int pieces) {
  const auto line = [](double t) { return Vec3(t, 0.3 * bump(t, 5, 0.5), 0); };
  const auto arc = [](double t) -> Vec3 {
    return (5 + 0.05 * bump(t, 5, 0.5)) * Vec3(std::sin(t / 5), std::cos(t / 5), 0);
  };
  const auto parabola = [](double t) {
    return Vec3(t, 0.05 * (t - 5) * (t - 5) + 0.05 * bump(t, 5.8, 0.5), 0);
  };
  const auto wave = [](double t) {
    return Vec3(t, std::sin(t * pi / 5) + 0.05 * bump(t, 3, 0.5), 0);
  };
  const auto helix = [](double t) {
    return Vec3(3 * std::cos(t), 3 * std::sin(t) + 0.05 * bump(t, 3, 0.2), t);
  };
  const auto oval = [](double t) {
    const double b = 0.05 * bump(t, 1.5, 0.12);
    return Vec3((6 + b) * std::cos(t), (3 + b) * std::sin(t), 0);
  };
  return {{through(line, 10, pieces), line(5)},
          {through(arc, 10, pieces), arc(5)},
          {through(parabola, 10, pieces), parabola(5.8)},
          {through(wave, 10, pieces), wave(3)},
          {through(helix, 6, pieces), helix(3)},
          {through(oval, 2 * pi, pieces, true), oval(1.5)}};
}

/// Largest jump of the curvature at the nodes, over the largest curvature.
double relative_jump(const HermiteCurve& curve) {
  const Fairness f = fairness(curve);
  return f.largest_jump / f.largest_curvature;
}

}  // namespace

TEST_CASE("local fairing adds no curvature extrema and no jumps of curvature",
          "[fairing][curves]") {
  for (const int pieces : {40, 60, 200})
    for (const Bumpy& given : bumpy_curves(pieces)) {
      const Fairness before = fairness(given.curve);
      for (const double radius : {0.6, 1.0, 1.5, 2.5, 4.0})
        for (const double wavelength : {0.5, 1.0, 2.0, 4.0, 8.0, 100.0}) {
          INFO(pieces << " pieces, radius " << radius << ", wavelength " << wavelength);
          const HermiteCurve after = fair_brush(given.curve, given.at, radius, wavelength);
          CHECK(fairness(after, before.largest_curvature).extrema <= before.extrema);
          CHECK(relative_jump(after) < 1e-6);
          CHECK(fairness(after).largest_curvature < 1.2 * before.largest_curvature);
        }
    }
}

TEST_CASE("a bump inside of the brush disappears", "[fairing][curves]") {
  // An arc remains an arc: its curvature 0.2 after the bump of curvature 0.6.
  const Bumpy arc = bumpy_curves(200)[1];
  const HermiteCurve after = fair_brush(arc.curve, arc.at, 3.5, 20);
  double highest = 0;
  for (int i = 0; i <= 500; ++i)
    highest = std::max(highest, std::abs(after.evaluate(after.end() * i / 500).norm() - 5));
  CHECK(highest < 0.01);
  CHECK(fairness(after).largest_curvature == Approx(0.2).epsilon(0.03));
  CHECK(fairness(after).variation < 1e-3 * fairness(arc.curve).variation);
}

TEST_CASE("local fairing keeps half of a wave of its wavelength", "[fairing][curves]") {
  // Long waves remain, short ones disappear: 1 / (1 + (wavelength/v)⁶).
  for (const double v : {1.0, 2.0, 4.0}) {
    const double height = 1e-3;
    const HermiteCurve given =
        through([&](double t) { return Vec3(t, height * std::sin(2 * pi * t / v), 0); }, 40, 640);
    const HermiteCurve after = fair_interval(given, 8, 32, 2);
    double kept = 0;
    for (int i = 0; i <= 400; ++i)
      kept = std::max(kept, std::abs(after.evaluate(given.end() * (0.45 + 0.1 * i / 400)).y()));
    CHECK(kept / height == Approx(1 / (1 + std::pow(2 / v, 6))).margin(0.03));
  }
}

TEST_CASE("local fairing leaves the rest of the curve, its ends and its corners",
          "[fairing][curves]") {
  std::mt19937 engine(3);
  std::normal_distribution<double> gauss(0, 0.01);
  std::vector<Vec3> points;
  for (int i = 0; i <= 80; ++i)
    points.emplace_back(i <= 40 ? 0.1 * i : 4, i <= 40 ? gauss(engine) : 0.1 * (i - 40),
                        gauss(engine));
  FairOptions options;
  options.corners = std::vector<int>{40};
  const HermiteCurve given = interpolating_spline("bent", points, options);
  REQUIRE(given.mesh().corners().size() == 1);
  const Vec3 corner = given.position(given.mesh().corners()[0]);
  // Across the corner.
  const HermiteCurve across = fair_brush(given, corner, 1.5, 1);
  REQUIRE(across.mesh().corners().size() == 1);
  CHECK(across.position(across.mesh().corners()[0]) == corner);
  CHECK(relative_jump(across) < 1e-6);
  CHECK(fairness(across).bending < 0.8 * fairness(given).bending);
  // A part that ends at the corner: the tangent there is free, and the other side stays.
  const double at = given.parameters()[given.mesh().corners()[0]];
  const HermiteCurve one_side = fair_part(given, {at - 2, at}, 1);
  CHECK(one_side.mesh().corners().size() == 1);
  CHECK(one_side.evaluate(at + 0.5) == given.evaluate(at + 0.5));
  CHECK((one_side.evaluate(at - 0.5) - given.evaluate(at - 0.5)).norm() > 1e-4);
  // Over both ends of the curve.
  const HermiteCurve whole = fair_brush(given, corner, 100, 1);
  CHECK(whole.position(0) == given.position(0));
  CHECK(whole.position(whole.node_count() - 1) == given.position(given.node_count() - 1));
  CHECK(fairness(whole).bending < 0.2 * fairness(given).bending);
}

TEST_CASE("a closed curve inside of a brush is faired all around", "[fairing][curves]") {
  std::mt19937 engine(5);
  std::normal_distribution<double> gauss(0, 0.01);
  std::vector<Vec3> points;
  for (int i = 0; i < 120; ++i) {
    const double a = 2 * pi * i / 120, r = 3 + gauss(engine);
    points.emplace_back(r * std::cos(a), r * std::sin(a), gauss(engine));
  }
  FairOptions options;
  options.closed = true;
  const HermiteCurve given = interpolating_spline("ring", points, options);
  const HermiteCurve after = fair_brush(given, Vec3::Zero(), 10, 4);
  CHECK(after.closed());
  CHECK(relative_jump(after) < 1e-6);
  for (int i = 0; i < 100; ++i)
    CHECK(after.evaluate(after.end() * i / 100).norm() == Approx(3).epsilon(0.01));
  // A part across the seam is faired as the same part elsewhere.
  const double quarter = 0.25 * given.end();
  const HermiteCurve seam = fair_interval(given, 3 * quarter, quarter, 2);
  CHECK(seam.evaluate(2 * quarter) == given.evaluate(2 * quarter));
  CHECK(relative_jump(seam) < 1e-6);
  std::vector<Vec3> turned(points.begin() + 60, points.end());
  turned.insert(turned.end(), points.begin(), points.begin() + 60);
  const HermiteCurve other = interpolating_spline("ring", turned, options);
  const double from = other.closest_point(given.evaluate(3 * quarter)).u,
               to = other.closest_point(given.evaluate(quarter)).u;
  REQUIRE(from < to);
  const HermiteCurve inside = fair_interval(other, from, to, 2);
  for (int i = 0; i <= 50; ++i)
    CHECK(seam.closest_point(inside.evaluate(from + (to - from) * i / 50)).distance < 1e-6);
}

TEST_CASE("borders of a part may lie anywhere, also next to nodes", "[fairing][curves]") {
  const Bumpy given = bumpy_curves(60)[3];
  const double node = given.curve.parameters()[12];
  HermiteCurve before;
  for (const double off : {-1e-3, -1e-6, -1e-9, -1e-13, 0.0, 1e-13, 1e-9, 1e-6, 1e-3}) {
    const HermiteCurve after = fair_part(given.curve, {node + off, node + 3}, 2);
    CHECK(relative_jump(after) < 1e-6);
    // The curve depends continuously on the border.
    if (off > -1e-3)
      for (int i = 0; i <= 100; ++i)
        CHECK((after.evaluate(node + 0.03 * i) - before.evaluate(node + 0.03 * i)).norm() < 1e-4);
    before = after;
  }
}

TEST_CASE("parts inside of a sphere", "[fairing][curves]") {
  std::vector<Vec3> points;
  for (int i = 0; i < 60; ++i)
    points.emplace_back(3 * std::cos(pi * i / 30), 3 * std::sin(pi * i / 30), 0);
  FairOptions options;
  options.closed = true;
  const HermiteCurve ring = interpolating_spline("ring", points, options);
  // Across the seam.
  const auto seam = parts_inside(ring, {3, 0, 0}, 1);
  REQUIRE(seam.size() == 1);
  CHECK(seam[0].to > ring.end());
  CHECK(part_length(ring, seam[0]) == Approx(3 * 4 * std::asin(1.0 / 6)).epsilon(1e-4));
  CHECK(parts_inside(ring, {0, 0, 0}, 1).empty());
  const auto all = parts_inside(ring, {0, 0, 0}, 4);
  REQUIRE(all.size() == 1);
  CHECK(part_length(ring, all[0]) == Approx(ring.length()));
  // Two parts, and a part far shorter than a segment.
  CHECK(parts_inside(ring, {0, 0, 0.5}, 3.02).empty());
  CHECK(parts_inside(ring, {0, 3.2, 0}, 3).size() == 1);
  const auto tiny = parts_inside(ring, ring.evaluate(1.2345), 1e-5);
  REQUIRE(tiny.size() == 1);
  CHECK(part_length(ring, tiny[0]) == Approx(2e-5).epsilon(1e-3));
}

TEST_CASE("parts that do not exist are refused", "[fairing][curves]") {
  const HermiteCurve line = through([](double t) { return Vec3(t, 0, 0); }, 10, 4);
  CHECK_THROWS_AS(fair_part(line, {3, 3}, 1), InputError);
  CHECK_THROWS_AS(fair_part(line, {1, 3}, 0), InputError);
  CHECK_THROWS_AS(fair_part(line, {1, NAN}, 1), InputError);
}
