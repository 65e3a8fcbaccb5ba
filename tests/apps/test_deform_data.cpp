// SPDX-License-Identifier: MPL-2.0
// Real meshes, if they are available: panels, scans, machine parts, invalid ones.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

#include "batten/core/geometry.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/element_quality.h"
#include "batten/mesh/features/feature_detection.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/mesh/selection.h"
#include "batten/tests/apps/cli_case.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/test_data.h"

using namespace batten;
using namespace batten_test;
namespace fs = std::filesystem;

namespace {

std::vector<fs::path> meshes_in(const std::string& folder) {
  std::vector<fs::path> files;
  const auto path = optional_data(folder);
  if (path.empty()) {
    WARN("skipped: no " << folder << " beside the project (BATTEN_TEST_DATA)");
    return files;
  }
  for (const auto& entry : fs::directory_iterator(path))
    for (const char* ending : {".off", ".obj", ".ply"})
      if (entry.path().extension() == ending) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

TEST_CASE("every manifold mesh is deformed once, its features kept", "[apps][deform][data]") {
  for (const char* folder : {"meshes-cgal", "meshes-pmp"})
    for (const fs::path& path : meshes_in(folder)) {
      INFO(path.string());
      const MeshFile file = MeshFile::read(path);
      const TriangleMesh mesh = prepare(file.shells()).mesh;
      // Fixed: a tenth of the first part at its lowest x; handle: the vertices farthest from it
      // along the surface.
      const auto& component = mesh.topology().component();
      double low = INFINITY, high = -INFINITY;
      for (int v = 0; v < mesh.vertex_count(); ++v)
        if (component[v] == 0) {
          low = std::min(low, mesh.point(v).x());
          high = std::max(high, mesh.point(v).x());
        }
      DeformProblem problem;
      for (int v = 0; v < mesh.vertex_count(); ++v)
        if (component[v] == 0 && mesh.point(v).x() <= low + 0.1 * (high - low))
          problem.fixed.push_back(v);
      const VecX distance = geodesic_distances(mesh, problem.fixed);
      int farthest = problem.fixed[0];
      for (int v = 0; v < mesh.vertex_count(); ++v)
        if (std::isfinite(distance[v]) && distance[v] > distance[farthest]) farthest = v;
      problem.handles = {{"handle", vertices_within(mesh, {farthest}, 0.1 * distance[farthest])}};
      // Proposals that touch neither are kept.
      for (const auto& p : detect_features(mesh))
        if (intersection_of(p.vertices, union_of(problem.handles[0].vertices, problem.fixed))
                .empty())
          problem.features.push_back({p.name, p.vertices});
      DeformEdit edit;
      edit.handles = {{}};
      edit.handles[0].about = mesh.point(farthest);
      edit.handles[0].translation = 0.1 * mesh.size() * Vec3(0.3, 0.2, 1).normalized();
      edit.handles[0].rotation_vector = to_rotation_vector({1, 0.5, 0.2}, 0.4);
      FormFeatureDeformer deformer(mesh, problem);
      deformer.deform(edit);
      deformer.correct();
      CHECK(deformer.correct() < 1e-9);
      CHECK(deformer.hard_residual() < 1e-12);
      for (const auto& f : problem.features)
        CHECK(fit_similarity(mesh.points(), deformer.positions(), f.vertices).max_error < 1e-12);
      // Stability: no vertex moves much farther than the handle.
      CHECK((deformer.positions() - mesh.points()).rowwise().norm().maxCoeff() < 0.6 * mesh.size());
    }
}

TEST_CASE("non-manifold meshes are prepared as manifold patches", "[apps][deform][data]") {
  const auto folder = optional_data("meshes-geometry-central");
  if (folder.empty()) {
    WARN("skipped: no meshes-geometry-central beside the project (BATTEN_TEST_DATA)");
    return;
  }
  const auto found = [&](const std::string& name) {
    return prepare(MeshFile::read(folder / name).shells()).diagnosis;
  };
  CHECK(!found("moebius.obj").orientable);
  CHECK(found("hourglass_ico.obj").non_manifold_node_count == 1);
  CHECK(found("fan3.obj").non_manifold_edge_count > 0);
  for (const char* plain : {"spot.ply", "fox.ply", "cat_head.obj"}) {
    CHECK(found(plain).orientable);
    CHECK(found(plain).non_manifold_edge_count + found(plain).non_manifold_node_count == 0);
  }
}

TEST_CASE("the bottle support: 13 holes exact while it is bent and stretched, deck untouched",
          "[apps][deform][data]") {
  const auto path = optional_data("panel-bottle-support/W1000BO_pid_1_a_tri.obj");
  if (path.empty()) {
    WARN("skipped: no panel-bottle-support beside the project (BATTEN_TEST_DATA)");
    return;
  }
  // As a Nastran deck in small field format.
  const MeshFile source = MeshFile::read(path);
  std::string deck = "$ bottle support\r\nBEGIN BULK\r\n";
  const auto field = [](double x) {
    char text[16];
    for (int digits = 5; digits >= 0; --digits) {
      std::snprintf(text, sizeof text, "%.*f", digits, x);
      if (std::string(text).size() <= 8) break;
    }
    return std::string(8 - std::string(text).size(), ' ') + text;
  };
  const auto whole = [](long x) {
    const std::string text = std::to_string(x);
    return std::string(8 - text.size(), ' ') + text;
  };
  const ShellMesh& shells = source.shells();
  for (int v = 0; v < shells.node_count(); ++v)
    deck += "GRID    " + whole(1000 + 3 * v) + "        " + field(shells.points(v, 0)) +
            field(shells.points(v, 1)) + field(shells.points(v, 2)) + "       0\r\n";
  for (int f = 0; f < shells.face_count(); ++f) {
    deck += "CTRIA3  " + whole(f + 1) + whole(1);
    for (const int v : shells.face(f)) deck += whole(1000 + 3 * v);
    deck += "\r\n";
  }
  deck += "PSHELL  1       1       1.2\r\nENDDATA\r\n";
  const auto folder = scratch("bottle");
  std::ofstream(folder / "support.bdf", std::ios::binary) << deck;
  const MeshFile file = MeshFile::read(folder / "support.bdf");
  const TriangleMesh mesh = prepare(file.shells()).mesh;

  DeformProblem problem;
  const auto beyond = [&](double x, double sign) {
    return vertices_beyond_plane(mesh, {x, 0, 0}, {sign, 0, 0});
  };
  problem.fixed = beyond(2880, -1);
  problem.handles = {{"right", beyond(3480, 1)}};
  std::vector<HoleMeasure> before;
  for (const auto& p : detect_features(mesh)) {
    problem.features.push_back({p.name, p.vertices});
    before.push_back(p.measure);
  }
  REQUIRE(problem.features.size() == 13);
  DeformEdit edit;
  edit.handles = {{}};
  edit.handles[0].about = VertexCombination::mean_of(problem.handles[0].vertices).at(mesh.points());
  edit.handles[0].translation = {54, 0, 88.9};  // an arc of 15 degrees, 1.1 times 621 mm long
  edit.handles[0].rotation_vector = to_rotation_vector({0, -1, 0}, 15 * std::numbers::pi / 180);
  FormFeatureDeformer deformer(mesh, problem);
  deformer.deform(edit);
  deformer.correct();
  CHECK(deformer.hard_residual() < 1e-12);
  const auto proposals = detect_features(mesh);
  for (size_t f = 0; f < 13; ++f) {
    CHECK(fit_similarity(mesh.points(), deformer.positions(), problem.features[f].vertices)
              .max_error < 1e-12);
    CHECK(measure_hole(deformer.positions(), proposals[f].loop).radius ==
          Approx(before[f].radius).epsilon(1e-12));
  }

  file.write(folder / "bent.bdf", deformer.positions());
  std::ifstream written(folder / "bent.bdf", std::ios::binary);
  const std::string bent((std::istreambuf_iterator<char>(written)), {});
  REQUIRE(bent.size() == deck.size());
  size_t row = 0;
  for (size_t i = 0; i < deck.size(); ++i) {
    if (bent[i] != deck[i]) {
      CHECK(deck.compare(row, 8, "GRID    ") == 0);
      CHECK((i - row >= 24 && i - row < 48));
    }
    if (deck[i] == '\n') row = i + 1;
  }
}

TEST_CASE("the body side: door openings rigid while sill and roof move", "[apps][deform][data]") {
  const auto path = optional_data("panel-neon-side/neon_side.off");
  if (path.empty()) {
    WARN("skipped: no panel-neon-side beside the project (BATTEN_TEST_DATA)");
    return;
  }
  const MeshFile file = MeshFile::read(path);
  const TriangleMesh mesh = prepare(file.shells()).mesh;
  DeformProblem problem;
  problem.fixed = union_of(vertices_in_box(mesh, {4075, -500, -1100}, {4200, 800, -500}),
                           vertices_in_box(mesh, {1100, -500, -1100}, {1500, 800, -500}));
  problem.handles = {{"sill", vertices_in_box(mesh, {2200, -420, -1100}, {4000, -330, -500})},
                     {"roof", vertices_in_box(mesh, {2300, 735, -1100}, {3200, 800, -500})}};
  int doors = 0;
  for (const auto& loop : mesh.topology().boundary_loops())
    if (mesh.length(loop) > 3000 && mesh.length(loop) < 4000)
      // The stepped flange: 45 mm along the surface.
      problem.features.push_back(
          {"door " + std::to_string(++doors), vertices_within(mesh, loop, 45)});
  REQUIRE(doors == 2);
  DeformEdit edit;
  edit.handles.resize(2);
  edit.handles[0].translation = {0, 0, 30};
  edit.handles[1].translation = {0, -20, 0};
  FormFeatureDeformer deformer(mesh, problem);
  const Points p = deformer.deform(edit);
  CHECK(deformer.hard_residual() < 1e-13);
  for (const auto& f : problem.features) {
    const Similarity fit = fit_similarity(mesh.points(), p, f.vertices);
    CHECK(fit.max_error < 1e-13);
    CHECK(fit.translation.norm() > 0);
  }
  CHECK(inverted_faces(file.shells(), mesh.points(), p).empty());
}

TEST_CASE("the sill of a body side is faired and pulled by one spring, door openings stay rigid",
          "[apps][deform][data]") {
  const auto path = optional_data("panel-neon-side/neon_side.off");
  if (path.empty()) {
    WARN("skipped: no panel-neon-side beside the project (BATTEN_TEST_DATA)");
    return;
  }
  const CliCase c("sill");
  c.file("sill.toml", "unit = \"mm\"\nmesh = \"" + path.string() + "\"\n" + R"(
[[select]]
name = "ends"
any = ["front", "rear"]
[[select]]
name = "front"
box = [[1100, -500, -1100], [1500, 800, -500]]
[[select]]
name = "rear"
box = [[4075, -500, -1100], [4200, 800, -500]]
[[select]]
name = "edge 1"
loop = 3
[[select]]
name = "edge 2"
loop = 4
[[select]]
name = "door 1"
geodesic = { of = "edge 1", distance = 45 }
[[select]]
name = "door 2"
geodesic = { of = "edge 2", distance = 45 }
[[feature]]
name = "door 1"
[[feature]]
name = "door 2"
[[curve]]
name = "sill"
through = [[2360, -382, -822], [3000, -389, -821], [3900, -391, -822]]
deviation = 1.0
[[curve.spring]]
name = "pull"
at = [3100, -390, -821]
to = [3100, -425, -835]
stiffness = 800
[[edit]]
name = "pulled"
fixed = ["ends"]
)");
  const CliResult r = c.run({"run", "sill.toml", "--out", "out"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  const auto j = report(c, "out");
  const auto& sill = j["curves"][0];
  CHECK(sill["max_residual"].get<double>() < 1e-12);
  CHECK(sill["fairing"]["max"].get<double>() <= 1.0);
  CHECK(sill["largest_displacement"].get<double>() > 20);
  CHECK(sill["after"]["bending"].get<double>() < 0.1 * sill["before"]["bending"].get<double>());
  CHECK(sill["after"]["extrema"].get<int>() < 20);
  REQUIRE(j["features"].size() == 2);
  for (const auto& f : j["features"]) {
    CHECK(f["max_rigid_error"].get<double>() < 1e-12);
    CHECK(f["displacement"].get<double>() > 1);
  }
  CHECK(j["quality"]["inverted"].empty());
  CHECK(j["hard_constraints"]["max_residual"].get<double>() < 1e-12);
}
