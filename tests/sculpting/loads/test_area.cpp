// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/surface_assembler.h"
#include "batten/sculpting/loads/loads.h"
#include "batten/skinning/model/model_layout.h"

#include <cmath>

#include "batten/skinning/domains/mesher.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/reference_energy.h"
#include "batten/tests/support/reference_static_solver.h"
#include "batten/tests/support/sample_lines.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten_test;
using namespace batten::reference_solver;
using Catch::Matchers::Contains;

namespace {

SkinOptions fine(double edge) {
  SkinOptions options;
  options.edge_length = edge;
  if (!have_delaunay_mesher()) options.mesher = SkinOptions::Mesher::Fan;
  return options;
}

struct Skinned {
  RegionLayout layout;
  Surface shape;
  Skinned(const std::vector<CharacterLine>& lines, const SkinOptions& options)
      : layout("region", lines, options),
        shape(layout.region(sculpt(layout, layout.line_constraints(), {}, {}).dofs).surface) {}
};

double bump(double ratio) { return ratio < 1 ? std::pow(1 - ratio * ratio, 2) : 0; }

// The mean of w(x) over a triangle from many points.
template <class Weight>
double mean(const Surface& shape, int t, const Weight& w) {
  const TriangleRule rule = split_triangle_rule(8);
  double sum = 0;
  for (long p = 0; p < rule.weights.size(); ++p)
    sum += rule.weights[p] * w(shape.position({t, rule.L.row(p).transpose()}));
  return sum;
}

template <class Weight>
double worst(const VecX& found, const Surface& shape, const Weight& w) {
  double largest = 0;
  for (int t = 0; t < shape.mesh().triangle_count(); t += 3)
    largest = std::max(largest, std::abs(found[t] - mean(shape, t, w)));
  return largest;
}

}  // namespace

TEST_CASE("near a curve, weights are the bump function of the distance to it",
          "[sculpting][loads]") {
  const Skinned region(curved_polygon(4, 0.2, 0.15), fine(0.1));
  for (const double radius : {0.3, 1.0}) {
    const VecX w =
        triangle_weights({Area::NearLine{"side 2", radius}}, region.layout, region.shape);
    const HermiteCurve& line = region.layout.line("side 2");
    CHECK(worst(w, region.shape, [&](const Vec3& x) {
            return bump(line.closest_point(x).distance / radius);
          }) < 3e-3);
    CHECK(w.maxCoeff() > 0.9);
    CHECK(w.minCoeff() == 0);
  }
  CHECK(triangle_weights({}, region.layout, region.shape) ==
        VecX::Ones(region.layout.mesh()->triangle_count()));
}

TEST_CASE("strokes add up to 1 at most, and an eraser takes away what was there before",
          "[sculpting][loads]") {
  const Skinned region(curved_polygon(5, 0.1, 0.05), fine(0.1));
  const Vec3 a(0.2, 0.1, 0), b(0.35, 0.2, 0.05);
  const auto weights = [&](const std::vector<Area::Painted::Stroke>& strokes) {
    return triangle_weights({Area::Painted{strokes}}, region.layout, region.shape);
  };
  const auto at = [](const Vec3& x, const Vec3& centre, double radius) {
    return bump((x - centre).norm() / radius);
  };
  CHECK(worst(weights({{a, 0.5}}), region.shape, [&](const Vec3& x) { return at(x, a, 0.5); }) <
        2e-3);
  CHECK(worst(weights({{a, 0.5}, {b, 0.4, 0.8}}), region.shape, [&](const Vec3& x) {
          return std::min(1.0, at(x, a, 0.5) + 0.8 * at(x, b, 0.4));
        }) < 5e-3);
  CHECK(worst(weights({{a, 0.5}, {b, 0.4, -0.8}}), region.shape, [&](const Vec3& x) {
          return std::max(0.0, at(x, a, 0.5) - 0.8 * at(x, b, 0.4));
        }) < 5e-3);
  // An eraser at first removes nothing.
  CHECK(weights({{b, 0.4, -0.8}, {a, 0.5}}) == weights({{a, 0.5}}));
  CHECK(weights({{a, 0.5, 30}}).maxCoeff() <= 1);
  CHECK(weights({{a, 0.5, 30}}).maxCoeff() > 0.999);
}

TEST_CASE("weights are the same on any number of threads", "[sculpting][loads]") {
  const Skinned region(curved_polygon(4, 0.2, 0.15), fine(0.08));
  const Area near{Area::NearLine{"side 1", 0.5}};
  const ThreadGuard one(1);
  const VecX w = triangle_weights(near, region.layout, region.shape);
  const auto directions = triangle_directions("side 1", region.layout);
  set_thread_count(2);
  CHECK(triangle_weights(near, region.layout, region.shape) == w);
  CHECK(triangle_directions("side 1", region.layout) == directions);
}

