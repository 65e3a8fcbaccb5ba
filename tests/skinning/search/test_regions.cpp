// SPDX-License-Identifier: MPL-2.0
// Faces of networks: unambiguous loops, prescribed faces, and real sketches.
#include "batten/skinning/search/find_regions.h"
#include "batten/skinning/search/regions.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <set>

#include "batten/core/errors.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/fairing/curves/primitive_curves.h"
#include "batten/skinning/search/region_search.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sample_networks.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/test_data.h"
#if BATTEN_TEST_IO
#include "batten/tests/support/sketch_segments.h"
#endif
#if BATTEN_TEST_IO
#include "batten/io/lines/drawing.h"
#endif

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

using std::numbers::pi;
using Lines = std::vector<CharacterLine>;
using Names = std::vector<std::string>;

// A circle or an arc around `centre`, from a towards b (both have the length of the radius).
CharacterLine circular_arc(const std::string& name, const Vec3& centre, const Vec3& a,
                           const Vec3& b, double from = 0, double to = 2 * pi) {
  return {name, curve_from_formula(from, to, [=](double t, int order) -> Vec3 {
            if (order == 0) return centre + a * std::cos(t) + b * std::sin(t);
            if (order == 1) return -a * std::sin(t) + b * std::cos(t);
            return -a * std::cos(t) - b * std::sin(t);
          })};
}

// Curves along x and y over [0, m] × [0, n] at integers, with a height.
template <class Height>
Lines grid(int m, int n, const Height& height) {
  Lines lines;
  const auto add = [&](const std::string& name, int count, const auto& at) {
    std::vector<Vec3> points;
    for (int i = 0; i <= 8 * count; ++i) points.push_back(at(i / 8.0));
    lines.push_back({name, curve_through_points(name, points)});
  };
  for (int j = 0; j <= n; ++j)
    add("h" + std::to_string(j), m, [&](double x) { return Vec3(x, j, height(x, j)); });
  for (int i = 0; i <= m; ++i)
    add("v" + std::to_string(i), n, [&](double y) { return Vec3(i, y, height(i, y)); });
  return lines;
}

Names names_of(const CurveNetwork& network, const EdgeLoop& loop) {
  Names names;
  for (const OrientedEdge& use : loop) names.push_back(network.edges()[use.edge].name);
  std::sort(names.begin(), names.end());
  return names;
}

// All loops of all faces, by the names of their edges.
std::multiset<Names> loops_of(const CurveNetwork& network, const FoundRegions& found) {
  std::multiset<Names> all;
  for (const NetworkRegion& region : found.regions)
    for (const EdgeLoop& loop : region.loops) all.insert(names_of(network, loop));
  return all;
}

std::multiset<size_t> sides_of(const FoundRegions& found) {
  std::multiset<size_t> sides;
  for (const NetworkRegion& region : found.regions)
    for (const EdgeLoop& loop : region.loops) sides.insert(loop.size());
  return sides;
}

// Invariants of every result.
void check_consistent(const CurveNetwork& network, const FoundRegions& found, int most = 2) {
  std::vector<int> uses(network.edges().size(), 0);
  std::set<std::string> names;
  for (const NetworkRegion& region : found.regions) {
    CHECK(names.insert(region.name).second);
    for (const EdgeLoop& loop : region.loops) {
      REQUIRE_FALSE(loop.empty());
      for (size_t i = 0; i < loop.size(); ++i) {
        const OrientedEdge &use = loop[i], &next = loop[(i + 1) % loop.size()];
        CHECK(network.edges()[use.edge].nodes[!use.reversed] ==
              network.edges()[next.edge].nodes[next.reversed]);
        ++uses[use.edge];
      }
    }
    for (const int a : region.inner) uses[a] -= 100;
  }
  std::vector<int> free_edges, unused_edges;
  for (size_t a = 0; a < uses.size(); ++a) {
    CHECK(uses[a] <= most);
    if (uses[a] == 1) free_edges.push_back(static_cast<int>(a));
    if (uses[a] == 0) unused_edges.push_back(static_cast<int>(a));
  }
  CHECK(found.free_edges == free_edges);
  CHECK(found.unused_edges == unused_edges);
  for (const AmbiguousRegion& choice : found.ambiguous_regions) {
    CHECK(choice.alternatives.size() == choice.margins.size());
    CHECK(std::is_sorted(choice.margins.begin(), choice.margins.end()));
    CHECK_FALSE(choice.text.empty());
    CHECK(choice.where.allFinite());
  }
}

