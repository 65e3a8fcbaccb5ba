// SPDX-License-Identifier: MPL-2.0
// Meshes and deformers of <batten/batten.h>: what is accepted, what is kept, and the words of
// refusals.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <numbers>
#include <set>
#include <thread>

#include "batten/batten.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/mesh/regions/arap_deformer.h"
#include "batten/mesh/selection.h"
#include "batten/scenes/mesh_data.h"
#include "batten/scenes/meshes/vertex_selector.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"

using namespace batten;
using namespace batten_test;

namespace {

const std::filesystem::path plate_file =
    BATTEN_SOURCE_DIR "/examples/10-plate-with-holes/plate.obj";
const std::filesystem::path deck_file = BATTEN_SOURCE_DIR "/examples/11-panel/panel.bdf";

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Points (i, j, 0) of a square with n×n quads. Vertex (i, j) has the number j (n+1) + i.
struct Square {
  std::vector<Vec3> points;
  std::vector<std::vector<int>> faces;

  explicit Square(int n) {
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) points.emplace_back(i, j, 0);
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = j * (n + 1) + i;
        faces.push_back({a, a + 1, a + n + 2, a + n + 1});
      }
  }

  /// Adds a rib of height 2 along the line x = i: three faces meet at each of its lower edges.
  void add_rib(int n, int i) {
    std::vector<int> below;
    for (int j = 0; j <= n; ++j) below.push_back(j * (n + 1) + i);
    for (int level = 1; level <= 2; ++level) {
      std::vector<int> above;
      for (int j = 0; j <= n; ++j) {
        above.push_back(static_cast<int>(points.size()));
        points.emplace_back(i, j, level);
      }
      for (size_t j = 0; j < static_cast<size_t>(n); ++j)
        faces.push_back({below[j], below[j + 1], above[j + 1], above[j]});
      below = above;
    }
  }

  Mesh mesh() const { return Mesh(points, faces); }
};

const Move up_and_round{.translate = {-40, 0, 110}, .axis = {0, -1, 0}, .angle = 75};

/// The plate with five holes: left border fixed, right border a handle, all holes features.
DeformerSettings plate_settings(const Mesh& plate) {
  DeformerSettings settings;
  settings.fixed = plate.vertices_in({0, 0, -1}, {0, 300, 1});
  settings.handles = {{"end", plate.vertices_in({300, 0, -1}, {300, 300, 1})}};
  for (const Hole& hole : plate.holes()) settings.features.push_back({hole.name, hole.vertices});
  return settings;
}

/// Largest relative change of the radius of a hole.
double change_of_radii(const std::vector<Hole>& holes, const Points& points) {
  double change = 0;
  for (const Hole& hole : holes) {
    const double radius = measure_hole(points, hole.loop).radius;
    REQUIRE(std::isfinite(radius));
    change = std::max(change, std::abs(radius / hole.radius - 1));
  }
  return change;
}

}  // namespace

TEST_CASE("triangles, quads, polygons and mixtures of them make a mesh", "[scenes][mesh]") {
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0.5, 0}};
  const Mesh triangles(points, {{0, 1, 2}, {0, 2, 3}});
  CHECK(triangles.triangles().size() == 2);
  CHECK(triangles.faces() == std::vector<std::vector<int>>{{0, 1, 2}, {0, 2, 3}});
  const Mesh mixed(points, {{0, 1, 2, 3}, {1, 4, 2}});
  CHECK(mixed.triangles().size() == 3);
  CHECK(mixed.triangle_faces() == std::vector<int>{0, 0, 1});
  CHECK(mixed.boundary_loops() == std::vector<std::vector<int>>{{0, 1, 4, 2, 3}});
  const Mesh polygon(points, {{0, 1, 4, 2, 3}});
  CHECK(polygon.triangles().size() == 3);
  CHECK(Mesh(points, std::vector<std::array<int, 3>>{{0, 1, 2}}).faces().size() == 1);
  const Mesh quad(points, std::vector<std::array<int, 4>>{{0, 1, 2, 3}});
  CHECK(quad.faces() == std::vector<std::vector<int>>{{0, 1, 2, 3}});
  CHECK(quad.points().rows() == 5);
  CHECK(quad.notes().empty());  // a vertex without a face is no defect
  CHECK(quad.format().empty());
  CHECK(quad.bounds().max() == Vec3(1, 1, 0));

  const Mesh copy = mixed;
  CHECK(&copy.points() == &mixed.points());
}

