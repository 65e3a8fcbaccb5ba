// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/refinement.h"
#include "batten/fem/surface_assembler.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/embedded_grid.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;

namespace {

using Loop = DomainLoops::Loop;

HermiteCurve straight(const Vec2& p, const Vec2& q) {
  Points positions(2, 3), slopes(2, 3);
  positions << p.x(), p.y(), 0, q.x(), q.y(), 0;
  slopes.row(0) = slopes.row(1) = positions.row(1) - positions.row(0);
  return {{0, 1}, positions, slopes};
}

Loop polygon(const std::vector<Vec2>& corners) {
  Loop loop;
  for (size_t i = 0; i < corners.size(); ++i)
    loop.push_back(straight(corners[i], corners[(i + 1) % corners.size()]));
  return loop;
}

Loop box(const Vec2& low, const Vec2& high) {
  return polygon({low, {high.x(), low.y()}, high, {low.x(), high.y()}});
}

// r = size (1 + waves), a smooth loop around the centre without self-intersections.
HermiteCurve wavy(Random& random, const Vec2& centre, double size, int segments,
                  bool clockwise = false) {
  std::vector<double> a, phase;
  for (int k = 0; k < 4; ++k) {
    a.push_back(0.3 / (k + 2) * random());
    phase.push_back(pi * random());
  }
  const double s = clockwise ? -1 : 1;
  return hermite(0, 2 * pi, segments, true, [=](double t, int order) {
    double r = 1, slope = 0;
    for (int k = 0; k < 4; ++k) {
      r += a[k] * std::cos((k + 1) * t + phase[k]);
      slope -= a[k] * (k + 1) * std::sin((k + 1) * t + phase[k]);
    }
    const Vec2 e(std::cos(t), s * std::sin(t)), n(-std::sin(t), s * std::cos(t));
    const Vec2 p = order == 0 ? Vec2(centre + size * r * e) : Vec2(size * (slope * e + r * n));
    return Vec3(p.x(), p.y(), 0);
  });
}

// ∫ u^i v^j over the inside: by the divergence theorem on the loops alone, and by the trimmed mesh.
double moment(const DomainLoops& loops, int i, int j) {
  static const SegmentRule gauss = gauss_legendre(20);
  double sum = 0;
  for (const PlanarCubic& arc : loops.segments())
    for (long g = 0; g < gauss.s.size(); ++g) {
      const Vec2 c = arc.at(gauss.s[g]), d = arc.slope(gauss.s[g]);
      sum += gauss.weights[g] * std::pow(c.x(), i + 1) / (i + 1) * std::pow(c.y(), j) * d.y();
    }
  return sum;
}
double worst_moment(const ParametricMesh& mesh, const Trim& trim, int degree) {
  MatX sums = MatX::Zero(degree + 1, degree + 1);
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const TriangleRule rule = trim.rule(t, degree);
    const TriangleShape shape = mesh.shape(t);
    for (long p = 0; p < rule.weights.size(); ++p) {
      const Vec2 uv = shape.point(rule.L.row(p));
      for (int i = 0; i <= degree; ++i)
        for (int j = 0; i + j <= degree; ++j)
          sums(i, j) += shape.area * rule.weights[p] * std::pow(uv.x(), i) * std::pow(uv.y(), j);
    }
  }
  double worst = 0;
  for (int i = 0; i <= degree; ++i)
    for (int j = 0; i + j <= degree; ++j)
      worst = std::max(worst, std::abs(sums(i, j) - moment(trim.loops(), i, j)));
  return worst;
}
double sum_of_fractions(const ParametricMesh& mesh, const Trim& trim) {
  double sum = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t) sum += trim.area_fraction(t) * mesh.shape(t).area;
  return sum;
}