struct NetworkWithRegions {
  CurveNetwork network;
  FoundRegions regions;
  explicit NetworkWithRegions(const Lines& lines, const RegionSearchOptions& options = {})
      : network(lines), regions(find_regions(network, options)) {
    check_consistent(network, regions, options.max_faces_per_edge);
  }
  std::multiset<Names> loops() const { return loops_of(network, regions); }
  std::multiset<size_t> sides() const { return sides_of(regions); }
};

std::multiset<size_t> all(size_t count, size_t sides) {
  std::multiset<size_t> set;
  for (size_t i = 0; i < count; ++i) set.insert(sides);
  return set;
}

RegionSpec surface(std::vector<Names> loops, const std::string& name = "") {
  RegionSpec word;
  word.name = name;
  word.loops = std::move(loops);
  return word;
}

RegionSpec no_surface(const Names& loop) {
  RegionSpec word;
  word.kind = RegionSpec::Kind::NoSurface;
  word.loops = {loop};
  return word;
}

Lines torus(int m, int n, double big = 3, double small = 1) {
  Lines lines;
  for (int i = 0; i < m; ++i) {
    const double a = 2 * pi * i / m;
    const Vec3 out(std::cos(a), std::sin(a), 0);
    lines.push_back(
        circular_arc("small" + std::to_string(i), big * out, small * out, small * Vec3::UnitZ()));
  }
  for (int j = 0; j < n; ++j) {
    const double a = 2 * pi * j / n, r = big + small * std::cos(a);
    lines.push_back(circular_arc("big" + std::to_string(j), Vec3(0, 0, small * std::sin(a)),
                                 r * Vec3::UnitX(), r * Vec3::UnitY()));
  }
  return lines;
}

Lines stacked_boxes() {
  Lines lines = box_lines(Vec3::Zero(), Vec3(1, 1, 1));
  for (CharacterLine& line : box_lines(Vec3(0, 0, 1), Vec3(1, 1, 0.8))) {
    // The edges of its floor already exist.
    if (line.curve->evaluate(line.curve->start(), 0).z() == 1 &&
        line.curve->evaluate(line.curve->end(), 0).z() == 1)
      continue;
    line.name = "upper " + line.name;
    lines.push_back(line);
  }
  return lines;
}

}  // namespace

TEST_CASE("a grid has its cells, plane or curved, and nothing else", "[skinning][search]") {
  const int m = GENERATE(1, 2, 5), n = GENERATE(1, 3);
  const double lift = GENERATE(0.0, 0.8);
  const NetworkWithRegions found(
      grid(m, n, [&](double x, double y) { return lift * std::sin(x + 0.4) * std::cos(0.7 * y); }));
  CAPTURE(m, n, lift);
  CHECK(found.sides() == all(static_cast<size_t>(m * n), 4));
  CHECK(found.regions.free_edges.size() == static_cast<size_t>(m * n == 1 ? 4 : 2 * (m + n)));
  CHECK(found.regions.unused_edges.empty());
  CHECK(found.regions.optimal);
  if (lift == 0) CHECK(found.regions.ambiguous_regions.empty());
}

TEST_CASE("a grid of a thousand arcs has its cells", "[skinning][search]") {
  const NetworkWithRegions found(
      grid(22, 22, [](double x, double y) { return 0.02 * x * x - 0.03 * x * y; }));
  CHECK(found.sides() == all(22 * 22, 4));
  CHECK(found.regions.optimal);
}

TEST_CASE("a box has six faces, and five if its lid is specified as open", "[skinning][search]") {
  const Lines lines = box_lines(Vec3::Zero(), Vec3(1, 1.3, 0.7));
  const NetworkWithRegions closed(lines);
  CHECK(closed.sides() == all(6, 4));
  CHECK(closed.regions.free_edges.empty());
  RegionSearchOptions open;
  open.specs = {no_surface({"x3", "x4", "y2", "y4"})};
  const NetworkWithRegions without(lines, open);
  CHECK(without.sides() == all(5, 4));
  CHECK(without.regions.free_edges.size() == 4);
  CHECK(without.regions.ambiguous_regions.empty());  // decided by the user
}

