// SPDX-License-Identifier: MPL-2.0
// A deck of several faces is one shell: edges match, loads and reactions are complete.
#include <cmath>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/io/decks/calculix_decks.h"
#include "batten/io/lines/drawing.h"
#include "batten/io/scene/scene.h"
#include "batten/sculpting/session/sculpting_session.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/search/find_regions.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/skinning/surfaces/surface_model.h"
#include "batten/tests/support/calculix_decks.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/mouse_model.h"
#include "batten/tests/support/sample_networks.h"
#include "batten/tests/support/test_data.h"

using namespace batten_test;
namespace fs = std::filesystem;

namespace {

using Counts = std::map<int, int>;

SurfaceModel model_of(const std::vector<CharacterLine>& lines, double edge_length) {
  const CurveNetwork network(lines);
  ModelOptions options;
  options.skin.edge_length = edge_length;
  return skin_network(network, find_regions(network), options);
}

CharacterLine arc(const std::string& name, const Vec3& centre, double radius, double from,
                  double to) {
  return {name, curve_from_formula(from, to, [=](double a, int order) -> Vec3 {
            const Vec3 e(std::cos(a), std::sin(a), 0), s(-e.y(), e.x(), 0);
            if (order == 0) return centre + radius * e;
            return radius * (order == 1 ? s : Vec3(-e));
          })};
}

auto everywhere(const Vec3& force) {
  return [force](const std::string&, const Vec3&, const Vec3&) { return force; };
}

ShellDeck deck_of(double thickness, const std::vector<std::string>& lines) {
  ShellDeck deck;
  deck.thickness = thickness;
  deck.young = 210000;
  deck.poisson = 0.3;
  for (const auto& line : lines) deck.supports.push_back(ShellDeck::Support::clamped(line));
  return deck;
}

double area_of(const std::vector<const SkinnedRegion*>& regions) {
  double area = 0;
  for (const SkinnedRegion* region : regions) area += region->surface.area();
  return area;
}

/// Number of times that a curve is embedded, and mesh-aligned, on boundaries.
struct Sides {
  int edge_aligned = 0, embedded = 0;
};
std::map<std::string, Sides> sides_of(const std::vector<const SkinnedRegion*>& regions) {
  std::map<std::string, Sides> sides;
  for (const SkinnedRegion* region : regions)
    for (const auto& loop : region->boundary)
      for (const BoundarySegment& piece : loop) {
        const auto i = static_cast<size_t>(piece.index);
        if (piece.kind == BoundarySegment::Kind::EdgeAligned)
          ++sides[region->edge_aligned[i].line.name].edge_aligned;
        else
          ++sides[region->embedded[i].line.name].embedded;
      }
  return sides;
}

/// Requirements of ccx: as many elements at an edge as faces with the curve on their boundary, two
/// inside.
void check_edges(const DeckMeshBuilder& mesh, const std::vector<const SkinnedRegion*>& regions) {
  std::map<int, int> rims;
  int on_rims = 0;
  for (const auto& [name, sides] : sides_of(regions)) {
    std::string set;
    for (const char c : name)
      set += std::isalnum(static_cast<unsigned char>(c))
                 ? static_cast<char>(std::toupper(static_cast<unsigned char>(c)))
                 : '_';
    INFO("line '" << name << "'");
    const Counts counts = mesh.edges_in(set);
    REQUIRE(counts.size() == 1);
    REQUIRE(counts.begin()->first == sides.edge_aligned + sides.embedded);
    if (sides.edge_aligned + sides.embedded == 1) on_rims += counts.begin()->second;
  }
  const Counts all = mesh.edges_by_count();
  CHECK((all.count(1) ? all.at(1) : 0) == on_rims);
  for (const auto& [count, edges] : all) CHECK(count <= 2);
}

/// ccx balances the forces of the deck; if they cancel, relative to `scale`.
void check_reaction(const fs::path& path, double scale = 0) {
  if (!have_ccx()) return;
  const DeckForces forces(sections(path));
  const Vec3 expected = forces.at_supports - forces.all;
  const Vec3 found = supporting_force(path);
  INFO("reaction " << found.transpose() << ", expected " << expected.transpose());
  CHECK((found - expected).norm() < 1e-6 * std::max(scale, forces.all.norm()));
}

/// Square of side a in the plane z = 0 and the curve x = cut through it.
std::vector<CharacterLine> cut_square(double a, double cut) {
  return {straight("south", {0, 0, 0}, {a, 0, 0}), straight("east", {a, 0, 0}, {a, a, 0}),
          straight("north", {0, a, 0}, {a, a, 0}), straight("west", {0, 0, 0}, {0, a, 0}),
          straight("cut", {cut, 0, 0}, {cut, a, 0})};
}

/// One face with all curves.
std::vector<std::string> rims_of(const std::vector<const SkinnedRegion*>& regions) {
  std::vector<std::string> rims;
  for (const auto& [name, sides] : sides_of(regions))
    if (sides.edge_aligned + sides.embedded == 1) rims.push_back(name);
  return rims;
}

}  // namespace