// Invariants of every trim of a mesh that covers the loops.
void check_cut(const ParametricMesh& mesh, const DomainLoops& loops, double tolerance = 1e-12) {
  const Trim trim(mesh, loops);
  CHECK(std::abs(sum_of_fractions(mesh, trim) - loops.area()) <= tolerance);
  CHECK(std::abs(trim.area() - loops.area()) <= tolerance);
  double lowest_share = 0, highest_share = 1, lowest = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    lowest_share = std::min(lowest_share, trim.area_fraction(t));
    highest_share = std::max(highest_share, trim.area_fraction(t));
    for (const int degree : {1, 6}) {
      const TriangleRule rule = trim.rule(t, degree);
      if (rule.weights.size() > 0) lowest = std::min(lowest, rule.L.minCoeff());
      CHECK(std::abs(rule.weights.sum() - trim.area_fraction(t)) <= 1e-13);
    }
  }
  CHECK(lowest_share >= -tolerance);
  CHECK(highest_share <= 1 + tolerance);
  CHECK(lowest >= -1e-12);
  CHECK(worst_moment(mesh, trim, 4) <= tolerance);
}

// Winding number around p, of a polygon through many points of the arcs.
int winding_number(const DomainLoops& loops, const Vec2& p, int samples, double& clearance) {
  double turned = 0;
  for (const PlanarCubic& arc : loops.segments())
    for (int i = 0; i < samples; ++i) {
      const Vec2 a = arc.at(static_cast<double>(i) / samples) - p,
                 b = arc.at(static_cast<double>(i + 1) / samples) - p;
      turned += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
      clearance = std::min(clearance, a.norm() - (b - a).norm());
    }
  return static_cast<int>(std::lround(turned / (2 * pi)));
}

ParametricMesh random_grid(int kind, unsigned seed) {
  Random random(seed);
  const int n = 3 + static_cast<int>(seed % 6);
  if (kind == 0) return ParametricMesh::unit_square(n);
  if (kind == 1) return perturbed_square(n, seed);
  ParametricMesh mesh = perturbed_square(n, seed);
  for (int round = 0; round < 3; ++round) {
    std::vector<char> marked;
    for (int t = 0; t < mesh.triangle_count(); ++t) marked.push_back(random() > 0.4);
    mesh = bisected(mesh, marked).mesh;
  }
  return mesh;
}

}  // namespace

TEST_CASE("inside is where loops turn around: random cubics, also level with nodes and turns",
          "[fem][trim]") {
  Random random(17);
  int compared = 0;
  for (int trial = 0; trial < 40; ++trial) {
    // Random positions and slopes: self-intersecting loops also have a winding number.
    const int nodes = 3 + trial % 5;
    std::vector<double> u;
    for (int i = 0; i <= nodes; ++i) u.push_back(i);
    const CurveMesh mesh(u, true);
    Points dofs(mesh.dof_count(), 3);
    for (long i = 0; i < dofs.rows(); ++i) dofs.row(i) << 2 * random(), 2 * random(), 0;
    if (trial % 3 == 0) dofs.col(1) = (2 * dofs.col(1)).array().round() / 2;  // horizontal nodes
    const auto around =
        trial % 2 ? DomainLoops::Background::Inside : DomainLoops::Background::Outside;
    const DomainLoops loops({{HermiteCurve(mesh, dofs)}}, around);
    std::vector<double> levels;
    for (const PlanarCubic& arc : loops.segments()) {
      const BernsteinCubic v{{arc.b[0].y(), arc.b[1].y(), arc.b[2].y(), arc.b[3].y()}};
      for (const double t : v.monotone_parts()) levels.push_back(v.at(t));
    }
    for (int i = 0; i < 120; ++i) {
      Vec2 p(3 * random(), 3 * random());
      if (i % 2) p.y() = levels[static_cast<size_t>(i / 2) % levels.size()];
      double clearance = 1;
      const int times = winding_number(loops, p, 60, clearance);
      if (clearance < 1e-3) continue;
      ++compared;
      INFO("trial " << trial << " p " << p.transpose() << " times " << times);
      CHECK(loops.contains(p) == (times + (trial % 2 ? 1 : 0) > 0));
    }
  }
  CHECK(compared > 3000);
}