TEST_CASE("closed surfaces of any genus are found closed", "[skinning][search]") {
  SECTION("octants of a sphere") {
    const NetworkWithRegions found(sphere_lines());
    CHECK(found.sides() == all(8, 3));
    CHECK(found.regions.free_edges.empty());
    CHECK(found.regions.optimal);
  }
  SECTION("a torus, neither through the middle nor across the tube") {
    const int m = GENERATE(4, 6), n = GENERATE(3, 5);
    const NetworkWithRegions found(torus(m, n));
    CAPTURE(m, n);
    CHECK(found.sides() == all(static_cast<size_t>(m * n), 4));
    CHECK(found.regions.free_edges.empty());
  }
  SECTION("lunes between meridians: loops of two arcs") {
    Lines lines;
    for (int i = 0; i < 5; ++i) {
      const double a = 2 * pi * i / 5;
      lines.push_back(circular_arc("m" + std::to_string(i), Vec3::Zero(), Vec3::UnitZ(),
                                   Vec3(std::cos(a), std::sin(a), 0), 0, pi));
    }
    CHECK(NetworkWithRegions(lines).sides() == all(5, 2));
  }
}

// An outline at height 0 and at height 1, and vertical curves between their corners.
Lines prism(const Lines& outline) {
  Lines lines;
  int number = 0;
  for (const CharacterLine& line : outline) {
    const std::string name = "side" + std::to_string(++number);
    lines.push_back({name + " low", line.curve});
    lines.push_back({name + " high", transformed(line.curve, {Mat3::Identity(), Vec3::UnitZ()})});
    const Vec3 corner = line.curve->evaluate(line.curve->start());
    lines.push_back(straight(name + " edge", corner, corner + Vec3::UnitZ()));
  }
  return lines;
}

TEST_CASE("solids with fillets are closed, cups are not", "[skinning][search]") {
  SECTION("a D") {
    const NetworkWithRegions found(
        prism({straight("a", {-2, -1, 0}, {0, -1, 0}),
               circular_arc("b", {0, 0, 0}, -Vec3::UnitY(), Vec3::UnitX(), 0, pi),
               straight("c", {0, 1, 0}, {-2, 1, 0}), straight("d", {-2, 1, 0}, {-2, -1, 0})}));
    CHECK(found.sides() == all(6, 4));
    CHECK(found.regions.free_edges.empty());
  }
  SECTION("a rectangle whose corners are rounded") {
    Lines outline;
    const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY();
    const Vec3 centres[] = {{2, -1, 0}, {2, 1, 0}, {-2, 1, 0}, {-2, -1, 0}};
    const Vec3 out[] = {-y, x, y, -x};
    for (size_t k = 0; k < 4; ++k) {
      const Vec3 &a = 0.5 * out[k], &b = 0.5 * out[(k + 1) % 4];
      outline.push_back(circular_arc("round", centres[k], a, b, 0, pi / 2));
      outline.push_back(straight("flat", centres[k] + b, centres[(k + 1) % 4] + b));
    }
    const NetworkWithRegions found(prism(outline));
    CHECK(found.regions.regions.size() == 10);
    CHECK(found.regions.free_edges.empty());
  }
  SECTION("a cup, whose rim is round all the way") {
    Lines outline;
    for (int k = 0; k < 4; ++k)
      outline.push_back(circular_arc("round", Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(),
                                     k * pi / 2, (k + 1) * pi / 2));
    const NetworkWithRegions found(prism(outline));
    CHECK(found.sides() == all(4, 4));
    CHECK(found.regions.free_edges.size() == 8);
  }
}

TEST_CASE("a chain with one wall inside of a plane face is a hole of it", "[skinning][search]") {
  Lines lines = box_lines({-3, -2, 0}, {6, 4, 1});
  Lines circle;
  for (int k = 0; k < 2; ++k)
    circle.push_back(
        circular_arc("round", Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(), k * pi, (k + 1) * pi));
  const Lines hole = prism(circle);
  lines.insert(lines.end(), hole.begin(), hole.end());
  const NetworkWithRegions found(lines);
  CHECK(found.regions.regions.size() == 8);
  CHECK(found.regions.free_edges.empty());
  int holes = 0;
  for (const NetworkRegion& region : found.regions.regions)
    if (region.loops.size() == 2) {
      ++holes;
      CHECK(region.loops[0].size() == 4);
      CHECK(region.loops[1].size() == 2);
    }
  CHECK(holes == 2);
  // Without its walls the circle below is inside the face, with no defined meaning.
  lines.resize(12);
  lines.push_back(circle[0]);
  lines.push_back({"other half", circle[1].curve});
  CHECK(NetworkWithRegions(lines).sides() == all(6, 4));
}