TEST_CASE("a plate of two faces bends as one", "[io][calculix]") {
  if (!have_delaunay_mesher()) return;
  const double a = 100, t = 1, q = 0.01;
  const SurfaceModel model = model_of(cut_square(a, 40), 6);
  const auto regions = model.skinned();
  REQUIRE(regions.size() == 2);
  REQUIRE(rims_of(regions).size() == 6);
  const fs::path path = scratch("two_plates") / "plate.inp";
  ShellDeck deck = deck_of(t, rims_of(regions));
  deck.pressure = q;
  write_calculix(path, regions, deck);
  const DeckMeshBuilder mesh(sections(path));
  check_edges(mesh, regions);
  CHECK(mesh.closest_nodes() > 1e-3);
  const int vertices = static_cast<int>(mesh.nodes.size() - mesh.edges.size());
  CHECK(vertices - static_cast<int>(mesh.edges.size()) + static_cast<int>(mesh.elements.size()) ==
        1);
  double on_cut = 0;
  for (const int id : mesh.sets.at("CUT")) on_cut += std::abs(mesh.nodes.at(id).x() - 40);
  CHECK(on_cut == 0);
  // Normals are consistent; the load is along them.
  const double up = regions[0]->surface.jet({0}).normal().z();
  CHECK(up == Approx(regions[1]->surface.jet({0}).normal().z()));
  const auto load = [&] { return Vec3(up * DeckForces(sections(path)).all); };
  CHECK((load() - Vec3(0, 0, q * a * a)).norm() < 1e-12 * q * a * a);
  check_reaction(path);
  // w = 0.00126532 q a⁴ / D in the middle, which is approximately a node.
  if (have_ccx()) {
    const std::string command = "python3 '" BATTEN_SOURCE_DIR "/scripts/ccx_max_displacement' '" +
                                path.string() + "' > '" + path.string() + ".txt'";
    REQUIRE(std::system(command.c_str()) == 0);
    double moved = 0;
    std::ifstream(path.string() + ".txt") >> moved;
    const double D = deck.young * t * t * t / (12 * (1 - deck.poisson * deck.poisson));
    CHECK(moved == Approx(0.00126532 * q * std::pow(a, 4) / D).epsilon(0.06));
  }

  // A pressure on one of them, and one on both.
  deck.pressures = {{regions[1]->name, 3 * q}};
  write_calculix(path, regions, deck);
  const double more = 3 * q * regions[1]->surface.area();
  CHECK((load() - Vec3(0, 0, q * a * a + more)).norm() < 1e-12 * q * a * a);
  check_reaction(path);
  deck.pressure = 0;
  write_calculix(path, regions, deck);
  CHECK((load() - Vec3(0, 0, more)).norm() < 1e-12 * q * a * a);
  check_reaction(path);
}