TEST_CASE("inside is left of the loop, to a billionth: outlines and holes", "[fem][trim]") {
  Random random(23);
  for (int trial = 0; trial < 30; ++trial) {
    const Vec2 centre(random(), random());
    const DomainLoops loops({{wavy(random, centre, 1, 7 + trial % 5)},
                             {wavy(random, centre, 0.3, 5 + trial % 3, true)}});
    const DomainLoops only_hole({loops.loops()[1]}, DomainLoops::Background::Inside);
    size_t arcs = 0;
    for (const PlanarCubic& arc : loops.segments()) {
      const bool of_hole = arcs++ >= static_cast<size_t>(loops.loops()[0][0].segment_count());
      for (const double t : {0., 1e-9, 0.21, 0.5, 0.77, 1 - 1e-9, 1.}) {
        const Vec2 c = arc.at(t), d = arc.slope(t).normalized(), left(-d.y(), d.x());
        CHECK(loops.contains(c + 1e-9 * left));
        CHECK(!loops.contains(c - 1e-9 * left));
        if (of_hole) CHECK(only_hole.contains(c + 1e-9 * left));
        if (of_hole) CHECK(!only_hole.contains(c - 1e-9 * left));
      }
    }
    CHECK(!loops.contains(centre));
    CHECK(!only_hole.contains(centre));
    CHECK(!loops.contains(centre + Vec2(50, 0)));
    CHECK(!loops.contains(centre - Vec2(50, 0)));
    CHECK(only_hole.contains(centre - Vec2(50, 0)));
  }
  CHECK(DomainLoops().contains({3, 4}));
  CHECK(!DomainLoops(DomainLoops::Background::Outside).contains({3, 4}));
}

TEST_CASE("areas of loops are exact, holes count negative", "[fem][trim]") {
  CHECK(DomainLoops({box({1, 2}, {4, 7})}).area() == Approx(15).epsilon(1e-15));
  CHECK(DomainLoops({box({1, 2}, {4, 7}), polygon({{2, 3}, {2, 4}, {3, 4}, {3, 3}})}).area() ==
        Approx(14).epsilon(1e-15));
  const DomainLoops hole({{circle({5, 6}, 2, 400, true)}}, DomainLoops::Background::Inside);
  CHECK(hole.area() == Approx(-4 * pi).epsilon(1e-9));
  Random random(2);
  for (int trial = 0; trial < 20; ++trial) {
    const DomainLoops loops({{wavy(random, {random(), random()}, 1, 6)}});
    CHECK(std::abs(loops.area() - moment(loops, 0, 0)) < 1e-14);
    CHECK(loops.low().x() < loops.high().x());
    for (const PlanarCubic& arc : loops.segments())
      for (const double t : {0., 0.3, 0.6}) {
        CHECK((arc.at(t) - loops.low()).minCoeff() >= 0);
        CHECK((loops.high() - arc.at(t)).minCoeff() >= 0);
      }
  }
}

TEST_CASE("corners of one closed curve, and pieces that meet nearly, close the loop",
          "[fem][trim]") {
  // The unit square as one curve with four corners.
  const CurveMesh mesh({0, 1, 2, 3, 4}, true, {0, 1, 2, 3});
  const Vec3 at[] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  Points dofs(mesh.dof_count(), 3);
  for (int i = 0; i < 4; ++i) {
    dofs.row(mesh.position_dof(i)) = at[i];
    dofs.row(mesh.slope_in(i)) = at[i] - at[(i + 3) % 4];
    dofs.row(mesh.slope_out(i)) = at[(i + 1) % 4] - at[i];
  }
  const DomainLoops square({{HermiteCurve(mesh, dofs)}});
  CHECK(square.area() == Approx(1).epsilon(1e-15));
  for (const double v : {0.001, 0.5, 0.999}) {
    CHECK(square.contains({0.001, v}));
    CHECK(square.contains({0.999, v}));
    CHECK(!square.contains({1.001, v}));
  }
  // A ray through the tiny gap between two segments.
  const double hair = 5e-10;
  Loop loop;
  const Vec2 corner[] = {{0, 0}, {1, 0.5}, {0, 1}, {-1, 0.5}};
  for (int i = 0; i < 4; ++i)
    loop.push_back(straight(corner[i], corner[(i + 1) % 4] - Vec2(0, hair)));
  const DomainLoops nearly({loop});
  for (const double v : {0.5 - 1.5 * hair, 0.5 - hair, 0.5 - 0.5 * hair, 0.5, 0.5 + hair}) {
    CHECK(nearly.contains({0, v}));
    CHECK(!nearly.contains({-2, v}));
    CHECK(!nearly.contains({2, v}));
  }
}

