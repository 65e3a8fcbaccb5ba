// SPDX-License-Identifier: MPL-2.0
// Hand-drawn networks: results for the twelve connected sketches of the CASSIE study, and the
// distance of surfaces over five computed networks from the meshes that these were cut from,
// compared with hole filling of the same loops. Needs those files, and reports if they are absent.
#include <vtkCellArray.h>
#include <vtkCellLocator.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "batten/fairing/curves/curve_through_points.h"
#include "batten/io/lines/curve_files.h"
#include "batten/io/lines/drawing.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/skinning/domains/hole_triangulation.h"
#include "batten/skinning/facets/facets.h"
#include "batten/skinning/search/find_regions.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/skinning/surfaces/surface_model.h"
#include "batten/tests/support/sketch_segments.h"
#include "batten/tests/support/test_data.h"
#include "bench.h"

namespace {

using namespace batten;
using namespace batten::bench;
namespace fs = std::filesystem;

struct SkinnedSketch {
  std::unique_ptr<CurveNetwork> network;
  FoundRegions found;
  SurfaceModel model;
  double seconds = 0;
};

SkinnedSketch make(const std::vector<CharacterLine>& lines) {
  SkinnedSketch made;
  made.seconds = wall_seconds_of([&] {
    made.network = std::make_unique<CurveNetwork>(lines);
    made.found = find_regions(*made.network);
    made.model = skin_network(*made.network, made.found);
  });
  return made;
}

// Triangles, and distances of points from them.
class Triangles {
 public:
  void add(const Vec3& a, const Vec3& b, const Vec3& c) {
    cells_->InsertNextCell(3);
    for (const Vec3& p : {a, b, c}) cells_->InsertCellPoint(points_->InsertNextPoint(p.data()));
  }
  void ready() {
    data_->SetPoints(points_);
    data_->SetPolys(cells_);
    locator_->SetDataSet(data_);
    locator_->BuildLocator();
  }
  bool empty() const { return points_->GetNumberOfPoints() == 0; }
  double distance(const Vec3& p) {
    double nearest[3], squared = 0;
    vtkIdType cell = 0;
    int sub = 0;
    locator_->FindClosestPoint(p.data(), nearest, cell, sub, squared);
    return std::sqrt(squared);
  }

 private:
  vtkNew<vtkPoints> points_;
  vtkNew<vtkCellArray> cells_;
  vtkNew<vtkPolyData> data_;
  vtkNew<vtkCellLocator> locator_;
};

struct DistanceStatistics {
  double max = 0, squares = 0;
  int count = 0;
  void add(double distance) {
    max = std::max(max, distance);
    squares += distance * distance;
    ++count;
  }
  double rms() const { return count > 0 ? std::sqrt(squares / count) : 0; }
};

void add_surfaces(const SkinnedSketch& made, Triangles& ours, Triangles& plain) {
  for (const ModelRegion& r : made.model.regions) {
    if (!r.skinned) continue;
    const DisplayFacets f = facets(*r.skinned, 3);
    std::vector<Vec3> x;
    for (const Location& p : f.tessellation.points) x.push_back(r.skinned->surface.position(p));
    for (const auto& t : f.tessellation.facets) ours.add(x[t[0]], x[t[1]], x[t[2]]);
    std::vector<Vec3> loop;
    for (const OrientedEdge& use : r.plan.loops[0]) {
      const HermiteCurve& curve = made.network->edges()[use.edge].curve;
      constexpr int per_edge = 16;
      for (int i = 0; i < per_edge; ++i) {
        const double s = static_cast<double>(i) / per_edge;
        loop.push_back(curve.evaluate(curve.end() * (use.reversed ? 1 - s : s)));
      }
    }
    if (const auto fill = triangulate_hole(loop))
      for (const auto& t : fill->triangles) plain.add(loop[t[0]], loop[t[1]], loop[t[2]]);
  }
}

// Bilinearly blended Coons patches of the faces with four curves, and Batten's surfaces there.
void add_coons(const SkinnedSketch& made, Triangles& ours, Triangles& coons) {
  constexpr int n = 16;
  for (const ModelRegion& r : made.model.regions) {
    if (!r.skinned || r.plan.loops.size() != 1 || r.plan.loops[0].size() != 4) continue;
    const DisplayFacets f = facets(*r.skinned, 3);
    for (const auto& t : f.tessellation.facets) {
      const auto at = [&](int k) {
        return r.skinned->surface.position(f.tessellation.points[static_cast<size_t>(t[k])]);
      };
      ours.add(at(0), at(1), at(2));
    }
    // Point of side k at the fraction s of the loop parameter.
    const auto side = [&](size_t k, double s) -> Vec3 {
      const OrientedEdge& use = r.plan.loops[0][k];
      const HermiteCurve& curve = made.network->edges()[use.edge].curve;
      return curve.evaluate(curve.end() * (use.reversed ? 1 - s : s));
    };
    const auto patch = [&](int i, int j) -> Vec3 {
      const double s = static_cast<double>(i) / n, t = static_cast<double>(j) / n;
      const Vec3 corners = (1 - s) * (1 - t) * side(0, 0) + s * (1 - t) * side(1, 0) +
                           s * t * side(2, 0) + (1 - s) * t * side(3, 0);
      return (1 - t) * side(0, s) + t * side(2, 1 - s) + (1 - s) * side(3, 1 - t) + s * side(1, t) -
             corners;
    };
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        coons.add(patch(i, j), patch(i + 1, j), patch(i + 1, j + 1));
        coons.add(patch(i, j), patch(i + 1, j + 1), patch(i, j + 1));
      }
  }
}

