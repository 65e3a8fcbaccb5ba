// SPDX-License-Identifier: MPL-2.0
// The network of the computer mouse under random changes: order and direction of curves, displaced
// ends, missing or duplicate curves.
#include <algorithm>
#include <limits>
#include <random>
#include <set>

#include "batten/core/errors.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/io/scene/scene.h"
#include "batten/skinning/search/find_regions.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/skinning/surfaces/surface_model.h"
#include "batten/tests/support/catch.h"

using namespace batten;

namespace {

constexpr double kCorner = 60;  // as in the scene
constexpr double kEdge = 20;    // coarse: only the topology matters

struct Line {
  std::string name;
  std::vector<Vec3> points;
  bool closed() const { return points.front() == points.back(); }
};

struct MouseModel {
  CurveNetwork network;
  FoundRegions found;
  SurfaceModel model;
};

class Mouse {
 public:
  Mouse() : scene_(read_scene(std::string(BATTEN_SOURCE_DIR) + "/examples/09-mouse/scene.toml")) {
    for (const SceneLine& line : scene_.lines) lines.push_back({line.name, line.points});
  }

  std::vector<Line> lines;

  /// `without`: omits the settings of this curve from the scene.
  MouseModel make(const std::vector<Line>& given, const std::string& without = "") const {
    std::vector<CharacterLine> curves;
    for (const Line& line : given)
      curves.push_back({line.name, curve_through_points(line.name, line.points, kCorner)});
    NetworkOptions options;
    options.corner_angle = kCorner;
    CurveNetwork network(curves, options);
    RegionSearchOptions specs;
    for (const RegionSpec& spec : scene_.network.regions)
      if (std::none_of(spec.loops.begin(), spec.loops.end(), [&](const auto& loop) {
            return std::count(loop.begin(), loop.end(), without) > 0;
          }))
        specs.specs.push_back(spec);
    FoundRegions found = find_regions(network, specs);
    ModelOptions how;
    how.skin.edge_length = kEdge;
    how.material = scene_.skin.material;
    how.max_join_rounds = 0;
    for (const JoinSpec& spec : scene_.network.joins)
      if (spec.line != without) how.joins.push_back(spec);
    SurfaceModel model = skin_network(network, found, how);
    return {std::move(network), std::move(found), std::move(model)};
  }

 private:
  Scene scene_;
};

Vec3 middle(const NetworkEdge& edge) { return edge.curve.evaluate(0.5 * edge.curve.end()); }

using RegionEdges = std::multiset<std::multiset<int>>;

// Faces by their edges; each edge is mapped to the closest one of `first` on the same curve.
RegionEdges region_edges(const MouseModel& made, const MouseModel& first) {
  std::vector<int> same;
  for (const NetworkEdge& edge : made.network.edges()) {
    int best = -1;
    double least = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < first.network.edges().size(); ++i) {
      const NetworkEdge& other = first.network.edges()[i];
      const double d = (middle(other) - middle(edge)).norm();
      if (first.network.lines()[static_cast<size_t>(other.line)].name !=
              made.network.lines()[static_cast<size_t>(edge.line)].name ||
          d >= least)
        continue;
      best = static_cast<int>(i);
      least = d;
    }
    same.push_back(best);
  }
  RegionEdges plan;
  for (const NetworkRegion& region : made.found.regions) {
    std::multiset<int> edges;
    for (const EdgeLoop& loop : region.loops)
      for (const OrientedEdge& use : loop) edges.insert(same[static_cast<size_t>(use.edge)]);
    plan.insert(std::move(edges));
  }
  return plan;
}

bool whole(const MouseModel& made) {
  return made.model.defects.empty() && made.model.shells.size() == 1 &&
         made.model.shells[0].closed && made.model.shells[0].orientable &&
         made.model.shells[0].volume > 0 &&
         made.model.skinned().size() == made.model.regions.size();
}

// Largest distance between two models with the same meshes; infinite if these differ. Only inside
// the trim: the outer parts of cut triangles are hardly constrained.
double apart(const SurfaceModel& a, const SurfaceModel& b) {
  constexpr double other = std::numeric_limits<double>::infinity();
  const auto all_a = a.skinned(), all_b = b.skinned();
  if (all_a.size() != all_b.size()) return other;
  const Vec3 places[] = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ(), Vec3::Constant(1.0 / 3)};
  double most = 0;
  for (size_t r = 0; r < all_a.size(); ++r) {
    const Surface &x = all_a[r]->surface, &y = all_b[r]->surface;
    if (x.mesh().triangles() != y.mesh().triangles()) return other;
    for (int t = 0; t < x.mesh().triangle_count(); ++t)
      for (const Vec3& L : places) {
        Vec2 p = Vec2::Zero();
        for (int i = 0; i < 3; ++i) p += L[i] * x.mesh().vertices()[x.mesh().triangles()[t][i]];
        if (x.trim() && !x.trim()->loops().contains(p)) continue;
        most = std::max(most, (x.position({t, L}) - y.position({t, L})).norm());
      }
  }
  return most;
}

using DiagnosticKind = NetworkDiagnostic::Kind;

// Whether a diagnostic of one of these kinds is about these curves.
bool named(const MouseModel& made, const std::vector<DiagnosticKind>& kinds,
           const std::vector<std::string>& lines) {
  return std::any_of(made.network.diagnostics().begin(), made.network.diagnostics().end(),
                     [&](const auto& finding) {
                       return std::count(kinds.begin(), kinds.end(), finding.kind) > 0 &&
                              std::all_of(lines.begin(), lines.end(), [&](const std::string& line) {
                                return std::count(finding.lines.begin(), finding.lines.end(),
                                                  line) > 0;
                              });
                     });
}