TEST_CASE("invalid faces and points are refused with their place", "[scenes][mesh]") {
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  const auto refusal = [&](const std::vector<std::vector<int>>& faces) {
    return error_message([&] { Mesh(points, faces); });
  };
  CHECK(refusal({{0, 1, 2}, {0, 1, 3}}) == "faces: found 3 in face 1 (from 0), expected 0 to 2");
  CHECK(refusal({{0, 1, -1}}) == "faces: found -1 in face 0 (from 0), expected 0 to 2");
  CHECK(refusal({{0, 1}}) == "faces: found 2 vertices in face 0 (from 0), expected 3 or more");
  CHECK_FALSE(refusal({}).empty());
  CHECK_FALSE(refusal({{0, 1, 1}}).empty());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(error_message([&] {
                Mesh({{0, 0, 0}, {1, 0, 0}, {1, nan, 0}}, {{0, 1, 2}});
              }).empty());

  const Mesh mesh(points, {{0, 1, 2}});
  CHECK(error_message([&] { mesh.vertices_in({0, 0, 1}, {1, 1, 0}); }).starts_with("box: found"));
  CHECK(error_message([&] { mesh.holes(-1); }).starts_with("flange_width: found -1"));
  CHECK(error_message([&] {
          mesh.save("x.obj", Points::Zero(2, 3));
        }).starts_with("points: found 2 rows, expected one for each of the 3 nodes"));
  CHECK(error_message([&] {
          mesh.save_as_read("x.obj", mesh.points());
        }).find("not read from a file") != std::string::npos);
  CHECK(error_message([&] { read_mesh("not_there.obj"); }).find("not_there.obj") !=
        std::string::npos);
}

TEST_CASE("holes are the boundary loops without the outline", "[scenes][mesh]") {
  const Mesh plate = read_mesh(plate_file);
  CHECK(plate.boundary_loops().size() == 6);
  const std::vector<Hole> holes = plate.holes();
  const std::vector<Vec3> centres{
      {45, 45, 0}, {255, 45, 0}, {150, 150, 0}, {45, 255, 0}, {255, 255, 0}};
  REQUIRE(holes.size() == centres.size());
  for (size_t i = 0; i < holes.size(); ++i) {
    const Hole& hole = holes[i];
    CHECK(hole.name == "hole-" + std::to_string(i + 1));
    CHECK((hole.centre - centres[i]).norm() < 1e-8);
    CHECK(hole.radius == Approx(i == 2 ? 42 : 18).epsilon(1e-9));
    CHECK(hole.circular);
    CHECK(std::abs(hole.axis.z()) == Approx(1));
    const std::set<int> vertices(hole.vertices.begin(), hole.vertices.end());
    CHECK(vertices.size() == hole.vertices.size());
    CHECK(vertices.size() > hole.loop.size());
    for (const int v : hole.loop) CHECK(vertices.count(v) == 1);
  }
  const double width = 20;
  CHECK(plate.holes(width)[0].vertices.size() > holes[0].vertices.size());
  CHECK(Square(3).mesh().holes().empty());
}

TEST_CASE("a box selects vertices with faces", "[scenes][mesh]") {
  Square square(4);
  square.points.emplace_back(0, 0, 0);  // belongs to no face
  const Mesh mesh = square.mesh();
  CHECK(mesh.vertices_in({0, 0, 0}, {0, 4, 0}) == std::vector<int>{0, 5, 10, 15, 20});
  CHECK(mesh.vertices_in(mesh.bounds()).size() == 25);
  CHECK(mesh.vertices_in({0.1, 0.1, 0}, {0.9, 0.9, 0}).empty());
  const double infinity = std::numeric_limits<double>::infinity();
  CHECK(mesh.vertices_in({3.5, -infinity, -infinity}, {infinity, infinity, infinity}).size() == 5);
}