TEST_CASE("a creased box is a closed shell of elements", "[io][calculix]") {
  if (!have_delaunay_mesher()) return;
  const SurfaceModel model = model_of(box_lines({1, 2, 3}, {30, 20, 10}), 4);
  const auto regions = model.skinned();
  REQUIRE(regions.size() == 6);
  const fs::path path = scratch("box_deck") / "box.inp";
  ShellDeck deck = deck_of(0.5, {"x1"});
  const Vec3 per_area{1, -2, 0.5};
  deck.area_force = everywhere(per_area);
  write_calculix(path, regions, deck);
  const auto rows = sections(path);
  const DeckMeshBuilder mesh(rows);
  check_edges(mesh, regions);
  CHECK(mesh.edges_by_count() == Counts{{2, static_cast<int>(mesh.edges.size())}});
  const Vec3 force = DeckForces(rows).all;
  CHECK((force - 2200 * per_area).norm() < 1e-12 * force.norm());
  check_reaction(path);
  // Each element is in the set of its face, once.
  int next = 1;
  for (const SkinnedRegion* region : regions) {
    std::string set = region->name;
    for (char& c : set) c = c == ' ' ? '_' : static_cast<char>(std::toupper(c));
    const auto& row = rows.at("*ELSET,ELSET=" + set + ",GENERATE").at(0);
    CHECK(std::stoi(row.at(0)) == next);
    next = std::stoi(row.at(1)) + 1;
    CHECK(next - std::stoi(row[0]) == region->surface.mesh().triangle_count());
  }
  CHECK(next - 1 == static_cast<int>(mesh.elements.size()));
  // Uniformly inflated, it is in equilibrium with itself.
  deck.area_force = {};
  deck.pressure = 1;
  write_calculix(path, regions, deck);
  check_reaction(path, 2200);
}

TEST_CASE("faces with an embedded curve use the nodes of those to which it is edge-aligned",
          "[io][calculix]") {
  if (!have_delaunay_mesher()) return;
  // A half disc (two corners) between two polygons.
  using std::numbers::pi;
  const double r = 10;
  const std::vector<CharacterLine> lines{
      straight("chord", {-r, 0, 0}, {r, 0, 0}),  arc("bow", {0, 0, 0}, r, -pi, 0),
      straight("left", {-r, 0, 0}, {-r, 12, 0}), straight("top", {-r, 12, 0}, {r, 12, 0}),
      straight("right", {r, 12, 0}, {r, 0, 0}),  straight("a", {-r, 0, 0}, {-20, 0, 0}),
      straight("b", {-20, 0, 0}, {-20, -20, 0}), straight("c", {-20, -20, 0}, {20, -20, 0}),
      straight("d", {20, -20, 0}, {20, 0, 0}),   straight("e", {20, 0, 0}, {r, 0, 0})};
  const SurfaceModel model = model_of(lines, 3);
  const auto regions = model.skinned();
  REQUIRE(regions.size() == 3);
  const auto sides = sides_of(regions);
  CHECK(sides.at("chord").edge_aligned == 1);
  CHECK(sides.at("chord").embedded == 1);
  CHECK(sides.at("bow").embedded >= 1);
  const fs::path path = scratch("half_disc") / "deck.inp";
  ShellDeck deck = deck_of(0.5, {"b", "top"});
  const Vec3 per_area{0, 1, 2};
  deck.area_force = everywhere(per_area);
  write_calculix(path, regions, deck);
  const auto rows = sections(path);
  const DeckMeshBuilder mesh(rows);
  check_edges(mesh, regions);
  CHECK(mesh.closest_nodes() > 1e-3);
  // The nodes of the chord are exactly those of the mesh-aligned curve.
  for (const SkinnedRegion* region : regions)
    for (const EdgeAlignedLine& aligned_line : region->edge_aligned)
      if (aligned_line.line.name == "chord") {
        CHECK(mesh.sets.at("CHORD").size() == 2 * aligned_line.vertices.size() - 1);
        for (const int v : aligned_line.vertices) {
          double least = 1;
          for (const int id : mesh.sets.at("CHORD"))
            least = std::min(
                least, (mesh.nodes.at(id) - region->surface.dofs().row(3 * v).transpose()).norm());
          CHECK(least < 1e-12);
        }
      }
  const Vec3 force = DeckForces(rows).all;
  CHECK((force - area_of(regions) * per_area).norm() < 1e-5 * force.norm());
  CHECK(area_of(regions) == Approx(20 * 12 + 40 * 20).epsilon(1e-5));
  check_reaction(path);
}

