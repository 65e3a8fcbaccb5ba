// SPDX-License-Identifier: MPL-2.0
// CalculiX decks represent the surface, ccx runs them unchanged, and their plates agree with plate
// theory.
#include "batten/io/decks/calculix_decks.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <sstream>

#include "batten/core/errors.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/tests/support/calculix_decks.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/dense_algebra.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/test_data.h"
#include "batten/tests/support/trimmed_regions.h"

using namespace batten_test;
namespace fs = std::filesystem;

namespace {

/// X(u, v) and its derivatives on the unit square, with its sides as curves.
using Shape = std::function<SurfaceJet(double u, double v)>;

SkinnedRegion region_of(int n, const Shape& shape, const std::array<std::string, 4>& names) {
  const auto mesh = std::make_shared<const ParametricMesh>(ParametricMesh::unit_square(n));
  const Surface surface =
      interpolated(mesh, TriangleElement::HCT, [&](const Vec2& p) { return shape(p.x(), p.y()); });
  SkinnedRegion region{"plate", surface, {}, 1, {}, {}};
  const std::array<std::array<int, 2>, 4> sides{
      {{0, 1}, {n * (n + 1), 1}, {0, n + 1}, {n, n + 1}}};  // first vertex, step
  for (size_t s = 0; s < 4; ++s) {
    EdgeAlignedLine aligned_line;
    aligned_line.line.name = names[s];
    for (int i = 0; i <= n; ++i) {
      aligned_line.vertices.push_back(sides[s][0] + i * sides[s][1]);
      aligned_line.parameters.push_back(i);
      if (i > 0)
        aligned_line.edges.push_back(
            mesh->edge_between(aligned_line.vertices[i - 1], aligned_line.vertices[i]));
    }
    region.edge_aligned.push_back(aligned_line);
  }
  return region;
}

const std::array<std::string, 4> kSides{"south", "north", "west", "east"};

Shape flat(double a) {
  return [a](double u, double v) {
    const Vec3 o = Vec3::Zero();
    return SurfaceJet{{a * u, a * v, 0}, {a, 0, 0}, {0, a, 0}, o, o, o};
  };
}

/// Doubly curved, with many digits per coordinate and small negative numbers.
SurfaceJet curved(double u, double v) {
  const Vec3 o = Vec3::Zero();
  return {{u - v * v * v / 3e5, v / 3, -1e-5 / 3 * u + 0.3 * u * u - 0.2 * u * v},
          {1, 0, -1e-5 / 3 + 0.6 * u - 0.2 * v},
          {-v * v / 1e5, 1.0 / 3, -0.2 * u},
          o,
          o,
          o};
}

auto everywhere(const Vec3& force) {
  return [force](const std::string&, const Vec3&, const Vec3&) { return force; };
}

ShellDeck plate(double thickness) {
  ShellDeck deck;
  deck.thickness = thickness;
  deck.young = 210000;
  deck.poisson = 0.3;
  deck.units = "mm, N, MPa, t, s";
  for (const auto& side : kSides)
    deck.supports.push_back(ShellDeck::Support::clamped(side));
  return deck;
}

struct MaxDisplacement {
  double magnitude;
  int node;
  Vec3 moved;
};

MaxDisplacement run_ccx(const fs::path& deck) {
  const std::string command =
      "python3 '" BATTEN_SOURCE_DIR "/scripts/ccx_max_displacement' '" + deck.string() + "'";
  FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe);
  std::string line;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) line += static_cast<char>(c);
  REQUIRE(pclose(pipe) == 0);
  MaxDisplacement max_displacement{};
  Vec3 at;
  const int found = std::sscanf(
      line.c_str(), "%lf node %d at (%lf, %lf, %lf) moved (%lf, %lf, %lf)",
      &max_displacement.magnitude, &max_displacement.node, &at[0], &at[1], &at[2],
      &max_displacement.moved[0], &max_displacement.moved[1], &max_displacement.moved[2]);
  REQUIRE(found == 8);
  return max_displacement;
}