TEST_CASE("sections of a wing get its skins, not its ribs", "[skinning][search]") {
  // Noses are round, trailing edges sharp; ribs are planar, skins are twisted.
  Lines lines;
  std::vector<Vec3> front, rear;
  for (int k = 0; k < 4; ++k) {
    const double angle = 0.25 * k, chord = 2 - 0.3 * k;
    const Vec3 x(std::cos(angle), 0, std::sin(angle)), z(-std::sin(angle), 0, std::cos(angle));
    for (const int side : {1, -1}) {
      std::vector<Vec3> points;
      for (int i = 0; i <= 24; ++i) {
        const double s = 0.5 * (1 - std::cos(pi * i / 24)),
                     half = 0.6 * (0.2969 * std::sqrt(s) - 0.126 * s - 0.3516 * s * s +
                                   0.2843 * s * s * s - 0.1036 * s * s * s * s);
        points.push_back(chord * ((s - 0.5) * x + side * half * z) + 1.5 * k * Vec3::UnitY());
      }
      const std::string name = (side > 0 ? "upper" : "lower") + std::to_string(k);
      lines.push_back({name, curve_through_points(name, points)});
      if (side > 0) front.push_back(points.front()), rear.push_back(points.back());
    }
  }
  lines.push_back({"front", curve_through_points("front", front)});
  lines.push_back({"rear", curve_through_points("rear", rear)});
  RegionSearchOptions ends;
  ends.specs = {surface({{"upper0", "lower0"}}, "root"), surface({{"upper3", "lower3"}}, "tip")};
  const NetworkWithRegions found(lines, ends);
  CHECK(found.regions.regions.size() == 8);
  CHECK(found.regions.free_edges.empty());
  CHECK(found.regions.unused_edges.empty());
}

TEST_CASE("two boxes that share a wall have it as a face if three may meet", "[skinning][search]") {
  const Lines lines = stacked_boxes();
  CHECK(NetworkWithRegions(lines).sides() == all(10, 4));
  RegionSearchOptions options;
  options.max_faces_per_edge = 3;
  const NetworkWithRegions found(lines, options);
  CHECK(found.sides() == all(11, 4));
  CHECK(found.regions.free_edges.empty());
}

TEST_CASE("the free edges of an open shell are left open, and reported", "[skinning][search]") {
  Lines lines;
  for (int i = 0; i < 4; ++i) {
    const double a = pi / 2 * i;
    const Vec3 out(std::cos(a), std::sin(a), 0), next(-std::sin(a), std::cos(a), 0);
    lines.push_back(circular_arc("rim" + std::to_string(i), Vec3::Zero(), out, next, 0, pi / 2));
    lines.push_back(
        circular_arc("rib" + std::to_string(i), Vec3::Zero(), out, Vec3::UnitZ(), 0, pi / 2));
  }
  const NetworkWithRegions found(lines);
  CHECK(found.sides() == all(4, 3));
  CHECK(found.regions.free_edges.size() == 4);
  REQUIRE(found.regions.ambiguous_regions.size() == 1);
  const AmbiguousRegion& choice = found.regions.ambiguous_regions[0];
  CHECK(choice.chosen.empty());
  CHECK(names_of(found.network, choice.alternatives[0][0]) ==
        Names{"rim0", "rim1", "rim2", "rim3"});
  CHECK_THAT(choice.text, Contains("left open"));
  RegionSearchOptions lid;
  lid.specs = {surface({{"rim2", "rim0", "rim3", "rim1"}}, "floor")};
  const NetworkWithRegions with(lines, lid);
  CHECK(with.regions.regions.size() == 5);
  CHECK(with.regions.regions[0].name == "floor");
  CHECK(with.regions.regions[0].requested);
  CHECK(with.regions.free_edges.empty());
}

TEST_CASE("one loop of many edges is one face", "[skinning][search]") {
  const int n = GENERATE(1, 2, 3, 12, 28);
  Lines lines;
  for (int i = 0; i < n; ++i)
    lines.push_back(circular_arc("a" + std::to_string(i), Vec3(0, 0, 0.1), Vec3(2, 0, 0.3),
                                 Vec3(0, 1, 0.3), 2 * pi * i / n, 2 * pi * (i + 1) / n));
  const NetworkWithRegions found(lines);
  CAPTURE(n);
  CHECK(found.sides() == all(1, static_cast<size_t>(n)));
}