TEST_CASE("meshes are written as they were read, and in other formats", "[scenes][mesh]") {
  const auto folder = std::filesystem::path(BATTEN_BINARY_DIR) / "scenes-test-meshes";
  std::filesystem::create_directories(folder);
  const Mesh deck = read_mesh(deck_file);
  CHECK(deck.format().find("Nastran") != std::string::npos);
  CHECK(deck.save_as_read(folder / "same.bdf", deck.points()) == 0);
  CHECK(bytes_of(folder / "same.bdf") == bytes_of(deck_file));

  const Mesh plate = read_mesh(plate_file);
  Points raised = plate.points();
  raised.col(2).array() += 1;
  plate.save(folder / "raised.obj", raised);
  plate.save(folder / "plate.vtu");
  CHECK(read_mesh(folder / "raised.obj").points() == raised);
  CHECK(read_mesh(folder / "plate.vtu").points() == plate.points());
  CHECK(read_mesh(folder / "plate.vtu").faces() == plate.faces());
  CHECK_FALSE(error_message([&] { plate.save(folder / "plate.glb"); }).empty());
  plate.save(folder / "plate.glb", "mm");
  CHECK(std::filesystem::file_size(folder / "plate.glb") > 0);

  const Mesh other = plate.with_points(raised);
  CHECK(other.points() == raised);
  CHECK(other.faces() == plate.faces());
  CHECK(other.sets().size() == plate.sets().size());
  CHECK(other.holes()[0].centre.z() == Approx(1));
}

TEST_CASE("holes stay rigid while a plate is bent", "[scenes][deformer]") {
  const Mesh plate = read_mesh(plate_file);
  const std::vector<Hole> holes = plate.holes();
  Deformer deformer(plate, plate_settings(plate));
  CHECK(deformer.unknowns() > 0);
  CHECK(deformer.notes().empty());
  CHECK(deformer.positions() == plate.points());
  const Points bent = deformer.deform({{"end", up_and_round}});
  CHECK(deformer.positions() == bent);
  CHECK(change_of_radii(holes, bent) < 1e-12);
  CHECK(deformer.residual() < 1e-12);
  CHECK(measure_hole(bent, holes[2].loop).centre.z() > 10);
  for (const int v : deformer.settings().fixed)
    CHECK((bent.row(v) - plate.points().row(v)).norm() < 1e-9);

  // Without features, the holes do change.
  DeformerSettings free = plate_settings(plate);
  free.features.clear();
  CHECK(change_of_radii(holes, Deformer(plate, free).deform({{"end", up_and_round}})) > 1e-4);

  // Edits do not add up, and one more solve changes rounding errors only.
  const Points corrected = deformer.deform({{"end", up_and_round}}, {}, true);
  CHECK((corrected - bent).cwiseAbs().maxCoeff() < 1e-3);
  CHECK((deformer.deform({}) - plate.points()).cwiseAbs().maxCoeff() < 1e-6);
  CHECK(deformer.deform({{"end", up_and_round}}) == bent);
}

TEST_CASE("a deformer gives the bits of the kernel's deformer", "[scenes][deformer]") {
  const Mesh plate = read_mesh(plate_file);
  const DeformerSettings settings = plate_settings(plate);
  DeformProblem problem;
  problem.fixed = settings.fixed;
  problem.handles = {{"end", settings.handles[0].vertices}};
  for (const VertexGroup& group : settings.features)
    problem.features.push_back({group.name, group.vertices});
  FormFeatureDeformer kernel(plate.data().mesh(), problem);
  const Vec3 about(300, 150, 0);
  const HandleTransform move{
      about, to_rotation_vector({0, -1, 0}, 75 * std::numbers::pi / 180), {-40, 0, 110}};
  Move same = up_and_round;
  same.about = about;
  Deformer deformer(plate, settings);
  CHECK(deformer.deform({{"end", same}}) == kernel.deform({{move}, {}, {}, {}}));

  // The mean of the handle's vertices is the default centre.
  Vec3 mean = Vec3::Zero();
  for (const int v : settings.handles[0].vertices) mean += plate.points().row(v).transpose();
  Move about_mean = up_and_round;
  about_mean.about = Vec3(mean / static_cast<double>(settings.handles[0].vertices.size()));
  CHECK(deformer.deform({{"end", up_and_round}}) == deformer.deform({{"end", about_mean}}));
}