TEST_CASE("a curve that is embedded on both sides has common nodes", "[io][calculix]") {
  if (!have_delaunay_mesher()) return;
  // A clamped disc of two halves: w = q r⁴ / (64 D).
  using std::numbers::pi;
  const double r = 50, t = 1, q = 0.01;
  const SurfaceModel model =
      model_of({straight("chord", {-r, 0, 0}, {r, 0, 0}), arc("low", {0, 0, 0}, r, -pi, 0),
                arc("high", {0, 0, 0}, r, 0, pi)},
               5);
  const auto regions = model.skinned();
  REQUIRE(regions.size() == 2);
  REQUIRE(sides_of(regions).at("chord").embedded == 2);
  const fs::path path = scratch("disc_of_two") / "disc.inp";
  ShellDeck deck = deck_of(t, {"low", "high"});
  const Vec3 per_area{0, 0, q};
  deck.area_force = everywhere(per_area);
  write_calculix(path, regions, deck);
  const auto rows = sections(path);
  const DeckMeshBuilder mesh(rows);
  check_edges(mesh, regions);
  CHECK(mesh.closest_nodes() > 1e-3);
  CHECK(DeckForces(rows).all.z() == Approx(q * pi * r * r).epsilon(1e-4));
  check_reaction(path);
  if (!have_ccx()) return;
  const std::string command = "python3 '" BATTEN_SOURCE_DIR "/scripts/ccx_max_displacement' '" +
                              path.string() + "' > '" + path.string() + ".txt'";
  REQUIRE(std::system(command.c_str()) == 0);
  double moved = 0;
  std::ifstream(path.string() + ".txt") >> moved;
  const double D = deck.young * t * t * t / (12 * (1 - deck.poisson * deck.poisson));
  CHECK(moved == Approx(q * std::pow(r, 4) / (64 * D)).epsilon(0.06));
}

TEST_CASE("faces that only touch at a corner share one node", "[io][calculix]") {
  if (!have_delaunay_mesher()) return;
  std::vector<CharacterLine> lines;
  for (const double x : {0.0, 10.0}) {
    const std::string of = x == 0 ? "low " : "high ";
    const Vec3 o(x, x, 0);
    lines.push_back(straight(of + "1", o, o + Vec3(10, 0, 0)));
    lines.push_back(straight(of + "2", o + Vec3(10, 0, 0), o + Vec3(10, 10, 0)));
    lines.push_back(straight(of + "3", o + Vec3(10, 10, 0), o + Vec3(0, 10, 0)));
    lines.push_back(straight(of + "4", o + Vec3(0, 10, 0), o));
  }
  const SurfaceModel model = model_of(lines, 3);
  const auto regions = model.skinned();
  REQUIRE(regions.size() == 2);
  const fs::path path = scratch("corner") / "deck.inp";
  write_calculix(path, regions, deck_of(0.1, {"low 1"}));
  const DeckMeshBuilder mesh(sections(path));
  std::vector<int> common;
  for (const int id : mesh.sets.at("LOW_2"))
    if (mesh.sets.at("HIGH_1").count(id)) common.push_back(id);
  REQUIRE(common.size() == 1);
  CHECK((mesh.nodes.at(common[0]) - Vec3(10, 10, 0)).norm() < 1e-12);
  CHECK(mesh.closest_nodes() > 1e-2);
}

TEST_CASE("the sculpted mouse is one closed shell of elements that carries its load",
          "[io][calculix]") {
  if (!have_delaunay_mesher()) return;
  const batten_test::NetworkModel made = batten_test::mouse(8);
  SculptingSession session(*made.model.layout, {});
  session.add(Load{"p", Load::Pressure{}}, {{.name = "p", .value = 30}});
  session.add(LineOffset{"m", "spine.3", {}, 0.4}, {{.name = "m", .value = 2}});
  session.solve_to_equilibrium();
  const auto sculpted = session.regions();
  std::vector<const SkinnedRegion*> regions;
  for (const SkinnedRegion& region : sculpted) regions.push_back(&region);
  REQUIRE(regions.size() == 11);
  int embedded = 0;
  for (const auto& [name, sides] : sides_of(regions)) embedded += sides.embedded;
  CHECK(embedded == 4);  // the bottom's smooth outline

  const fs::path path = scratch("mouse_deck") / "mouse.inp";
  ShellDeck deck = deck_of(0.8, {});
  for (const auto& [name, sides] : sides_of(regions))
    if (name.starts_with("base")) deck.supports.push_back(ShellDeck::Support::clamped(name));
  const Vec3 per_area{0.01, -0.02, -0.03};
  deck.area_force = everywhere(per_area);
  write_calculix(path, regions, deck);
  const auto rows = sections(path);
  const DeckMeshBuilder mesh(rows);
  check_edges(mesh, regions);
  CHECK(mesh.edges_by_count() == Counts{{2, static_cast<int>(mesh.edges.size())}});
  const int vertices = static_cast<int>(mesh.nodes.size() - mesh.edges.size());
  CHECK(vertices - static_cast<int>(mesh.edges.size()) + static_cast<int>(mesh.elements.size()) ==
        2);
  const Vec3 force = DeckForces(rows).all;
  CHECK((force - area_of(regions) * per_area).norm() < 1e-5 * force.norm());
  check_reaction(path);
}