TEST_CASE("a single loop is a face even if every corner is reflex", "[skinning][search]") {
  Lines lines;
  constexpr int lobes = 12;
  for (int i = 0; i < lobes; ++i) {
    const double a = 2 * std::numbers::pi * i / lobes, b = 2 * std::numbers::pi * (i + 1) / lobes;
    const Vec3 p(std::cos(a), std::sin(a), 0), q(std::cos(b), std::sin(b), 0);
    const Vec3 out = 0.2 * (p + q);
    lines.push_back({"lobe " + std::to_string(i), bezier_curve(p, p + out, q + out, q)});
  }
  const NetworkWithRegions found(lines);
  REQUIRE(found.regions.regions.size() == 1);
  CHECK(found.regions.regions[0].loops[0].size() == lobes);
}

TEST_CASE("dangling curves in a face lie in it, and others stay unused", "[skinning][search]") {
  Lines lines = grid(1, 1, [](double, double) { return 0.0; });
  lines.push_back(straight("in", Vec3(0, 0.5, 0), Vec3(0.6, 0.5, 0)));
  lines.push_back(straight("twig", Vec3(0.4, 0.5, 0), Vec3(0.5, 0.8, 0)));
  lines.push_back(straight("out", Vec3(1, 0.5, 0), Vec3(1.7, 0.5, 0)));
  lines.push_back(straight("up", Vec3(0.5, 1, 0), Vec3(0.5, 0.7, 0.8)));
  lines.push_back({"curl", bezier_curve(Vec3(0.5, 0, 0), Vec3(0.5, 0.3, 0), Vec3(0.5, 0.5, 0.2),
                                        Vec3(0.5, 0.5, 0.7))});
  const NetworkWithRegions found(lines);
  REQUIRE(found.regions.regions.size() == 1);
  std::set<std::string> inner, unused_edges;
  for (const int a : found.regions.regions[0].inner)
    inner.insert(found.network.lines()[found.network.edges()[a].line].name);
  for (const int a : found.regions.unused_edges)
    unused_edges.insert(found.network.lines()[found.network.edges()[a].line].name);
  CHECK(inner == std::set<std::string>{"in", "twig"});
  CHECK(unused_edges == std::set<std::string>{"curl", "out", "up"});
}

TEST_CASE("a curve between two loops is used on both sides if one lies in the other",
          "[skinning][search]") {
  const auto square = [](const std::string& name, double half) {
    Lines lines;
    const Vec3 p[] = {{half, half, 0}, {-half, half, 0}, {-half, -half, 0}, {half, -half, 0}};
    for (int i = 0; i < 4; ++i)
      lines.push_back(straight(name + std::to_string(i), p[i], p[(i + 1) % 4]));
    return lines;
  };
  Lines lines = square("outer", 2);
  for (const CharacterLine& line : square("inner", 1)) lines.push_back(line);
  lines.push_back(straight("bridge", Vec3(1, 1, 0), Vec3(2, 2, 0)));
  const NetworkWithRegions found(lines);
  CHECK(found.sides() == std::multiset<size_t>{4, 10});
  CHECK(found.loops().count({"inner0", "inner1", "inner2", "inner3"}) == 1);
}

TEST_CASE("two loops alone are an annulus if they resemble its boundaries", "[skinning][search]") {
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY();
  SECTION("of a tube, tilted") {
    const NetworkWithRegions found(
        {circular_arc("low", Vec3(0, 0, 0), x, y),
         circular_arc("high", Vec3(0.3, 0, 2), 1.4 * Vec3(1, 0, 0.2), 1.4 * y)});
    REQUIRE(found.regions.regions.size() == 1);
    CHECK(found.regions.regions[0].annulus);
    CHECK(found.regions.regions[0].loops.size() == 2);
    REQUIRE(found.regions.ambiguous_regions.size() == 1);
    CHECK(found.regions.ambiguous_regions[0].alternatives.size() == 2);
    RegionSearchOptions discs;
    discs.specs = {surface({{"low"}}), surface({{"high"}})};
    const NetworkWithRegions apart(
        {circular_arc("low", Vec3(0, 0, 0), x, y), circular_arc("high", Vec3(0, 0, 2), x, y)},
        discs);
    CHECK(apart.regions.regions.size() == 2);
    CHECK_FALSE(apart.regions.regions[0].annulus);
  }
  SECTION("of an annulus") {
    const NetworkWithRegions found(
        {circular_arc("in", Vec3::Zero(), x, y), circular_arc("out", Vec3::Zero(), 2 * x, 2 * y)});
    REQUIRE(found.regions.regions.size() == 1);
    CHECK(found.regions.regions[0].annulus);
  }
  SECTION("beside each other they are two discs") {
    const NetworkWithRegions found(
        {circular_arc("a", Vec3::Zero(), x, y), circular_arc("b", Vec3(3, 0, 0), x, y)});
    CHECK(found.sides() == all(2, 1));
  }
}