TEST_CASE("loops that are none are refused", "[fem][trim]") {
  CHECK(error_message([] { DomainLoops({Loop{}}); }).find("has no curves") != std::string::npos);
  Loop open = box({0, 0}, {1, 1});
  open.pop_back();
  CHECK(error_message([&] { DomainLoops({open}); }).find("open at (0, 1)") != std::string::npos);
  Points tilted = circle({0, 0}, 1, 8).dofs();
  tilted(3, 2) = 1e-3;
  CHECK(error_message([&] {
          DomainLoops({{HermiteCurve(circle({0, 0}, 1, 8).mesh(), tilted)}});
        }).find("z = 0") != std::string::npos);
}

TEST_CASE(
    "area fractions of the triangles sum to the area: 200 random loops with holes on three grids",
    "[fem][trim]") {
  Random random(41);
  for (unsigned trial = 0; trial < 200; ++trial) {
    const ParametricMesh mesh = random_grid(static_cast<int>(trial % 3), trial);
    const Vec2 centre(0.5 + 0.05 * random(), 0.5 + 0.05 * random());
    const DomainLoops loops({{wavy(random, centre, 0.28, 5 + static_cast<int>(trial % 20))},
                             {wavy(random, centre, 0.06, 4 + static_cast<int>(trial % 7), true)}});
    const Trim trim(mesh, loops);
    INFO("trial " << trial);
    CHECK(std::abs(sum_of_fractions(mesh, trim) - loops.area()) < 1e-12);
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      const bool listed =
          std::binary_search(trim.cut_triangles().begin(), trim.cut_triangles().end(), t);
      CHECK(listed == (trim.side(t) == Trim::Side::Cut));
      if (trim.side(t) == Trim::Side::Cut) continue;
      CHECK(trim.area_fraction(t) == (trim.side(t) == Trim::Side::Inside ? 1 : 0));
      const Vec2 p = mesh.shape(t).point({0.2, 0.5, 0.3});
      CHECK(loops.contains(p) == (trim.side(t) == Trim::Side::Inside));
    }
  }
}

TEST_CASE("rules over the inside are exact for polynomials of their degree", "[fem][trim]") {
  Random random(43);
  for (unsigned trial = 0; trial < 12; ++trial) {
    const ParametricMesh mesh = random_grid(static_cast<int>(trial % 3), trial + 7);
    const DomainLoops loops({{wavy(random, {0.5, 0.5}, 0.28, 6 + static_cast<int>(trial))},
                             {wavy(random, {0.5, 0.5}, 0.05, 5, true)}});
    const Trim trim(mesh, loops);
    for (int degree = 1; degree <= 8; ++degree) {
      INFO("trial " << trial << " degree " << degree);
      CHECK(worst_moment(mesh, trim, degree) < 1e-12);
    }
    // If an arc bends towards the apex of its cone, weights are negative: this is rare.
    double lowest = 0, negative = 0;
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      const TriangleRule rule = trim.rule(t, 6);
      if (rule.weights.size() == 0) continue;
      lowest = std::min(lowest, rule.L.minCoeff());
      negative -= mesh.shape(t).area * rule.weights.cwiseMin(0.0).sum();
    }
    CHECK(lowest >= -1e-12);
    CHECK(negative < 0.03 * loops.area());
  }
}

