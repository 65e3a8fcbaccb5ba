// SPDX-License-Identifier: MPL-2.0
// Fairing in stages: whole curves, parts of them, and samples of given curves.
#include "batten/fairing/curves/staged_fairing.h"

#include <cmath>
#include <numbers>
#include <random>

#include "batten/fairing/curves/fair_curve.h"
#include "batten/fairing/curves/primitive_curves.h"
#include "batten/skinning/lines/character_line.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"

using namespace batten;
using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

using std::numbers::pi;

/// A sine wave of length 4 with noise, moved to y = `y`.
CurveSamples wave(const std::string& name, double y, double noise = 0.01) {
  std::mt19937 engine(7);
  std::normal_distribution<double> gauss(0, 1);
  CurveSamples samples{name};
  for (int i = 0; i <= 80; ++i) {
    const double x = 4.0 * i / 80;
    samples.points.emplace_back(x, y + 0.5 * std::sin(x) + noise * gauss(engine), 0);
  }
  return samples;
}

FairStage smoothing(double wavelength) {
  FairStage stage;
  stage.options.smoothing = FairOptions::Smoothing::Wavelength;
  stage.options.wavelength = wavelength;
  return stage;
}

bool equal(const HermiteCurve& a, const HermiteCurve& b) {
  return a.parameters() == b.parameters() && a.dofs() == b.dofs();
}

}  // namespace

TEST_CASE("without stages the result is the interpolating spline", "[fairing][curves]") {
  const CurveSamples samples = wave("w", 0);
  const auto results = fair_in_stages({samples}, {});
  REQUIRE(results.size() == 1);
  REQUIRE(results[0].states.size() == 1);
  CHECK(equal(results[0].states[0], interpolating_spline("w", samples.points)));
  CHECK_FALSE(results[0].report.faired);
  CHECK(results[0].report.deviation.max < 1e-12);
  CHECK(results[0].report.points == 81);
}

TEST_CASE("a stage for whole curves is fair_points(), and leaves the other curves",
          "[fairing][curves]") {
  const std::vector<CurveSamples> curves = {wave("a", 0), wave("b", 2)};
  FairStage stage = smoothing(0.8);
  stage.curves = {1};
  const auto results = fair_in_stages(curves, {stage});
  CHECK(equal(results[0].states[1], results[0].states[0]));
  CHECK(equal(results[1].states[1], fair_points("b", curves[1].points, stage.options).curve));
  CHECK_FALSE(results[0].report.faired);
  const FairedLine& report = results[1].report;
  CHECK(report.faired);
  CHECK(report.wavelength == Approx(0.8));
  CHECK(report.after->extrema < report.before->extrema);
  CHECK(report.was_noisy(true));
  CHECK_FALSE(results[0].report.was_noisy(true));
}

TEST_CASE("a brush changes only what is inside of its sphere", "[fairing][curves]") {
  const std::vector<CurveSamples> curves = {wave("a", 0), wave("b", 5)};
  FairStage brush = smoothing(0.8);
  brush.brush = {{2, 0.45, 0}, 0.5};
  const auto results = fair_in_stages(curves, {brush});
  CHECK(equal(results[1].states[1], results[1].states[0]));
  const HermiteCurve &before = results[0].states[0], &after = results[0].states[1];
  CHECK(after.evaluate(0.1) == before.evaluate(0.1));
  CHECK(results[0].report.deviation.max > 1e-4);

  brush.brush->at = {2, 100, 0};
  brush.where = "scene.toml:3:1: ";
  CHECK_THAT(error_message([&] { fair_in_stages(curves, {brush}); }),
             Contains("scene.toml:3:1: found a brush that meets none"));
}

TEST_CASE("a segment belongs to the nearest curve", "[fairing][curves]") {
  const std::vector<CurveSamples> curves = {wave("a", 0), wave("b", 2)};
  FairStage stage = smoothing(0.8);
  stage.segment = {{1, 2.4, 0}, {2.5, 2.3, 0}};
  const auto results = fair_in_stages(curves, {stage});
  CHECK_FALSE(results[0].report.faired);
  CHECK(results[1].report.faired);
  stage.segment->to = stage.segment->from;
  CHECK_THAT(error_message([&] { fair_in_stages(curves, {stage}); }), Contains("zero length"));
}

TEST_CASE("corners of a stage split the curve at the nearest points", "[fairing][curves]") {
  FairStage stage = smoothing(0.8);
  stage.corners = {{2, 0.5, 0}};
  const auto results = fair_in_stages({wave("a", 0)}, {stage});
  CHECK(results[0].states[1].mesh().corners().size() == 1);
}