TEST_CASE("directions are those of the nearest point of the curve's pcurve", "[sculpting][loads]") {
  if (!have_delaunay_mesher()) return;
  constexpr double pi = std::numbers::pi;
  // A flat disc, whose domain is the plane itself: around its centre, and along an arc inside.
  const auto loop = [&](double radius, CharacterLine::Role role, const std::string& line_name) {
    return CharacterLine{
        line_name,
        curve_from_formula(0, 2 * pi,
                           [=](double t, int order) -> Vec3 {
                             const double s = t + order * pi / 2;
                             return {radius * std::cos(s), radius * std::sin(s), 0};
                           }),
        role};
  };
  const Skinned disc({loop(1, CharacterLine::Role::Outline, "rim"),
                      loop(0.5, CharacterLine::Role::Inner, "inner")},
                     fine(0.15));
  for (const std::string line : {"rim", "inner"}) {
    const auto directions = triangle_directions(line, disc.layout);
    double off = 0;
    for (int t = 0; t < disc.layout.mesh()->triangle_count(); ++t) {
      const Vec3 x = disc.shape.position({t, Vec3::Constant(1.0 / 3)});
      if (x.norm() < 0.1) continue;
      const Vec2 tangent = Vec2(-x.y(), x.x()).normalized();
      off = std::max(off, 1 - std::abs(tangent.dot(directions[static_cast<size_t>(t)])));
      CHECK(directions[static_cast<size_t>(t)].norm() == Approx(1).epsilon(1e-14));
    }
    CHECK(off < 1e-3);
  }
}

TEST_CASE("on an annulus, directions run around it", "[sculpting][loads]") {
  constexpr double pi = std::numbers::pi;
  const auto rim = [&](double z, const std::string& line_name) {
    return CharacterLine{line_name, curve_from_formula(0, 2 * pi, [=](double t, int order) -> Vec3 {
                           const double s = t + order * pi / 2;
                           return {std::cos(s), std::sin(s), order == 0 ? z : 0};
                         })};
  };
  const Skinned tube({rim(0, "lower"), rim(1, "upper")}, fine(0.3));
  for (const Vec2& d : triangle_directions("upper", tube.layout)) {
    CHECK(std::abs(d.x()) == Approx(1).epsilon(1e-12));
    CHECK(std::abs(d.y()) < 1e-12);
  }
}

TEST_CASE("resistance in a direction is a part of the energy, in either units",
          "[sculpting][loads]") {
  const Skinned region(curved_polygon(4, 0.2, 0.15), fine(0.3));
  const SurfaceAssembler assembler(*region.layout.mesh(), region.layout.element());
  const Points& q = region.shape.dofs();
  const auto along = SurfaceStiffness::directional({0.6, 0.8}, 0.5, 2),
             all = SurfaceStiffness::isotropic(1, 3);
  const SurfaceEnergy sum = energy(assembler, along + all, q), first = energy(assembler, along, q),
                      second = energy(assembler, all, q);
  const SparseMatrix K = assembler.stiffness({Mat2::Zero(), along.beta, along.beta_mixed});
  CHECK(first.bending ==
        Approx(0.5 * q.cwiseProduct(Points(K.selfadjointView<Eigen::Lower>() * q)).sum())
            .epsilon(1e-10));
  CHECK(sum.bending == Approx(first.bending + second.bending).epsilon(1e-10));
  CHECK(sum.stretching == Approx(first.stretching + second.stretching).epsilon(1e-10));
  const double size = 20;
  const auto scaled = scaled_to_unit_domain(along, LoadUnits::Absolute, size);
  CHECK(energy(assembler, scaled, q).bending ==
        Approx(first.bending / (size * size)).epsilon(1e-10));
  CHECK(scaled_to_unit_domain(along, LoadUnits::Relative, size).beta_mixed == along.beta_mixed);
}

TEST_CASE("invalid areas are refused with the reason", "[sculpting][loads]") {
  const Skinned region(curved_polygon(4, 0.2, 0.15), fine(0.3));
  const auto said = [&](const Area& area) {
    return error_message([&] { triangle_weights(area, region.layout, region.shape); });
  };
  using Stroke = Area::Painted::Stroke;
  CHECK_THAT(said({Area::NearLine{"sde 2", 1}}), Contains("did you mean 'side"));
  CHECK_THAT(said({Area::NearLine{"side 2", 0}}), Contains("radius 0"));
  CHECK_THAT(said({Area::NearLine{"side 2", std::nan("")}}), Contains("radius"));
  CHECK_THAT(said({Area::Painted{}}), Contains("has no strokes"));
  CHECK_THAT(said({Area::Painted{{Stroke{Vec3::Zero(), -1}}}}), Contains("radius -1"));
  CHECK_THAT(said({Area::Painted{{Stroke{Vec3::Constant(std::nan("")), 1}}}}), Contains("finite"));
  CHECK_THAT(said({Area::Painted{{Stroke{Vec3::Zero(), 1, std::nan("")}}}}), Contains("finite"));
  CHECK_THAT(error_message([&] { triangle_directions("sde 2", region.layout); }),
             Contains("did you mean 'side"));
  const Skinned other(curved_polygon(4, 0.2, 0.15), fine(0.15));
  CHECK_THAT(error_message([&] { triangle_weights({}, region.layout, other.shape); }),
             Contains("triangles"));
}