TEST_CASE("features are scaled and keep their orientation", "[scenes][deformer]") {
  const Mesh plate = read_mesh(plate_file);
  const std::vector<Hole> holes = plate.holes();
  DeformerSettings settings = plate_settings(plate);
  settings.keep_orientation = {settings.features[2]};
  settings.features.erase(settings.features.begin() + 2);
  Deformer deformer(plate, settings);
  const double scale = 1.25;
  const Points bent = deformer.deform({{"end", up_and_round}}, {{"hole-1", scale}});
  CHECK(measure_hole(bent, holes[0].loop).radius == Approx(scale * holes[0].radius).epsilon(1e-12));
  CHECK(measure_hole(bent, holes[1].loop).radius == Approx(holes[1].radius).epsilon(1e-12));
  CHECK(degrees_between(measure_hole(bent, holes[2].loop).axis, holes[2].axis) < 1e-9);
  CHECK(degrees_between(measure_hole(bent, holes[1].loop).axis, holes[1].axis) > 1);
}

TEST_CASE("a region of interest moves alone", "[scenes][deformer]") {
  const Mesh mesh = Square(12).mesh();
  DeformerSettings settings;
  settings.handles = {{"middle", mesh.vertices_in({6, 6, 0}, {6, 6, 0})}};
  settings.region_of_interest = mesh.vertices_in({3, 3, 0}, {9, 9, 0});
  const Points moved = Deformer(mesh, settings).deform({{"middle", {.translate = {0, 0, 1}}}});
  const std::vector<int>& inside = *settings.region_of_interest;
  for (int v = 0; v < moved.rows(); ++v)
    if (!std::binary_search(inside.begin(), inside.end(), v))
      CHECK((moved.row(v) - mesh.points().row(v)).norm() < 1e-12);
  CHECK(moved(settings.handles[0].vertices.front(), 2) == Approx(1));
  CHECK(moved(5 * 13 + 5, 2) > 0.1);
}

TEST_CASE("unknown names are refused with the nearest one", "[scenes][deformer]") {
  const Mesh plate = read_mesh(plate_file);
  Deformer deformer(plate, plate_settings(plate));
  const auto refusal = [&](const std::map<std::string, Move>& moves,
                           const std::map<std::string, double>& scales = {}) {
    return error_message([&] { deformer.deform(moves, scales); });
  };
  CHECK(refusal({{"ende", {}}}) ==
        "moves: found 'ende', expected a handle's name; did you mean 'end'?");
  CHECK(refusal({}, {{"hole_1", 2}}) ==
        "scales: found 'hole_1', expected a feature's name; did you mean 'hole-1'?");
  CHECK(refusal({}, {{"flange of the door", 2}}) ==
        "scales: found 'flange of the door', expected a feature's name");
  CHECK(refusal({{"end", {.axis = Vec3::Zero()}}}) == "axis: found length 0, expected a direction");
  CHECK(refusal({{"end", {.scale = 0}}}).find("scale") != std::string::npos);
  CHECK(refusal({}, {{"hole-1", -1}}).find("hole-1") != std::string::npos);
  CHECK(deformer.positions() == plate.points());

  const auto invalid = [&](const DeformerSettings& settings) {
    return error_message([&] { Deformer(plate, settings); });
  };
  const std::string range = ", expected 0 to " + std::to_string(plate.points().rows() - 1);
  CHECK(invalid({.fixed = {-1}}) == "fixed: found -1" + range);
  CHECK(invalid({.handles = {{"end", {100000}}}}) == "handle 'end': found 100000" + range);
  CHECK_FALSE(invalid({.fixed = {0}, .handles = {{"end", {}}}}).empty());
  CHECK_FALSE(invalid({}).empty());
}