// The largest and the median value, over smooth edges, of the median curvature jump times the size.
std::array<double, 2> curvature_jumps(const SurfaceModel& model) {
  std::vector<double> jumps;
  for (const ModelJoin& j : model.joins)
    if (j.kind == ModelJoin::Kind::Smooth && j.curvature)
      jumps.push_back(j.median_curvature_jump * model.layout->size());
  if (jumps.empty()) return {};
  return {*std::max_element(jumps.begin(), jumps.end()), median(jumps)};
}

// Fairs a model and adds a row with the results. Returns the number of defects that it added.
int add_fair_row(const char* name, SkinnedSketch& made, Table& table, Checks& checks) {
  auto layout = made.model.layout;
  if (!layout) {
    table.add({name, "", "no face has a surface"});
    return 0;
  }
  const size_t defects = made.model.defects.size();
  const auto before = curvature_jumps(made.model);
  MinimumVariationSurface fair;
  size_t unchanged_regions = 0;
  double seconds = 0;
  try {
    FairingResult faired;
    seconds =
        wall_seconds_of([&] { faired = fair_model(made.model, layout, made.model.dofs, 0.1); });
    layout = faired.layout;
    fair = std::move(faired.surface);
    unchanged_regions = faired.unchanged_regions.size();
  } catch (const std::exception& e) {
    table.add({name, std::to_string(layout->mesh()->triangle_count()),
               std::string(e.what()).substr(0, 60)});
    return 0;
  }
  std::vector<SkinnedRegion> regions;
  for (int r = 0; r < layout->region_count(); ++r) regions.push_back(layout->skinned(r, fair.dofs));
  reshape(made.model, layout, fair.dofs, std::move(regions));
  const auto after = curvature_jumps(made.model);
  double join = 0;
  for (const ModelJoin& j : made.model.joins)
    if (j.kind == ModelJoin::Kind::Smooth) join = std::max(join, j.max_inside_deg);
  table.add({name, std::to_string(layout->mesh()->triangle_count()), text("%.2f", seconds),
             std::to_string(fair.factorizations), fair.converged ? "yes" : "no",
             text("%.3f", fair.max_move / layout->size()),
             text("%.2e", fair.start_functional) + " -> " + text("%.2e", fair.functional),
             std::to_string(defects) + " -> " + std::to_string(made.model.defects.size()),
             std::to_string(unchanged_regions), text("%.2g", join),
             text("%.2g", before[1]) + " -> " + text("%.2g", after[1])});
  checks.at_most(std::string("degrees at smooth edges of the fair shape, ") + name, join, 0.1);
  return isize(made.model.defects) - static_cast<int>(defects);
}