// A dangling end, a free edge, an ambiguity, a failed face: anything that is reported to the user.
bool has_diagnostics(const MouseModel& made) {
  return !made.found.free_edges.empty() || !made.found.unused_edges.empty() ||
         !made.found.ambiguous_regions.empty() || !made.model.defects.empty() ||
         made.model.skinned().size() != made.model.regions.size() ||
         std::any_of(made.network.diagnostics().begin(), made.network.diagnostics().end(),
                     [](const auto& finding) { return !finding.repaired; });
}

class RandomEdits {
 public:
  explicit RandomEdits(unsigned seed) : random_(seed) {}

  double between(double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random_);
  }
  size_t below(size_t n) { return std::uniform_int_distribution<size_t>(0, n - 1)(random_); }
  Vec3 direction() {
    for (;;) {
      const Vec3 v(between(-1, 1), between(-1, 1), between(-1, 1));
      if (v.norm() < 1 && v.norm() > 0.1) return v.normalized();
    }
  }
  void shuffle(std::vector<Line>& lines) {
    for (size_t i = lines.size(); i > 1; --i) std::swap(lines[i - 1], lines[below(i)]);
    for (Line& line : lines)
      if (below(2)) std::reverse(line.points.begin(), line.points.end());
  }
  Line& open_line(std::vector<Line>& lines) {
    for (;;) {
      Line& line = lines[below(lines.size())];
      if (!line.closed()) return line;
    }
  }
  void move_end(Line& line, double by) {
    (below(2) ? line.points.front() : line.points.back()) += by * direction();
  }

 private:
  std::mt19937 random_;
};

void check_changes(int count, unsigned seed) {
  const Mouse mouse;
  const MouseModel first = mouse.make(mouse.lines);
  REQUIRE(first.found.regions.size() == 11);
  REQUIRE(whole(first));
  const RegionEdges plan = region_edges(first, first);
  const double tolerance = first.network.tolerance(), size = first.network.size();

  double most_apart = 0;
  int loose = 0;
  for (int i = 0; i < count; ++i) {
    RandomEdits change(seed + static_cast<unsigned>(i));
    std::vector<Line> lines = mouse.lines;
    change.shuffle(lines);
    INFO("change " << i << " of kind " << i % 6 << ", seed " << seed);
    switch (i % 6) {
      case 0: {
        const MouseModel made = mouse.make(lines);
        REQUIRE(region_edges(made, first) == plan);
        most_apart = std::max(most_apart, apart(made.model, first.model));
        REQUIRE(most_apart <= 1e-12 * size);
        break;
      }
      case 1: {  // all ends: any two remain within the tolerance
        for (Line& line : lines)
          if (!line.closed())
            for (Vec3* end : {&line.points.front(), &line.points.back()})
              *end += change.between(0, 0.499) * tolerance * change.direction();
        const MouseModel made = mouse.make(lines);
        REQUIRE(region_edges(made, first) == plan);
        REQUIRE(whole(made));
        break;
      }
      case 2: {  // one end, by almost the tolerance
        change.move_end(change.open_line(lines), change.between(0.5, 0.99) * tolerance);
        const MouseModel made = mouse.make(lines);
        REQUIRE(region_edges(made, first) == plan);
        REQUIRE(whole(made));
        break;
      }
      case 3: {  // beyond it
        Line& line = change.open_line(lines);
        change.move_end(line, change.between(1.2, 20) * tolerance);
        const MouseModel made = mouse.make(lines);
        INFO("line '" << line.name << "'");
        // An end that moved along another curve still meets it. An end that moved across a curve onto
        // a third one is connected to both of them, and the model has one face more.
        const bool meets =
            whole(made) && (region_edges(made, first) == plan ||
                            (named(made, {DiagnosticKind::EndOnLine}, {line.name}) &&
                             named(made, {DiagnosticKind::Crossing}, {line.name}) &&
                             made.found.regions.size() == first.found.regions.size() + 1));
        REQUIRE((meets ||
                 named(made, {DiagnosticKind::NearMiss, DiagnosticKind::Dangling}, {line.name})));
        loose += !meets;
        break;
      }
      case 4: {  // duplicate
        Line copy = lines[change.below(lines.size())];
        const Vec3 moved = change.between(0, 0.9) * tolerance * change.direction();
        for (Vec3& p : copy.points) p += moved;
        const std::string name = copy.name;
        copy.name += " again";
        lines.push_back(copy);
        change.shuffle(lines);
        const MouseModel made = mouse.make(lines, name);
        INFO("line '" << name << "'");
        REQUIRE(
            named(made, {DiagnosticKind::Duplicate, DiagnosticKind::Overlap}, {name, copy.name}));
        break;
      }
      default: {  // missing
        const size_t gone = change.below(lines.size());
        const std::string name = lines[gone].name;
        lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(gone));
        INFO("line '" << name << "'");
        const MouseModel made = mouse.make(lines, name);
        // Another closed body with fewer faces, or the open part is reported.
        REQUIRE(region_edges(made, first) != plan);
        REQUIRE((whole(made) || has_diagnostics(made)));
        if (name == "base" || name == "belt" || name == "seam")
          REQUIRE_THROWS_AS(mouse.make(lines), InputError);
      }
    }
  }
  CHECK(most_apart <= 1e-12 * size);
  CHECK(loose > count / 12);  // half of those that were moved away
}

}  // namespace

TEST_CASE("a mouse from curves in any order and direction, moved, missing, doubled",
          "[io][scene][network][mouse]") {
  check_changes(40, 1);
}

TEST_CASE("a mouse under a thousand changes", "[io][scene][.long][network][mouse]") {
  check_changes(1000, 1000);
}