TEST_CASE("contradictory moves are a conflict of handles by name", "[scenes][deformer]") {
  const Mesh mesh = Square(4).mesh();
  Deformer deformer(mesh, {.fixed = {0}, .handles = {{"a", {12, 13}}, {"b", {13, 14}}}});
  CHECK_THROWS_AS(
      deformer.deform({{"a", {.translate = {0, 0, 1}}}, {"b", {.translate = {0, 0, 2}}}}),
      ConflictError);
  CHECK(deformer.positions() == mesh.points());
}

TEST_CASE("a mesh with a rib has one vertex per node for its users", "[scenes][deformer]") {
  constexpr int n = 6;
  Square square(n);
  square.add_rib(n, 3);
  const Mesh mesh = square.mesh();
  const auto nodes = static_cast<long>(square.points.size());
  REQUIRE(mesh.data().topology().vertex_count() > nodes);
  CHECK(mesh.points().rows() == nodes);
  for (const auto& triangle : mesh.triangles())
    for (const int v : triangle) CHECK(v < nodes);
  for (const auto& loop : mesh.boundary_loops())
    for (const int v : loop) CHECK(v < nodes);
  CHECK(mesh.vertices_in({3, 0, 0}, {3, n, 0}).size() == n + 1);

  DeformerSettings settings;
  settings.fixed = mesh.vertices_in({0, 0, 0}, {1, n, 0});
  settings.handles = {{"end", mesh.vertices_in({5, 0, 0}, {n, n, 0})}};
  Deformer deformer(mesh, settings);
  const Points moved = deformer.deform({{"end", {.translate = {0, 0, 1}}}});
  REQUIRE(moved.rows() == nodes);
  REQUIRE(moved.allFinite());
  for (const int v : settings.handles[0].vertices) CHECK(moved(v, 2) == Approx(1));
  CHECK(deformer.residual() < 1e-12);
}

namespace {

/// The square with two bumps of different heights.
Mesh bumps(const Vec3& shift = Vec3::Zero(), const Mat3& rotation = Mat3::Identity()) {
  constexpr int n = 30;
  Square square(n);
  for (Vec3& p : square.points) {
    p.z() = 2 * std::exp(-(p - Vec3(9, 12, 0)).squaredNorm() / 3) +
            std::exp(-(p - Vec3(20, 20, 0)).squaredNorm() / 3);
    p = rotation * p + shift;
  }
  return square.mesh();
}

}  // namespace

TEST_CASE("saliency is that of the kernel, and invariant under rigid motions", "[scenes][mesh]") {
  const Mesh mesh = bumps();
  const VecX saliency = mesh.saliency();
  CHECK(saliency == mesh_saliency(mesh.data().mesh()));
  CHECK(saliency.maxCoeff() == 1);
  // The length scale is the diagonal of the bounding box: these rotations keep it.
  const Mat3 rotation = Eigen::Quaterniond(1, 1, 1, 1).normalized().toRotationMatrix();
  CHECK((bumps({5, -7, 2}, rotation).saliency() - saliency).cwiseAbs().maxCoeff() < 1e-9);

  constexpr int n = 6;
  Square square(n);
  square.add_rib(n, 3);
  CHECK(square.mesh().saliency().size() == static_cast<long>(square.points.size()));
}

TEST_CASE("suggested features are the proposals of scenes", "[scenes][mesh]") {
  const Mesh panel = read_mesh(deck_file);
  SceneSelections scene;
  scene.proposals.nested = true;
  VertexSelector select(scene, panel.data().source.file, panel.data().mesh());
  const std::vector<DetectedFeature> features = panel.suggested_features(scene.proposals);
  REQUIRE(features.size() == select.proposals().size());
  REQUIRE(features.size() > 1);
  for (const DetectedFeature& feature : features) {
    CHECK(feature.vertices == select.of(LocatedString{feature.name, {}}));
    CHECK(feature.loop == select.proposal(feature.name)->loop);
  }
  const auto refusal = [&](const FeatureDetectionOptions& options) {
    return error_message([&] { panel.suggested_features(options); });
  };
  CHECK(refusal({.crease_degrees = 180}).starts_with("crease_angle: found 180"));
  CHECK(refusal({.flange_rings = 0}).starts_with("flange_rings: found 0"));
  CHECK(refusal({.flange_width = -2}).starts_with("flange_width: found -2"));
}