TEST_CASE("a loop on a face is not ambiguous", "[skinning][search]") {
  Lines lines = grid(2, 1, [](double, double) { return 0.0; });
  lines.push_back(circular_arc("eye", Vec3(0.5, 0.5, 0), Vec3(0.2, 0, 0), Vec3(0, 0.2, 0)));
  const NetworkWithRegions found(lines);
  CHECK(found.sides() == all(2, 4));
  CHECK(found.regions.unused_edges.size() == 1);
  REQUIRE(found.regions.ambiguous_regions.size() == 1);
  CHECK_THAT(found.regions.ambiguous_regions[0].text, Contains("'eye'") && Contains("hole"));
  // As in the alternative: the outline and the hole.
  RegionSearchOptions options;
  options.specs.emplace_back();
  for (const EdgeLoop& loop : found.regions.ambiguous_regions[0].alternatives[0])
    options.specs[0].loops.push_back(names_of(found.network, loop));
  const NetworkWithRegions hole(lines, options);
  REQUIRE(hole.regions.regions.size() == 2);
  CHECK(hole.regions.regions[0].loops.size() == 2);
  CHECK(hole.regions.free_edges.size() == 7);
}

TEST_CASE("the user's specifications have priority", "[skinning][search]") {
  const Lines lines = grid(2, 1, [](double, double) { return 0.0; });
  const NetworkWithRegions plain(lines);
  SECTION("one region instead of two: the line between them is inner") {
    RegionSearchOptions options;
    options.specs = {surface({{"v0", "h0", "v2", "h1"}}, "plate")};
    options.specs[0].inner = {"v1"};
    const NetworkWithRegions found(lines, options);
    REQUIRE(found.regions.regions.size() == 1);
    CHECK(found.regions.regions[0].inner.size() == 1);
    CHECK(found.regions.unused_edges.empty());
  }
  SECTION("no surface") {
    RegionSearchOptions options;
    const EdgeLoop& loop = plain.regions.regions[1].loops[0];
    options.specs = {no_surface(names_of(plain.network, loop))};
    const NetworkWithRegions found(lines, options);
    REQUIRE(found.regions.regions.size() == 1);
    CHECK(found.loops() ==
          std::multiset<Names>{names_of(plain.network, plain.regions.regions[0].loops[0])});
  }
}

TEST_CASE("specifications that match nothing are refused with the reason", "[skinning][search]") {
  const CurveNetwork network(box_lines(Vec3::Zero(), Vec3(1, 1, 1)));
  const auto refused = [&](const std::vector<RegionSpec>& specs, const auto& text, int most = 2) {
    RegionSearchOptions options;
    options.specs = specs;
    options.max_faces_per_edge = most;
    for (RegionSpec& word : options.specs) word.where = "scene.toml:8:1: ";
    CHECK_THROWS_WITH(find_regions(network, options), text);
    CHECK_THROWS_AS(find_regions(network, options), InputError);
  };
  const Names floor{"x1", "x2", "y1", "y3"};
  refused({surface({{"x1", "x2", "y1", "yy3"}})},
          Contains("scene.toml:8:1: ") && Contains("'yy3'"));
  refused({surface({{"x1", "x2", "y1"}}, "lid")}, Contains("'lid'") && Contains("free end at"));
  refused({surface({})}, Contains("names no curves"));
  refused({surface({{}})}, Contains("names no curves"));
  refused({surface({floor}), surface({floor})}, Contains("twice"));
  refused({surface({floor}), no_surface(floor)}, Contains("surface = false"));
  refused({surface({floor})}, Contains("max_faces_per_edge"), 0);
  const auto all_edges = [&](char axis) {
    Names names;
    for (int i = 1; i <= 4; ++i) names.push_back(std::string(1, axis) + std::to_string(i));
    return names;
  };
  refused({surface({all_edges('x')})}, Contains("free end"));
  RegionSpec annulus = surface({floor});
  annulus.annulus = true;
  refused({annulus}, Contains("expected two for an annulus"));
  RegionSpec inner = surface({floor});
  inner.inner = {"x1"};
  refused({inner}, Contains("inner curve and a boundary"));
}