TEST_CASE("loops inside one element, through its centroid, vertices and spokes", "[fem][trim]") {
  const ParametricMesh one({{0, 0}, {1, 0}, {0.2, 0.9}}, {{0, 1, 2}});
  const Vec2 centroid(0.4, 0.3);
  Random random(5);
  for (const Vec2& centre : {centroid, Vec2(0.35, 0.15), Vec2(0.3, 0.4), Vec2(0.5, 0.3)})
    for (const double size : {0.1, 0.01, 1e-4}) {
      INFO("centre " << centre.transpose() << " size " << size);
      const double scale = size * size;
      const DomainLoops loops({{wavy(random, centre, size, 6)}});
      const Trim trim(one, loops);
      CHECK(std::abs(trim.area() - loops.area()) <= 1e-11 * scale + 1e-16);
      CHECK(trim.side(0) == Trim::Side::Cut);
      check_cut(one, loops);
      check_cut(one,
                DomainLoops({box({0, 0}, {0.2, 0.2}), {wavy(random, {0.1, 0.1}, 0.03, 7, true)}}),
                1);
    }
  const ParametricMesh& mesh = one;
  const auto& V = mesh.vertices();
  // The element itself, a sub-triangle of it, half of it.
  check_cut(mesh, DomainLoops({polygon({V[0], V[1], V[2]})}));
  check_cut(mesh, DomainLoops({polygon({V[0], V[1], centroid})}));
  check_cut(mesh, DomainLoops({polygon({V[0], V[1], 0.5 * (V[1] + V[2])})}));
  check_cut(mesh, DomainLoops({polygon({V[0], centroid, V[2]})}));
  check_cut(mesh, DomainLoops({polygon({V[0], V[1], centroid, V[2]})}));
}

TEST_CASE("outlines along grid lines, exactly and nearly", "[fem][trim]") {
  const ParametricMesh mesh = squares({-1, -1}, 0.25, 16, 16);
  for (const double off :
       {0., 1e-16, 1e-14, 1e-12, 1e-11, 1e-10, 1e-9, 3e-9, 1e-8, 3e-8, 1e-7, 3e-7, 1e-6, 1e-4})
    for (const double sign : {1., -1.}) {
      const Vec2 d(sign * off, sign * off);
      INFO("off " << d.x());
      const double tolerance = 1e-12;
      {
        INFO("square of whole elements");
        check_cut(mesh, DomainLoops({box(Vec2(-0.5, -0.25) + d, Vec2(1, 0.5) + d)}), tolerance);
        check_cut(mesh, DomainLoops({box(Vec2(-0.5, -0.25) - d, Vec2(1, 0.5) + d)}), tolerance);
      }
      {
        INFO("along the diagonals and across them");
        const Vec2 e(0, sign * off);
        check_cut(mesh, DomainLoops({polygon({Vec2(0, 0) + e, Vec2(1, 1) + e, Vec2(0, 1) + e})}),
                  tolerance);
        check_cut(mesh,
                  DomainLoops({polygon(
                      {Vec2(0, 0) + e, Vec2(1, -0.5) + e, Vec2(1.5, 0.5) + e, Vec2(0.5, 1) + e})}),
                  tolerance);
      }
      {
        INFO("one side on a grid line, the others between");
        check_cut(mesh, DomainLoops({box(Vec2(-0.5, -0.35) + d, Vec2(1.1, 0.6) + d)}), tolerance);
      }
      {
        // Ends on an edge, with another loop in the same element.
        const HermiteCurve small = circle({-0.47, -0.32}, 0.01, 6, true);
        check_cut(mesh, DomainLoops({{small}, box(Vec2(-0.5, -0.35) + d, Vec2(1.1, 0.6) + d)}),
                  tolerance);
        check_cut(mesh,
                  DomainLoops({{small},
                               box(Vec2(-1, -0.9) + d.cwiseAbs(), {-0.5, -0.4}),
                               box({-0.5, -0.35}, Vec2(1.1, 0.6) + d)}),
                  tolerance);
      }
      {
        INFO("a hole of one element's size");
        check_cut(mesh,
                  DomainLoops({box({-0.9, -0.9}, {1.9, 1.9}),
                               polygon({Vec2(0, 0) + d, Vec2(0, 0.25) + d, Vec2(0.25, 0.25) + d,
                                        Vec2(0.25, 0) + d})}),
                  tolerance);
      }
    }
  // Whole elements are not cut.
  const Trim trim(mesh, DomainLoops({box({-0.5, -0.25}, {1, 0.5})}));
  CHECK(trim.cut_triangles().empty());
  CHECK(trim.area() == Approx(1.125).epsilon(1e-15));
}