TEST_CASE("rotation modes give the bits of the kernel's editor", "[scenes][deformer]") {
  const Mesh plate = read_mesh(plate_file);
  DeformerSettings settings = plate_settings(plate);
  DeformProblem problem;
  problem.fixed = settings.fixed;
  problem.handles = {{"end", settings.handles[0].vertices}};
  for (const VertexGroup& group : settings.features)
    problem.features.push_back({group.name, group.vertices});
  const Vec3 about(300, 150, 0);
  Move move = up_and_round;
  move.about = about;
  DeformEdit edit;
  edit.handles = {
      {about, to_rotation_vector({0, -1, 0}, 75 * std::numbers::pi / 180), {-40, 0, 110}}};
  for (const RotationMode mode :
       {RotationMode::Estimated, RotationMode::Dual, RotationMode::Nonlinear}) {
    MeshEditor editor(plate.data().source.prepared, plate.points(), problem,
                      {.rotation_mode = mode, .keep_centres = false, .centres = {}});
    editor.set(edit);
    settings.rotation_mode = mode;
    Deformer deformer(plate, settings);
    CHECK(deformer.positions() == plate.points());
    CHECK(deformer.report().iterations == 0);
    const Points bent = deformer.deform({{"end", move}});
    CHECK(bent == editor.solve_to_equilibrium());
    CHECK(deformer.positions() == bent);
    CHECK(deformer.residual() == editor.statistics().hard_residual);
    CHECK(deformer.report().iterations == editor.statistics().iterations);
    CHECK(deformer.report().converged);
    CHECK(deformer.report().last_correction == editor.statistics().last_correction);
    CHECK(deformer.unknowns() == editor.counts().unknowns);
    CHECK(change_of_radii(plate.holes(), bent) < 1e-12);
  }
}

TEST_CASE("without features, a rotation mode gives the shape of its estimate",
          "[scenes][deformer]") {
  const Mesh plate = read_mesh(plate_file);
  DeformerSettings settings = plate_settings(plate);
  settings.features.clear();
  settings.rotation_mode = RotationMode::Nonlinear;
  const TriangleMesh& mesh = plate.data().mesh();
  ArapDeformer arap(mesh, settings.fixed, {{"end", settings.handles[0].vertices}});
  const auto moves =
      detail::transforms_of({{"end", up_and_round}}, {{"end", settings.handles[0].vertices}}, mesh);
  const Points found = Deformer(plate, settings).deform({{"end", up_and_round}});
  CHECK((found - arap.deform(moves)).cwiseAbs().maxCoeff() < 1e-7 * mesh.size());
}

TEST_CASE("constraints keep points on planes and lines", "[scenes][deformer]") {
  const Mesh plate = read_mesh(plate_file);
  const std::vector<Hole> holes = plate.holes();
  DeformerSettings settings = plate_settings(plate);
  const Vec3 normal(1, 0, 2), direction(3, 0, 1), origin(45, 50, 5);
  settings.constraints = {OnPlane{"plane", holes[2].loop, normal},
                          OnLine{"line", holes[0].loop, direction, origin}};
  const auto centre = [](const Points& points, const Hole& hole) {
    return VertexCombination::mean_of(hole.loop).at(points);
  };
  const Vec3 before = centre(plate.points(), holes[2]);
  for (const RotationMode mode : {RotationMode::Harmonic, RotationMode::Estimated}) {
    settings.rotation_mode = mode;
    Deformer deformer(plate, settings);
    const Points bent = deformer.deform({{"end", up_and_round}}, {}, true);
    CHECK(std::abs((centre(bent, holes[2]) - before).dot(normal)) < 1e-10);
    CHECK((centre(bent, holes[0]) - origin).cross(direction).norm() < 1e-10);
    CHECK((centre(bent, holes[2]) - before).norm() > 1);
    CHECK(deformer.residual() < 1e-12);
    const Vec3 other(150, 150, 20);
    const Points moved = deformer.deform({{"end", up_and_round}}, {}, true, {{"plane", other}});
    CHECK(std::abs((centre(moved, holes[2]) - other).dot(normal)) < 1e-10);
    CHECK((centre(moved, holes[0]) - origin).cross(direction).norm() < 1e-10);
    CHECK(deformer.deform({{"end", up_and_round}}, {}, true) == bent);
    CHECK(error_message([&] {
            deformer.deform({}, {}, false, {{"plan", other}});
          }) == "origins: found 'plan', expected a constraint's name; did you mean 'plane'?");
  }
}