TEST_CASE("sketches become conforming shells", "[io][calculix]") {
  if (!have_delaunay_mesher()) return;
  const std::string name = GENERATE("computer-mouse", "vacuum", "teapot", "02-2-2", "hmd_modern");
  const auto file = optional_data("sketch-cassie/sketch_graph/" + name + ".json");
  if (file.empty()) {
    WARN("the sketch " << name << " is not on this machine: skipped");
    return;
  }
  INFO("sketch " << name);
  const CurveNetwork network(read_sketch_graph(file));
  ModelOptions how;
  how.max_join_rounds = 0;
  const SurfaceModel model = skin_network(network, find_regions(network), how);
  // One of them as a session returns it.
  SculptingSession session(*model.layout, {});
  session.add(Load{"p", Load::Pressure{}}, {{.name = "p", .value = name == "vacuum" ? 2.0 : 0}});
  session.solve_to_equilibrium();
  const auto sculpted = session.regions();
  std::vector<const SkinnedRegion*> regions;
  for (const SkinnedRegion& region : sculpted) regions.push_back(&region);
  const fs::path path = scratch("sketch_deck") / "sketch.inp";
  // Pinned: if rotations are fixed at nodes where shells meet at an angle, ccx prints additional
  // forces (0.1 to 10 times this load, larger for thinner shells); without fixed rotations, forces
  // balance to seven digits. Several curves, to prevent free rotations.
  ShellDeck deck = deck_of(5e-4, {});
  for (const auto& [line, sides] : sides_of(regions))
    if (deck.supports.size() < 8) deck.supports.push_back(ShellDeck::Support::pinned(line));
  const Vec3 per_area{1, 2, 3};
  deck.area_force = everywhere(per_area);
  write_calculix(path, regions, deck);
  const auto rows = sections(path);
  check_edges(DeckMeshBuilder(rows), regions);
  const Vec3 force = DeckForces(rows).all;
  CHECK((force - area_of(regions) * per_area).norm() < 1e-4 * force.norm());
  if (name == "vacuum") check_reaction(path);
}

TEST_CASE("invalid decks of models are refused with the reason", "[io][calculix]") {
  using Catch::Matchers::Contains;
  if (!have_delaunay_mesher()) return;
  const SurfaceModel model = model_of(cut_square(10, 4), 3);
  const auto regions = model.skinned();
  const fs::path path = scratch("model_errors") / "deck.inp";
  const ShellDeck good = deck_of(0.1, {"cut"});
  const auto answer = [&](const std::vector<const SkinnedRegion*>& which, const ShellDeck& deck) {
    return error_message([&] { write_calculix(path, which, deck); });
  };
  CHECK_THAT(answer({}, good), Contains("no face"));
  ShellDeck deck = good;
  deck.supports[0].line = "cute";
  CHECK_THAT(answer(regions, deck),
             Contains("2 faces") && Contains("no face has") && Contains("did you mean 'cut'?"));
  deck = good;
  deck.pressures = {{"face 11", 1}};
  CHECK_THAT(answer(regions, deck), Contains("'face 11'") && Contains("did you mean 'face 1'?"));
  deck.pressures = {{regions[0]->name, std::nan("")}};
  CHECK_THAT(answer(regions, deck), Contains("not finite"));
  // Two different curves with one name.
  SkinnedRegion other = *regions[1];
  for (EdgeAlignedLine& aligned_line : other.edge_aligned)
    if (aligned_line.line.name == "east") aligned_line.line.name = "west";
  CHECK_THAT(answer({regions[0], &other}, good),
             Contains("'west'") && Contains("apart, expected one curve"));
  CHECK_FALSE(fs::exists(path));
}