TEST_CASE("faces do not depend on the order or direction of curves, nor on small moves",
          "[skinning][search]") {
  Random random(17);
  const auto wavy = [](double x, double y) { return 0.3 * std::sin(2 * x) + 0.1 * y * y; };
  for (const Lines& lines : {grid(4, 3, wavy), sphere_lines(), stacked_boxes(), torus(5, 3)}) {
    const auto expected = NetworkWithRegions(lines).loops();
    for (int round = 0; round < 4; ++round) {
      Lines other = lines;
      std::shuffle(other.begin(), other.end(), random.engine);
      const Vec3 nonplanarity = 1e-4 * random.point();
      for (CharacterLine& line : other) {
        const auto curve = line.curve;
        const double a = curve->start(), b = curve->end();
        const bool back = random() < 0;
        line.curve = curve_from_formula(a, b, [=](double t, int order) -> Vec3 {
          const double s = back ? a + b - t : t;
          Vec3 x = curve->evaluate(s, order);
          if (order == 0)
            x += nonplanarity.cwiseProduct(Vec3(std::sin(x.y()), std::sin(x.z()), x.x()));
          return back && order == 1 ? Vec3(-x) : x;
        });
      }
      // Parts of a split curve are numbered along it: their names change if it is reversed.
      const NetworkWithRegions found(other);
      CHECK(found.loops().size() == expected.size());
      CHECK(found.sides() == NetworkWithRegions(lines).sides());
      const auto by_line = [](const NetworkWithRegions& f) {
        std::multiset<Names> loops;
        for (const NetworkRegion& region : f.regions.regions) {
          Names names;
          for (const OrientedEdge& use : region.loops[0])
            names.push_back(f.network.lines()[f.network.edges()[use.edge].line].name);
          std::sort(names.begin(), names.end());
          loops.insert(names);
        }
        return loops;
      };
      CHECK(by_line(found) == by_line(NetworkWithRegions(lines)));
    }
  }
}

TEST_CASE("a plane polygon costs its sides less two, and surfaces fold as they meet",
          "[skinning][search]") {
  const LoopCosts costs;
  const auto network = [](const Lines& lines) { return RegionGraph(CurveNetwork(lines)); };
  SECTION("convex or not") {
    const std::vector<Vec3> corners{{0, 0, 0}, {3, 0, 0}, {3, 1, 0},
                                    {1, 1, 0}, {1, 2, 0}, {0, 2, 0}};
    Lines lines;
    for (size_t i = 0; i < corners.size(); ++i)
      lines.push_back(straight("l" + std::to_string(i), corners[i], corners[(i + 1) % 6]));
    const TracedLoops traced = trace_loops(network(lines), costs, {});
    REQUIRE(traced.loops.size() == 1);
    CHECK(traced.loops[0].cost == Approx(4).margin(1e-12));
    CHECK(traced.loops[0].nonplanarity < 1e-12);
  }
  SECTION(
      "faces of a box by a right angle, octants not at all, a loop upon itself by a half turn") {
    for (const bool box : {true, false}) {
      const RegionGraph graph =
          network(box ? box_lines(Vec3::Zero(), Vec3(1, 1, 1)) : sphere_lines());
      const RegionSearchResult search = search_regions(graph, {}, costs, {});
      int met = 0;
      for (size_t c = 0; c < search.loops.size(); ++c)
        for (size_t d = c; d < search.loops.size(); ++d) {
          if (!search.selected.chosen[c] || !search.selected.chosen[d]) continue;
          const auto &a = search.loops[c], &b = search.loops[d];
          for (size_t i = 0; i < a.loop.size(); ++i)
            for (size_t j = 0; j < b.loop.size(); ++j) {
              if (a.loop[i].edge != b.loop[j].edge) continue;
              CHECK(fold_deg(a, i, b, j) == Approx(c == d ? 180 : box ? 90 : 0).margin(0.5));
              met += c != d;
            }
        }
      CHECK(met == 12);
    }
  }
}

TEST_CASE("frames are carried without turning", "[skinning][search]") {
  // Around a circle the binormal is constant.
  const RegionGraph graph(
      CurveNetwork({circular_arc("c", Vec3::Zero(), Vec3(1, 0, 0), Vec3(0, 1, 0), 0, 1.5)}));
  const GraphEdge& edge = graph.edges[0];
  CHECK((edge.parallel_transported(false, Vec3::UnitZ()) - Vec3::UnitZ()).norm() < 1e-12);
  CHECK(std::hypot(edge.turning_u, edge.turning_v) == Approx(1.5).epsilon(0.01));
  CHECK((edge.parallel_transported(true, edge.parallel_transported(false, edge.u[0])) - edge.u[0])
            .norm() < 1e-12);
}