TEST_CASE("chains and linear constraints shape a mesh", "[scenes][deformer]") {
  const Mesh mesh = Square(12).mesh();
  DeformerSettings settings;
  settings.fixed = mesh.vertices_in({0, 0, 0}, {1, 12, 0});
  settings.handles = {{"end", mesh.vertices_in({11, 0, 0}, {12, 12, 0})}};
  const std::map<std::string, Move> up{{"end", {.translate = {0, 0, 6}}}};
  const std::vector<int> rib = mesh.crease_path({{2, 6, 0}, {10, 6, 0}});
  REQUIRE(rib.size() == 9);
  const auto bend = [&](const Points& p) {  // second difference in the middle of the rib
    double sum = 0;
    for (size_t i = 1; i + 1 < rib.size(); ++i)
      sum += (p.row(rib[i - 1]) - 2 * p.row(rib[i]) + p.row(rib[i + 1])).norm();
    return sum;
  };
  const double free = bend(Deformer(mesh, settings).deform(up));
  settings.chains = {{"rib", rib, false, 100}};
  CHECK(bend(Deformer(mesh, settings).deform(up)) < 0.5 * free);
  const double length = (mesh.points().row(rib.back()) - mesh.points().row(rib.front())).norm();
  settings.chains[0].width = length / 10;
  const Points stated = Deformer(mesh, settings).deform(up);
  settings.chains[0].width = 0;
  CHECK(Deformer(mesh, settings).deform(up) == stated);

  const int v = rib[4];
  const Vec3 target(6, 6, 5);
  settings.linear_constraints = {{"pull", {{{v, 1.0}}}, target, -1, std::nullopt}};
  Deformer exact(mesh, settings);
  CHECK((exact.deform(up, {}, true).row(v).transpose() - target).norm() < 1e-10);
  const Vec3 higher(6, 6, 7);
  CHECK((exact.deform(up, {}, true, {}, {{"pull", higher}}).row(v).transpose() - higher).norm() <
        1e-10);
  CHECK(error_message([&] {
          exact.deform({}, {}, false, {}, {{"pill", higher}});
        }) == "targets: found 'pill', expected a linear constraint's name; did you mean 'pull'?");
  settings.linear_constraints[0].weight = 1;
  const double gap = (Deformer(mesh, settings).deform(up).row(v).transpose() - target).norm();
  settings.linear_constraints[0].weight = 100;
  const double less = (Deformer(mesh, settings).deform(up).row(v).transpose() - target).norm();
  CHECK(less > 1e-6);
  CHECK(less < gap);
}