TEST_CASE("fewer segments stay within the tolerance of the faired curve", "[fairing][curves]") {
  const auto fine = fair_in_stages({wave("a", 0)}, {smoothing(0.8)});
  const auto few = fair_in_stages({wave("a", 0)}, {smoothing(0.8)}, 1e-3);
  const HermiteCurve &curve = few[0].states.back(), &faired = fine[0].states.back();
  CHECK(curve.segment_count() < faired.segment_count());
  for (int i = 0; i <= 100; ++i) {
    const double u = curve.start() + (curve.end() - curve.start()) * i / 100;
    CHECK(faired.closest_point(curve.evaluate(u)).distance < 1.1e-3);
  }
}

TEST_CASE("curves that cannot be faired have a reason and no states", "[fairing][curves]") {
  CurveSamples point{"p"}, same{"s"}, two{"t"};
  point.points = {{1, 2, 3}};
  same.points = {{1, 2, 3}, {1, 2, 3}};
  two.points = {{0, 0, 0}, {1, 0, 0}};
  FairStage closed = smoothing(0.8);
  closed.curves = {2};
  closed.options.closed = true;
  const auto results = fair_in_stages({point, same, two}, {closed});
  CHECK(results[0].rejection_reason == "only one point");
  CHECK(results[1].rejection_reason == "zero length");
  CHECK(results[2].rejection_reason == "too few points for a closed curve");
  for (const StagedFairingResult& result : results) CHECK_FALSE(result.has_curve());
  closed.curves = {3};
  CHECK_THAT(error_message([&] { fair_in_stages({two}, {closed}); }), Contains("curve number 3"));
}

TEST_CASE("the curve of minimum variation through points of a circle is the circle",
          "[fairing][curves]") {
  if (!have_curvature_fairing()) return;
  CurveSamples samples{"c"};
  for (int i = 0; i <= 8; ++i)
    samples.points.emplace_back(std::cos(pi * i / 4), std::sin(pi * i / 4), 0);
  samples.points.back() = samples.points.front();
  FairStage stage;
  stage.minimum = CurveFunctional::Variation;
  const auto results = fair_in_stages({samples}, {stage});
  const HermiteCurve& circle = results[0].states[1];
  CHECK(circle.closed());
  for (int i = 0; i < 50; ++i)
    CHECK(circle.evaluate(circle.start() + (circle.end() - circle.start()) * i / 50).norm() ==
          Approx(1).margin(1e-5));
  samples.points = wave("c", 0).points;
  while (samples.points.size() <= 200)
    samples.points.emplace_back(samples.points.back() + Vec3(0.1, 0, 0));
  CHECK_THAT(error_message([&] { fair_in_stages({samples}, {stage}); }),
             Contains("201 points of 'c'"));
}

TEST_CASE("samples of given curves are even, closed and have the corners", "[fairing][curves]") {
  const CurvePlane plane = curve_plane(Vec3::Zero(), Vec3::UnitZ(), Vec3::UnitX());
  const CurveSamples circle = sample_line({"c", ellipse_arc(plane, 2, 2, 0, 2 * pi)}, 50);
  CHECK(circle.closed == true);
  CHECK(circle.corners->empty());
  CHECK(circle.points.size() >= 200);
  CHECK(circle.extra_points.size() == 3 * (circle.points.size() - 1));
  const double step = 2 * 2 * std::sin(pi / static_cast<double>(circle.points.size() - 1));
  for (size_t i = 1; i < circle.points.size(); ++i)
    CHECK((circle.points[i] - circle.points[i - 1]).norm() == Approx(step).epsilon(1e-6));
  const CurveSamples rectangle = sample_line({"r", batten::rectangle(plane, 4, 2, 0)}, 50);
  CHECK(rectangle.closed == true);
  CHECK(rectangle.corners->size() == 4);
  for (const int i : *rectangle.corners)
    CHECK(rectangle.points[i].cwiseAbs().isApprox(Vec3(2, 1, 0), 1e-9));

  std::vector<FairStage> stages = {smoothing(1), smoothing(1)};
  stages[0].curves = {1};
  stages[0].options.corner_angle = 30;
  stages[1].options.corner_angle = 40;
  CHECK(corner_angle_of(stages, 0) == 40);
  CHECK(corner_angle_of(stages, 1) == 30);
  CHECK(corner_angle_of({}, 0) == FairOptions{}.corner_angle);
}