std::string message_of(const SkinnedRegion& region, const ShellDeck& deck) {
  try {
    write_calculix(batten_test::scratch("deck_errors") / "deck.inp", {&region}, deck);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a deck holds the surface's own points", "[io][calculix]") {
  const SkinnedRegion region = region_of(3, curved, kSides);
  const fs::path path = batten_test::scratch("deck") / "shell.inp";
  ShellDeck deck = plate(0.02);
  write_calculix(path, {&region}, deck);
  const auto deck_sections = sections(path);
  const ParametricMesh& mesh = region.surface.mesh();
  const auto& nodes = deck_sections.at("*NODE,NSET=NALL");
  const auto& elements = deck_sections.at("*ELEMENT,TYPE=S6,ELSET=ALL");
  REQUIRE(nodes.size() == static_cast<size_t>(mesh.vertex_count() + mesh.edge_count()));
  REQUIRE(elements.size() == static_cast<size_t>(mesh.triangle_count()));
  for (size_t i = 0; i < nodes.size(); ++i) {
    REQUIRE(nodes[i].size() == 4);
    CHECK(nodes[i][0] == std::to_string(i + 1));
    // Text that ccx would truncate.
    for (const auto& field : nodes[i]) CHECK(field.size() <= 20);
  }
  const std::array<Vec3, 6> L{Vec3{1, 0, 0},   Vec3{0, 1, 0},   Vec3{0, 0, 1},
                              Vec3{.5, .5, 0}, Vec3{0, .5, .5}, Vec3{.5, 0, .5}};
  for (size_t t = 0; t < elements.size(); ++t) {
    REQUIRE(elements[t].size() == 7);
    CHECK(elements[t][0] == std::to_string(t + 1));
    for (size_t a = 0; a < 6; ++a) {
      const auto& node = nodes.at(static_cast<size_t>(std::stoi(elements[t][a + 1]) - 1));
      const Vec3 expected = region.surface.position({static_cast<int>(t), L[a]});
      for (int i = 0; i < 3; ++i)
        CHECK(std::stod(node[static_cast<size_t>(i) + 1]) ==
              Approx(expected[i]).epsilon(1e-12).margin(1e-300));
    }
  }
  // The set of each curve: its vertices and mid-side nodes, all on the curve.
  std::set<std::string> west;
  for (const auto& row : deck_sections.at("*NSET,NSET=WEST")) west.insert(row.begin(), row.end());
  CHECK(west.size() == 7);
  for (const auto& id : west)
    CHECK(std::abs(vector_of(nodes[static_cast<size_t>(std::stoi(id) - 1)], 1).z()) < 1e-15);
}

TEST_CASE("set names of curves are accepted by ccx, and distinct", "[io][calculix]") {
  const fs::path path = batten_test::scratch("deck_names") / "shell.inp";
  const std::string lengthy(100, 'a');
  const std::array<std::string, 4> names{"top edge (left)", "Top-edge_left_", "7", lengthy};
  const SkinnedRegion region = region_of(1, flat(1), names);
  ShellDeck deck = plate(0.1);
  deck.supports = {ShellDeck::Support::pinned(lengthy),
                   ShellDeck::Support::clamped("7")};
  write_calculix(path, {&region}, deck);
  const auto found = sections(path);
  for (const std::string name : {"TOP_EDGE__LEFT_", "TOP_EDGE_LEFT_", "CURVE_7"})
    CHECK(found.count("*NSET,NSET=" + name) == 1);
  const std::vector<std::vector<std::string>> expected{{std::string(80, 'A'), "1", "3"},
                                                       {"CURVE_7", "1", "6"}};
  CHECK(found.at("*BOUNDARY") == expected);

  const SkinnedRegion same = region_of(1, flat(1), {"rim", "Rim", "all", "nall"});
  deck.supports = {ShellDeck::Support::pinned("Rim")};
  write_calculix(path, {&same}, deck);
  for (const std::string name : {"RIM", "RIM_2", "ALL_2", "NALL_2"})
    CHECK(sections(path).count("*NSET,NSET=" + name) == 1);
  CHECK(sections(path).at("*BOUNDARY")[0][0] == "RIM_2");
}

TEST_CASE("nodal loads carry the whole force at the right position", "[io][calculix]") {
  const SkinnedRegion region = region_of(4, curved, kSides);
  const fs::path path = batten_test::scratch("deck_loads") / "shell.inp";
  ShellDeck deck = plate(0.02);
  const Vec3 per_area(0.5, -1, 2);
  deck.area_force = everywhere(per_area);
  const Vec3 at = region.surface.position({5, Vec3::Unit(2)});
  deck.point_forces = {{at + Vec3(1e-3, 0, 0), {10, 0, 0}}, {at, {0, 0, 7}}};
  write_calculix(path, {&region}, deck);
  const auto found = sections(path);
  const auto& nodes = found.at("*NODE,NSET=NALL");
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  std::set<std::pair<std::string, std::string>> once;
  for (const auto& load : found.at("*CLOAD")) {
    CHECK(once.insert({load.at(0), load.at(1)}).second);
    Vec3 f = Vec3::Zero();
    f[std::stoi(load.at(1)) - 1] = std::stod(load.at(2));
    force += f;
    moment += vector_of(nodes.at(static_cast<size_t>(std::stoi(load[0]) - 1)), 1).cross(f);
  }
  const Vec3 expected = region.surface.area() * per_area + Vec3(10, 0, 7);
  CHECK((force - expected).norm() < 1e-12 * expected.norm());
  // The moment by exact integration over the surface. The element's geometry is quadratic, as is
  // this surface up to 1e-5: both agree within this.
  Vec3 expected_moment = at.cross(Vec3(10, 0, 7));
  const TriangleRule rule = split_triangle_rule(8);
  for (int t = 0; t < region.surface.mesh().triangle_count(); ++t)
    for (long p = 0; p < rule.weights.size(); ++p) {
      const SurfaceJet j = region.surface.jet({t, rule.L.row(p).transpose()});
      expected_moment += rule.weights[p] * region.surface.mesh().shape(t).area *
                         j.area_vector().norm() * j.x.cross(per_area);
    }
  CHECK((moment - expected_moment).norm() < 1e-6 * expected_moment.norm());
}

TEST_CASE("a clamped square plate bends as in theory, along the normal", "[io][calculix]") {
  const double a = 100, t = 1;
  const SkinnedRegion region = region_of(16, flat(a), kSides);
  const fs::path path = batten_test::scratch("plate") / "plate.inp";
  ShellDeck deck = plate(t);
  const double D = deck.young * t * t * t / (12 * (1 - deck.poisson * deck.poisson));
  const double q = 0.01;
  const double clamped = 0.00126532 * q * std::pow(a, 4) / D;
  const int centre = 8 * 17 + 8 + 1;
  deck.pressure = q;
  write_calculix(path, {&region}, deck);
  if (!have_ccx()) return;
  const MaxDisplacement pressure = run_ccx(path);
  CHECK(pressure.node == centre);
  // ccx's elements are too stiff by 4.3 % at 16 × 16, by 1.3 % at 32 × 32.
  CHECK(pressure.moved.z() == Approx(clamped).epsilon(0.05));

  // Quads (three per triangle) are more accurate; flat triangles of three nodes are far too stiff.
  deck.element = ShellDeck::Element::S8R;
  write_calculix(path, {&region}, deck);
  CHECK(run_ccx(path).moved.z() == Approx(clamped).epsilon(0.02));
  deck.element = ShellDeck::Element::S3;
  write_calculix(path, {&region}, deck);
  const double flat = run_ccx(path).moved.z() / clamped;
  CHECK(flat > 0.05);
  CHECK(flat < 0.95);
  deck.element = ShellDeck::Element::S6;
  // Boundary nodes selected by a box around each side instead of the curves.
  const std::vector<ShellDeck::Support> lines = deck.supports;
  deck.supports.clear();
  const double more = 1e-6 * a;
  for (const auto& [from, to] : {std::pair(Vec3(0, 0, 0), Vec3(a, 0, 0)),
                                 {Vec3(0, a, 0), Vec3(a, a, 0)},
                                 {Vec3(0, 0, 0), Vec3(0, a, 0)},
                                 {Vec3(a, 0, 0), Vec3(a, a, 0)}}) {
    deck.supports.push_back(ShellDeck::Support::clamped(""));
    deck.supports.back().box = Box3(from - Vec3::Constant(more), to + Vec3::Constant(more));
  }
  write_calculix(path, {&region}, deck);
  CHECK(run_ccx(path).moved.z() == Approx(pressure.moved.z()).epsilon(1e-9));
  deck.supports[0].box = Box3(Vec3::Constant(9 * a), Vec3::Constant(10 * a));
  CHECK_THROWS_WITH(write_calculix(path, {&region}, deck),
                    Catch::Matchers::Contains("without nodes"));
  deck.supports = lines;

  // The same load as a force per area and as self-weight.
  deck.pressure = 0;
  deck.area_force = everywhere({0, 0, -q});
  write_calculix(path, {&region}, deck);
  CHECK(run_ccx(path).moved.z() == Approx(-pressure.moved.z()).epsilon(1e-3));
  deck.area_force = {};
  deck.density = 7.85e-9;
  deck.gravity = {0, 0, -q / (deck.density * t)};
  write_calculix(path, {&region}, deck);
  CHECK(run_ccx(path).moved.z() == Approx(-pressure.moved.z()).epsilon(1e-3));

  // A point force at the centre: 0.0056 P a²/D.
  deck.gravity.setZero();
  deck.point_forces = {{{a / 2 + 1, a / 2, 3}, {0, 0, 5}}};
  write_calculix(path, {&region}, deck);
  const MaxDisplacement point = run_ccx(path);
  CHECK(point.node == centre);
  CHECK(point.moved.z() == Approx(0.005612 * 5 * a * a / D).epsilon(0.04));

  // Pinned edges cannot move, but can rotate: 0.00406 q a⁴/D.
  deck.point_forces.clear();
  deck.pressure = -q;
  for (auto& support : deck.supports) support.rotation_axes.clear();
  write_calculix(path, {&region}, deck);
  CHECK(run_ccx(path).moved.z() == Approx(-0.00406235 * q * std::pow(a, 4) / D).epsilon(0.03));
}

TEST_CASE("a curved shell runs as written", "[io][calculix]") {
  const fs::path path = batten_test::scratch("curved shell") / "shell.inp";
  ShellDeck deck = plate(0.01);
  deck.pressure = 1;
  deck.area_force = everywhere({0, 0, -1});
  deck.density = 1;
  deck.gravity = {0, 0, -10};
  deck.point_forces = {{{0.5, 0.15, 0}, {0, 1, 0}}};
  const SkinnedRegion region = region_of(5, curved, kSides);
  write_calculix(path, {&region}, deck);
  if (!have_ccx()) return;
  CHECK(run_ccx(path).magnitude > 0);
}

namespace {

/// A flat ring of outer radius a and concentric inner radius b, embedded in a grid.
SkinnedRegion flat_ring(double a, double b, double spacing) {
  return sheet_region({circle({0, 0}, a, 24), circle({0, 0}, b, 24)}, {}, spacing, 0);
}

}  // namespace

TEST_CASE("a plate with an embedded hole: sets on its curves, loads inside only",
          "[io][calculix]") {
  if (!have_delaunay_mesher()) return;
  // Clamped at its outer edge, free at the hole, under uniform pressure: w = q r⁴/(64 D) + c0 + c1
  // ln r + c2 r² + c3 r² ln r with w = w' = 0 at a, no moment and no shear at b.
  const double a = 100, b = 40, t = 1, q = 0.01;
  const SkinnedRegion region = flat_ring(a, b, 12);
  ShellDeck deck = plate(t);
  deck.supports = {ShellDeck::Support::clamped("rim")};
  deck.area_force = everywhere({0, 0, q});
  const fs::path path = batten_test::scratch("ring") / "ring.inp";
  write_calculix(path, {&region}, deck);
  const auto found = sections(path);
  const auto& nodes = found.at("*NODE,NSET=NALL");
  for (const auto& [name, radius] : {std::pair{"RIM", a}, {"HOLE", b}}) {
    std::set<int> ids;
    for (const auto& row : found.at(std::string("*NSET,NSET=") + name))
      for (const auto& field : row) ids.insert(std::stoi(field));
    CHECK(ids.size() >= 16);
    CHECK(ids.size() % 2 == 0);
    size_t there = 0;
    for (size_t i = 0; i < nodes.size(); ++i) {
      const Vec3 x = vector_of(nodes[i], 1);
      const bool on = std::abs(x.head<2>().norm() - radius) < 1e-4 * radius;
      there += on;
      CHECK(on == (ids.count(static_cast<int>(i) + 1) == 1));
    }
    CHECK(there == ids.size());
  }
  Vec3 force = Vec3::Zero();
  for (const auto& load : found.at("*CLOAD"))
    force[std::stoi(load.at(1)) - 1] += std::stod(load[2]);
  CHECK(force.z() == Approx(q * region.surface.area()).epsilon(1e-4));
  CHECK(std::abs(force.x()) + std::abs(force.y()) == 0);

  if (!have_ccx()) return;
  const double D = deck.young * t * t * t / (12 * (1 - deck.poisson * deck.poisson));
  const double nu = deck.poisson;
  // Unknowns c0 … c3 of w, with derivatives of each function.
  const auto row = [&](double r, int order) {
    const double l = std::log(r);
    Eigen::Vector4d f;
    if (order == 0) f << 1, l, r * r, r * r * l;
    if (order == 1) f << 0, 1 / r, 2 * r, 2 * r * l + r;
    if (order == 2) f << 0, -1 / (r * r), 2, 2 * l + 3;
    if (order == 3) f << 0, 2 / (r * r * r), 0, 2 / r;
    return f;
  };
  const auto particular = [&](double r, int order) {
    const double p[4] = {r * r * r * r, 4 * r * r * r, 12 * r * r, 24 * r};
    return q / (64 * D) * p[order];
  };
  Eigen::Matrix4d A;
  Eigen::Vector4d rhs;
  A.row(0) = row(a, 0);
  rhs[0] = -particular(a, 0);
  A.row(1) = row(a, 1);
  rhs[1] = -particular(a, 1);
  A.row(2) = row(b, 2) + nu / b * row(b, 1);
  rhs[2] = -(particular(b, 2) + nu / b * particular(b, 1));
  A.row(3) = row(b, 3) + row(b, 2) / b - row(b, 1) / (b * b);
  rhs[3] = -(particular(b, 3) + particular(b, 2) / b - particular(b, 1) / (b * b));
  const Eigen::Vector4d c = solve_dense(A, rhs);
  const double expected = particular(b, 0) + row(b, 0).dot(c);
  const MaxDisplacement max_displacement = run_ccx(path);
  CHECK(max_displacement.moved.z() == Approx(expected).epsilon(0.08));
  const Vec3 at = vector_of(nodes.at(static_cast<size_t>(max_displacement.node) - 1), 1);
  CHECK(at.norm() == Approx(b).epsilon(1e-3));
  deck.area_force = {};
  deck.pressure = q;
  write_calculix(path, {&region}, deck);
  CHECK(run_ccx(path).moved.z() == Approx(max_displacement.moved.z()).epsilon(2e-3));
}

TEST_CASE("invalid decks are refused with the reason", "[io][calculix]") {
  using Catch::Matchers::Contains;
  const SkinnedRegion region = region_of(1, flat(1), kSides);
  const ShellDeck good = plate(0.1);
  CHECK(message_of(region, good).empty());
  ShellDeck deck = good;
  deck.supports[0].line = "sooth";
  CHECK_THAT(message_of(region, deck), Contains("'sooth'") && Contains("did you mean 'south'?"));
  deck.supports[0].line = "rim of the plate";
  CHECK_THAT(message_of(region, deck), Contains("south, north, west, east"));
  deck = good;
  deck.supports.clear();
  CHECK_THAT(message_of(region, deck), Contains("no support"));
  deck = good;
  deck.thickness = 0;
  CHECK_THAT(message_of(region, deck), Contains("thickness 0"));
  deck = good;
  deck.young = -1;
  CHECK_THAT(message_of(region, deck), Contains("Young's modulus -1"));
  deck = good;
  deck.poisson = 0.5;
  CHECK_THAT(message_of(region, deck), Contains("Poisson's ratio 0.5"));
  deck = good;
  deck.gravity = {0, 0, -9.81};
  CHECK_THAT(message_of(region, deck), Contains("a density of 0"));
  deck = good;
  deck.pressure = std::nan("");
  CHECK_THAT(message_of(region, deck), Contains("pressure nan"));
}