TEST_CASE("the selection is the best one", "[skinning][search]") {
  Random random(5);
  for (int trial = 0; trial < 300; ++trial) {
    LoopSelectionProblem problem;
    const int edges = 6, items = 11;
    problem.capacity.assign(edges, 1 + trial % 3);
    for (int i = 0; i < items; ++i) {
      LoopSelectionProblem::Item item;
      item.gain = random.between(0, 3);
      for (int a = 0; a < edges; ++a)
        if (random() > 0.1) {
          item.edges.push_back(a);
          item.uses.push_back(random() > 0.8 ? 2 : 1);
        }
      if (!item.edges.empty()) problem.items.push_back(item);
    }
    const int n = static_cast<int>(problem.items.size());
    for (int i = 0; i < n; ++i)
      for (int j = i + 1; j < n; ++j)
        for (const int a : problem.items[i].edges)
          if (std::count(problem.items[j].edges.begin(), problem.items[j].edges.end(), a))
            problem.pairs.push_back({a, i, j, random.between(0, 1)});
    const auto value = [&](unsigned set) {
      std::vector<int> used(edges, 0);
      double sum = 0;
      for (int i = 0; i < n; ++i)
        if (set >> i & 1) {
          sum += problem.items[i].gain;
          for (size_t k = 0; k < problem.items[i].edges.size(); ++k)
            used[problem.items[i].edges[k]] += problem.items[i].uses[k];
        }
      for (const auto& p : problem.pairs)
        if ((set >> p.a & 1) && (set >> p.b & 1)) sum -= p.pair_cost;
      for (int a = 0; a < edges; ++a)
        if (used[a] > problem.capacity[a]) return -HUGE_VAL;
      return sum;
    };
    double best = 0;
    for (unsigned set = 0; set < 1u << n; ++set) best = std::max(best, value(set));
    const LoopSelection found = select_loops(problem);
    unsigned set = 0;
    for (int i = 0; i < n; ++i) set |= static_cast<unsigned>(found.chosen[i]) << i;
    CAPTURE(trial);
    CHECK(found.optimal);
    CHECK(found.value == Approx(best).margin(1e-9));
    CHECK(value(set) == Approx(best).margin(1e-9));
    CHECK(select_loops(problem, 0).bound >= best - 1e-9);
  }
}

#if BATTEN_TEST_IO
TEST_CASE("faces of real sketches are those that a designer expects", "[skinning][search][data]") {
  const std::string name = GENERATE("computer-mouse", "hat", "shield", "teapot", "vacuum");
  const auto file = optional_data("sketch-cassie/sketch_graph/" + name + ".json");
  if (file.empty()) {
    WARN("no sketches here");
    return;
  }
  const ExpectedSurfaces expected(reference("networks/" + name + ".json"));
  const NetworkWithRegions found(read_sketch_graph(file));
  const auto of_edge = SketchSegments(file).of_edges(RegionGraph(found.network));
  const ExpectedSurfaces::Score score = expected.score(found.regions.regions, of_edge);
  // Loops on a face are left to the user, with a message.
  std::set<int> offered = score.correct;
  for (const AmbiguousRegion& choice : found.regions.ambiguous_regions)
    for (const auto& loops : choice.alternatives)
      for (const EdgeLoop& loop : loops)
        if (const int which = expected.of(segments_along(loop, of_edge));
            loops.size() == 1 && which >= 0)
          offered.insert(which);
  CAPTURE(name, score.correct.size(), score.wrong, offered.size(), score.expected);
  CHECK(score.precision() >= 0.95);
  CHECK(score.recall() >= (name == "shield" ? 0.8 : 0.95));
  CHECK(static_cast<double>(offered.size()) >= 0.95 * score.expected);
  CHECK(found.regions.optimal);
}

TEST_CASE("all sketches are looked through without a crash", "[skinning][search][data]") {
  const auto folder = optional_data("sketch-cassie/sketch_graph");
  if (folder.empty()) {
    WARN("no sketches here");
    return;
  }
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".json") {
      CAPTURE(entry.path().string());
      const NetworkWithRegions found(read_sketch_graph(entry.path()));
      CHECK(found.regions.regions.size() > 10);
    }
}
#endif