TEST_CASE("loops that touch element edges", "[fem][trim]") {
  // Four arcs: rotated by 45°, the midpoints of the arcs are tangent.
  const auto round = [](const Vec2& centre, double radius, double turn, int n, bool clockwise) {
    return hermite(0, 2 * pi, n, true, [=](double t, int order) {
      const double a = (clockwise ? -1 : 1) * t + turn, s = clockwise ? -1 : 1;
      return order == 0
                 ? Vec3(centre.x() + radius * std::cos(a), centre.y() + radius * std::sin(a), 0)
                 : Vec3(-s * radius * std::sin(a), s * radius * std::cos(a), 0);
    });
  };
  const ParametricMesh mesh = squares({-1, -1}, 0.5, 6, 6);
  for (const int n : {4, 8, 12, 5})
    for (const double turn : {0., pi / 4, 0.3})
      for (const double off : {0., 1e-15, 1e-12, 1e-10, 1e-9, 1e-8, 3e-8, 1e-7, 1e-6, 1e-5})
        for (const double sign : {-1., 1.}) {
          // The extent of the curve itself to the right.
          HermiteCurve unit = round({0, 0}, 1, turn, n, false);
          double reach = 0;
          for (const PlanarCubic& arc : planar_cubics(unit)) {
            const BernsteinCubic u{{arc.b[0].x(), arc.b[1].x(), arc.b[2].x(), arc.b[3].x()}};
            for (const double t : u.monotone_parts()) reach = std::max(reach, u.at(t));
          }
          for (const double radius : {0.05, 0.2, 0.6})
            for (const double v : {0.15, 0.0}) {
              const Vec2 centre(0.5 - radius * reach + sign * off, v);
              INFO(n << " arcs, turned " << turn << ", off " << sign * off << " radius " << radius
                     << " v " << v);
              check_cut(mesh, DomainLoops({{round(centre, radius, turn, n, false)}}));
              check_cut(mesh, DomainLoops({box({-0.9, -0.9}, {1.9, 1.9}),
                                           {round(centre, radius, turn, n, true)}}));
            }
        }
}

TEST_CASE("corners inside elements, and loops that nearly touch", "[fem][trim]") {
  Random random(61);
  for (unsigned trial = 0; trial < 40; ++trial) {
    const ParametricMesh mesh = random_grid(static_cast<int>(trial % 3), trial);
    const double a = pi * random(), c = std::cos(a), s = std::sin(a);
    const auto turned = [&](double u, double v) {
      return Vec2(0.5 + 0.2 * (c * u - s * v), 0.5 + 0.2 * (s * u + c * v));
    };
    INFO("trial " << trial);
    check_cut(mesh,
              DomainLoops({polygon({turned(-1, -1), turned(1, -1), turned(1, 1), turned(-1, 1)})}));
    // A star with sharp corners.
    std::vector<Vec2> star;
    for (int i = 0; i < 10; ++i) {
      const double r = i % 2 ? 0.6 : 2;
      star.push_back(turned(r * std::cos(i * pi / 5), r * std::sin(i * pi / 5)));
    }
    check_cut(mesh, DomainLoops({polygon(star)}));
    for (const double distance : {1e-2, 1e-5, 1e-8, 1e-10}) {
      INFO("distance " << distance);
      const HermiteCurve left = circle({0.3, 0.5}, 0.2 - distance / 2, 40),
                         right = circle({0.7, 0.5}, 0.2 - distance / 2, 40);
      check_cut(mesh, DomainLoops({{left}, {right}}));
      check_cut(mesh, DomainLoops({{circle({0.5, 0.5}, 0.3, 40)},
                                   {circle({0.5, 0.5}, 0.3 - distance, 40, true)}}));
    }
  }
}