TEST_CASE("invalid constraints are refused by name", "[scenes][deformer]") {
  const Mesh mesh = Square(4).mesh();
  const auto refusal = [&](const auto& change) {
    DeformerSettings settings{.fixed = {0}};
    change(settings);
    return error_message([&] { Deformer(mesh, settings); });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(refusal([](auto& s) {
          s.constraints = {OnPlane{"p", {25}}};
        }) == "constraint 'p': found 25, expected 0 to 24");
  CHECK(refusal([](auto& s) {
          s.constraints = {OnLine{"p", {}}};
        }).find("'p'") != std::string::npos);
  CHECK(refusal([](auto& s) {
          s.constraints = {OnPlane{"p", {3}, Vec3::Zero()}};
        }).find("'p'") != std::string::npos);
  CHECK(refusal([&](auto& s) {
          s.constraints = {OnPlane{"p", {3}, Vec3::UnitZ(), Vec3(0, 0, nan)}};
        }).starts_with("constraint 'p': found an origin that is not finite"));
  CHECK(refusal([](auto& s) {
          s.constraints = {OnPlane{"p", {3}}, OnLine{"p", {4}}};
        }).find("two") != std::string::npos);
  CHECK(refusal([](auto& s) {
          s.chains = {{"c", {1, 2, 25}}};
        }) == "chain 'c': found 25, expected 0 to 24");
  CHECK(refusal([](auto& s) { s.chains = {{"c", {1, 2}}}; }).find("'c'") != std::string::npos);
  CHECK(refusal([](auto& s) {
          s.chains = {{"c", {1, 2, 3}, false, -1}};
        }).find("width") != std::string::npos);
  CHECK(refusal([](auto& s) {
          s.linear_constraints = {{"l", {{{25, 1.0}}}, Vec3::Zero(), -1, std::nullopt}};
        }) == "linear constraint 'l': found 25, expected 0 to 24");
  CHECK(refusal([](auto& s) {
          s.linear_constraints = {{"l", {{{1, 1.0}}}, Vec3::Zero(), 25, std::nullopt}};
        }) == "linear constraint 'l', rotates_with: found 25, expected 0 to 24");
  CHECK(error_message([&] { mesh.crease_path({}); }).starts_with("through: found"));
  CHECK(error_message([&] { mesh.crease_path({{0, nan, 0}}); }).starts_with("through: found"));
}

TEST_CASE("constraints apply to the nodes of a rib", "[scenes][deformer]") {
  constexpr int n = 6;
  Square square(n);
  square.add_rib(n, 3);
  const Mesh mesh = square.mesh();
  const std::vector<int> foot = mesh.vertices_in({3, 0, 0}, {3, n, 0});
  DeformerSettings settings;
  settings.fixed = mesh.vertices_in({0, 0, 0}, {1, n, 0});
  settings.handles = {{"end", mesh.vertices_in({5, 0, 0}, {n, n, 0})}};
  settings.constraints = {OnPlane{"foot", foot, {0, 0, 1}, Vec3(0, 0, 2)}};
  settings.chains = {{"foot", foot}};
  for (const RotationMode mode : {RotationMode::Harmonic, RotationMode::Nonlinear}) {
    settings.rotation_mode = mode;
    Deformer deformer(mesh, settings);
    const Points moved = deformer.deform({{"end", {.translate = {0, 0, 1}}}}, {}, true);
    CHECK(moved.rows() == mesh.points().rows());
    CHECK(VertexCombination::mean_of(foot).at(moved).z() == Approx(2).epsilon(1e-12));
    CHECK(deformer.residual() < 1e-12);
  }
}

TEST_CASE("several threads may call one deformer", "[scenes][deformer]") {
  const Mesh mesh = Square(10).mesh();
  Deformer deformer(mesh, {.fixed = mesh.vertices_in({0, 0, 0}, {1, 10, 0}),
                           .handles = {{"end", mesh.vertices_in({9, 0, 0}, {10, 10, 0})}}});
  const auto height = [&](double z) {
    return deformer.deform({{"end", {.translate = {0, 0, z}}}});
  };
  const std::vector<double> heights{1, 2, 3, 4};
  std::vector<Points> expected, found(heights.size());
  for (const double z : heights) expected.push_back(height(z));
  std::vector<std::thread> threads;
  for (size_t i = 0; i < heights.size(); ++i)
    threads.emplace_back([&, i] {
      for (int repeat = 0; repeat < 10; ++repeat) found[i] = height(heights[i]);
    });
  for (std::thread& thread : threads) thread.join();
  for (size_t i = 0; i < heights.size(); ++i) CHECK(found[i] == expected[i]);
}