// Compares with the surfaces and creases that a reader of the drawing expects.
void score(const fs::path& sketch, const SkinnedSketch& made, Checks& checks,
           std::vector<std::string>& notes) {
  const std::string name = sketch.stem().string();
  const fs::path file = fs::path(BATTEN_SOURCE_DIR) / "tests/reference/networks" / (name + ".json");
  if (!fs::exists(file)) return;
  const batten_test::ExpectedSurfaces expected(nlohmann::json::parse(std::ifstream(file)));
  const auto of_edge = batten_test::SketchSegments(sketch).of_edges(RegionGraph(*made.network));
  const auto s = expected.score(made.found.regions, of_edge);
  checks.at_least("precision, " + name, s.precision(), 0.97);
  checks.at_least("recall, " + name, s.recall(), 0.95);
  if (!expected.knows_creases()) return;
  const auto creases = expected.creases(made.model.joins, of_edge);
  checks.at_least("precision of creases, " + name, creases.precision(), 0.95);
  checks.at_least("recall of creases, " + name, creases.recall(), 0.95);
  for (const std::string& line : creases.wrong)
    notes.push_back(name + ": " + line + " is a crease; smooth was expected");
  for (const std::string& line : creases.missed)
    notes.push_back(name + ": " + line + " is smooth; a crease was expected");
}

}  // namespace