TEST_CASE("a cut of some triangles alone is the same cut", "[fem][trim]") {
  const ParametricMesh mesh = perturbed_square(6, 8);
  const DomainLoops loops({{circle({0.5, 0.5}, 0.31, 20)}, {circle({0.45, 0.5}, 0.1, 9, true)}});
  const Trim whole(mesh, loops);
  std::vector<int> some;
  for (int t = mesh.triangle_count() - 1; t >= 0; --t)
    if (whole.side(t) != Trim::Side::Outside && t % 5 != 1) some.push_back(t);
  std::swap(some[3], some[20]);
  const Trim part = whole.restricted(some);
  std::vector<int> cut;
  for (size_t i = 0; i < some.size(); ++i) {
    const int t = static_cast<int>(i);
    CHECK(part.side(t) == whole.side(some[i]));
    CHECK(part.area_fraction(t) == whole.area_fraction(some[i]));
    if (part.side(t) == Trim::Side::Cut) cut.push_back(t);
    const TriangleRule a = part.rule(t, 5), b = whole.rule(some[i], 5);
    REQUIRE(a.weights.size() == b.weights.size());
    CHECK(a.weights == b.weights);
    CHECK(a.L == b.L);
  }
  CHECK(part.cut_triangles() == cut);
  CHECK(part.loops().segments().size() == loops.segments().size());
}

TEST_CASE("matrices and loads of a trimmed part and of the rest sum to those of the whole",
          "[fem][trim]") {
  const ParametricMesh mesh = perturbed_square(5, 12);
  Random random(7);
  const HermiteCurve curve = wavy(random, {0.5, 0.5}, 0.3, 9);
  const auto inside = std::make_shared<Trim>(mesh, DomainLoops({{curve}}));
  const auto rest = std::make_shared<Trim>(
      mesh, DomainLoops({{curve.backwards()}}, DomainLoops::Background::Inside));
  Points q(DofMap(mesh).count(), 3);
  for (long i = 0; i < q.rows(); ++i) q.row(i) = random.point();
  Mat2 alpha;
  alpha << 3, 0.5, 0.5, 2;
  const SurfaceStiffness bending{}, stretching{alpha, Vec3::Zero()};
  // Exact integrals for HCT functions; those of Z12 are rational.
  for (const TriangleElement kind : kBothElements) {
    const SurfaceAssembler whole(mesh, kind), a(mesh, kind, inside, 0), b(mesh, kind, rest, 0);
    const double tolerance = kind == TriangleElement::HCT ? 1e-11 : 3e-2;
    const auto misfit = [](const auto& x, const auto& y, const auto& sum) {
      return MatX(x + y - sum).norm() / MatX(sum).norm();
    };
    INFO(name(kind));
    CHECK(misfit(a.stiffness(bending), b.stiffness(bending), whole.stiffness(bending)) < tolerance);
    CHECK(misfit(a.stiffness(stretching), b.stiffness(stretching), whole.stiffness(stretching)) <
          tolerance);
    CHECK(misfit(a.mass(), b.mass(), whole.mass()) < tolerance);
    CHECK(misfit(a.load(Vec3(1, 2, 3)), b.load(Vec3(1, 2, 3)), whole.load(Vec3(1, 2, 3))) <
          tolerance);
    const auto wind = [](const Location&, const Vec2& uv) {
      return Vec3(uv.x(), uv.x() * uv.y() * uv.y(), 1);
    };
    CHECK(misfit(a.load(wind), b.load(wind), whole.load(wind)) < tolerance);
    CHECK(misfit(a.pressure_load(q), b.pressure_load(q), whole.pressure_load(q)) < tolerance);
    // Variable stiffness: as accurate as the rule for the whole element.
    const auto field = [](const Vec2& uv) {
      SurfaceStiffness m;
      m.beta = Vec3(1 + uv.x() * uv.y(), 1 + uv.x(), 2);
      m.alpha = Mat2::Identity();
      return m;
    };
    SparseMatrix of_a = a.pattern(), of_b = a.pattern(), of_whole = a.pattern();
    a.stiffness(field, of_a);
    b.stiffness(field, of_b);
    whole.stiffness(field, of_whole);
    CHECK(misfit(of_a, of_b, of_whole) < tolerance);
  }
  // The part outside has a small weight, so that no cut cell is too small.
  const SurfaceAssembler a(mesh, TriangleElement::HCT, inside, 0),
      little(mesh, TriangleElement::HCT, inside, 0.25), whole(mesh, TriangleElement::HCT);
  CHECK((MatX(little.stiffness(bending)) - 0.75 * MatX(a.stiffness(bending)) -
         0.25 * MatX(whole.stiffness(bending)))
            .norm() < 1e-11 * MatX(whole.stiffness(bending)).norm());
}

TEST_CASE("no loops: all of the mesh, or nothing", "[fem][trim]") {
  const ParametricMesh mesh = perturbed_square(3, 1);
  const Trim all(mesh, DomainLoops()), none(mesh, DomainLoops(DomainLoops::Background::Outside));
  CHECK(all.area() == Approx(1).epsilon(1e-14));
  CHECK(none.area() == 0);
  CHECK(all.cut_triangles().empty());
  CHECK(none.rule(0, 4).weights.size() == 0);
  CHECK(all.rule(0, 4).weights.sum() == Approx(1).epsilon(1e-14));
  // Holes alone remove their area from the mesh.
  const DomainLoops hole({{circle({0.5, 0.5}, 0.2, 30, true)}}, DomainLoops::Background::Inside);
  CHECK(Trim(mesh, hole).area() == Approx(1 + hole.area()).epsilon(1e-13));
}

TEST_CASE("a tube is cut on both sides of its seam", "[fem][trim]") {
  // Four columns around, v from 0 to 1.
  std::vector<Vec2> vertices;
  std::vector<ParametricMesh::Triangle> triangles;
  const int n = 6;
  for (int j = 0; j <= 3; ++j)
    for (int i = 0; i < n; ++i) vertices.emplace_back(2.0 * i / n, j / 3.0);
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * n + i, b = j * n + (i + 1) % n;
      triangles.push_back({a, b, b + n});
      triangles.push_back({a, b + n, a + n});
    }
  const ParametricMesh tube(vertices, triangles, 2);
  for (const double u : {0.0, 0.01, 0.2, 1.0, 1.9, 1.99}) {
    INFO("u " << u);
    const DomainLoops hole({{circle({u, 0.5}, 0.3, 12, true)}}, DomainLoops::Background::Inside);
    CHECK(Trim(tube, hole).area() == Approx(2 + hole.area()).epsilon(1e-12));
    const DomainLoops patch({{circle({u, 0.5}, 0.3, 12)}});
    CHECK(Trim(tube, patch).area() == Approx(patch.area()).epsilon(1e-12));
  }
}

TEST_CASE("resistance in a direction counts inside of a cut, constant and varying", "[fem][trim]") {
  const auto mesh = std::make_shared<ParametricMesh>(perturbed_square(5, 2));
  const auto trim = std::make_shared<Trim>(*mesh, DomainLoops({{circle({0.5, 0.5}, 0.35, 12)}}));
  const VecX q = dofs_of(*mesh, [](const Vec2& p) {
    const double u = p.x(), v = p.y();
    return Vec3(u * u + 3 * u * v - v * v, 2 * u + 3 * v, 3 * u - 2 * v);
  });
  const Vec2 t(0.6, -0.8);
  Mat2 hessian;
  hessian << 2, 3, 3, -2;
  const double expected = trim->area() * (1.5 * std::pow(t.dot(hessian * t), 2) + 9 + 4 + 4);
  const auto material =
      SurfaceStiffness::directional(t, 0, 1.5) + SurfaceStiffness{Mat2::Zero(), {1, 0.5, 1}};
  for (const auto kind : kBothElements) {
    const SurfaceAssembler assembler(*mesh, kind, trim, 0);
    SparseMatrix varying = assembler.pattern();
    assembler.stiffness([&](const Vec2&) { return material; }, varying);
    for (const SparseMatrix& K : {assembler.stiffness(material), varying})
      CHECK(q.dot(VecX(K.selfadjointView<Eigen::Lower>() * q)) == Approx(expected).epsilon(1e-9));
  }
}