// With an argument: only the sketches and networks whose names contain it.
int main(int argc, char** argv) {
  const auto left_out = [&](const char* name) {
    return argc > 1 && std::string(name).find(argv[1]) == std::string::npos;
  };
  const std::vector<std::string> fair_head = {
      "faired",     "triangles",           "s",       "factors", "converged",
      "move/size",  "curvature variation", "defects", "kept",    "edge deg",
      "jump x size"};
  Checks checks;
  const auto sketches = batten_test::optional_data("sketch-cassie/sketch_graph");
  if (sketches.empty()) {
    std::printf("Skipped: no sketches (BATTEN_TEST_DATA).\n");
  } else {
    Table table;
    table.add({"sketch", "curves", "repaired", "listed", "edges", "faces", "skinned", "smooth",
               "open", "creases", "free edges", "unused", "ambiguous", "defects", "min J",
               "edge deg", "s"});
    Table fair;
    fair.add(fair_head);
    std::vector<std::string> notes;
    int unnamed = 0;
    for (const char* name :
         {"computer-mouse", "hat", "shield", "teapot", "vacuum", "guitar", "vintage_car",
          "hmd_modern", "architecture", "02-1-2", "02-2-2", "03-1-1"}) {
      if (left_out(name)) continue;
      const fs::path file = sketches / (std::string(name) + ".json");
      SkinnedSketch made = make(read_sketch_graph(file));
      int repaired = 0, listed = 0, skinned = 0, smooth = 0, open = 0, creases = 0;
      for (const NetworkDiagnostic& f : made.network->diagnostics())
        ++(f.repaired ? repaired : listed);
      double jacobian = 1, join = 0;
      for (const ModelRegion& r : made.model.regions) {
        if (!r.skinned) {
          notes.push_back(std::string(name) + ", " + r.plan.name +
                          " not skinned: " + r.rejection_reason);
          continue;
        }
        ++skinned;
        jacobian = std::min(jacobian, r.quality.min_jacobian_ratio);
        const bool wrong = !(r.quality.min_jacobian_ratio > 0);
        const auto index = static_cast<int>(&r - made.model.regions.data());
        const bool said = std::any_of(
            made.model.defects.begin(), made.model.defects.end(), [&](const SurfaceDefect& f) {
              return std::count(f.regions.begin(), f.regions.end(), index) > 0;
            });
        unnamed += wrong && !said;
      }
      for (const ModelJoin& j : made.model.joins) {
        smooth += j.kind == ModelJoin::Kind::Smooth;
        creases += j.kind == ModelJoin::Kind::Crease;
        if (j.kind != ModelJoin::Kind::Smooth) continue;
        open += j.open[0] || j.open[1];
        join = std::max(join, j.max_inside_deg);
      }
      for (const SurfaceDefect& f : made.model.defects)
        notes.push_back(std::string(name) + ": " + f.text);
      table.add({name, std::to_string(made.network->lines().size()), std::to_string(repaired),
                 std::to_string(listed), std::to_string(made.network->edges().size()),
                 std::to_string(made.model.regions.size()), std::to_string(skinned),
                 std::to_string(smooth), std::to_string(open), std::to_string(creases),
                 std::to_string(made.found.free_edges.size()),
                 std::to_string(made.found.unused_edges.size()),
                 std::to_string(made.found.ambiguous_regions.size()),
                 std::to_string(made.model.defects.size()), text("%.2f", jacobian),
                 text("%.2g", join), text("%.2f", made.seconds)});
      score(file, made, checks, notes);
      const int added = add_fair_row(name, made, fair, checks);
      checks.at_most(std::string("defects that fairing adds, ") + name, added, 0);
    }
    table.print();
    fair.print();
    for (const std::string& note : notes) std::printf("%s\n", note.c_str());
    std::printf("\n");
    checks.at_most("inverted surfaces that are not reported", unnamed, 0);
  }

  const auto shells = batten_test::optional_data("curvenet-shells");
  if (!shells.empty()) {
    // The meshes' vertices are on the surfaces that the networks were cut from; between them a mesh
    // has only its facets. Vertices outside the faces that were found are excluded.
    std::printf("Distances of the stored meshes' vertices over the meshes' size.\n");
    Table table;
    table.add({"network", "curves", "edges", "faces", "skinned", "smooth", "defects", "vertices",
               "max", "rms", "fair: max", "fair: rms", "hole filling: max", "rms", "four-sided",
               "rms", "fair: rms", "Coons: rms", "s"});
    Table fair;
    fair.add(fair_head);
    for (const auto& [lines_file, mesh_file] : {std::pair("hill_3", "hill"),
                                                {"shell_3", "shell"},
                                                {"tent_3_regular_curves", "tent"},
                                                {"roof_75", "roof"},
                                                {"shell_100", "shell"}}) {
      if (left_out(lines_file)) continue;
      std::vector<CharacterLine> lines;
      for (const auto& line :
           read_point_lines(shells / "curves" / (std::string(lines_file) + ".txt")))
        lines.push_back({line.name, curve_through_points(line.name, line.points)});
      SkinnedSketch made = make(lines);
      const MeshFile mesh = MeshFile::read(shells / "meshes" / (std::string(mesh_file) + ".obj"));
      const Points& vertices = mesh.shells().points;
      const double size = (vertices.colwise().maxCoeff() - vertices.colwise().minCoeff()).norm();
      Triangles ours, plain, faired, again, four, coons, four_fair, coons_again;
      add_surfaces(made, ours, plain);
      add_coons(made, four, coons);
      const int defects = isize(made.model.defects);
      const int added = add_fair_row(lines_file, made, fair, checks);
      checks.at_most(std::string("defects that fairing adds, ") + lines_file, added, 0);
      add_surfaces(made, faired, again);
      add_coons(made, four_fair, coons_again);
      DistanceStatistics near_ours, near_fair, near_plain, near_four, near_four_fair, near_coons;
      if (!ours.empty() && !plain.empty()) {
        ours.ready();
        plain.ready();
        faired.ready();
        const bool any_four = !four.empty();
        if (any_four)
          for (Triangles* t : {&four, &coons, &four_fair}) t->ready();
        constexpr double covered = 0.002;
        for (long i = 0; i < vertices.rows(); ++i) {
          const Vec3 p = vertices.row(i);
          const double a = ours.distance(p), b = plain.distance(p);
          if (a > covered * size || b > covered * size) continue;
          near_ours.add(a);
          near_fair.add(faired.distance(p));
          near_plain.add(b);
          if (!any_four || std::min(four.distance(p), coons.distance(p)) > covered * size) continue;
          near_four.add(four.distance(p));
          near_four_fair.add(four_fair.distance(p));
          near_coons.add(coons.distance(p));
        }
      }
      int skinned = 0, smooth = 0;
      for (const ModelRegion& r : made.model.regions) skinned += r.skinned.has_value();
      for (const ModelJoin& j : made.model.joins) smooth += j.kind == ModelJoin::Kind::Smooth;
      const auto share = [&](double d) { return text("%.1e", d / size); };
      table.add({lines_file, std::to_string(lines.size()),
                 std::to_string(made.network->edges().size()),
                 std::to_string(made.model.regions.size()), std::to_string(skinned),
                 std::to_string(smooth), std::to_string(defects), std::to_string(near_ours.count),
                 share(near_ours.max), share(near_ours.rms()), share(near_fair.max),
                 share(near_fair.rms()), share(near_plain.max), share(near_plain.rms()),
                 std::to_string(near_four.count), share(near_four.rms()),
                 share(near_four_fair.rms()), share(near_coons.rms()), text("%.2f", made.seconds)});
      if (near_ours.count > 0)
        checks.at_most(std::string("rms distance over hole filling's, ") + lines_file,
                       near_ours.rms() / near_plain.rms(), 1);
    }
    table.print();
    fair.print();
  }
  checks.print("sketches");
}
