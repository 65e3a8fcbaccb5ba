// Networks that people drew: what becomes of the twelve connected sketches of the CASSIE study, and
// how near the surfaces over five computed networks are to the meshes that these were cut from,
// beside plain hole filling of the same loops. Needs those files; says so where they are absent.
#include <vtkCellArray.h>
#include <vtkCellLocator.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "batten/io/mesh_file.h"
#include "batten/io/point_lines.h"
#include "batten/io/sketch_graph.h"
#include "batten/skinning/facets.h"
#include "batten/skinning/network/model.h"
#include "batten/skinning/plain_fill.h"
#include "batten/tests/reference.h"
#include "bench.h"

namespace {

using namespace batten;
using namespace batten::bench;
namespace fs = std::filesystem;

double clock_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct Made {
  std::unique_ptr<CharacterLineNetwork> network;
  FoundRegions found;
  SurfaceModel model;
  double seconds = 0;
};

Made make(const std::vector<CharacterLine>& lines) {
  Made made;
  const double start = clock_seconds();
  made.network = std::make_unique<CharacterLineNetwork>(lines);
  made.found = find_regions(*made.network);
  made.model = skin_network(*made.network, made.found);
  made.seconds = clock_seconds() - start;
  return made;
}

// Regions as sets of the file's segments: a segment belongs to the arc that its middle lies on.
std::set<std::set<int>> by_segments(const fs::path& file, const Made& made) {
  const auto json = nlohmann::json::parse(std::ifstream(file));
  std::map<int, std::set<int>> segments;  // of each arc
  for (const auto& s : json["segments"]) {
    const auto& piece = s["ctrl_pts"][s["ctrl_pts"].size() / 2];
    Vec3 middle = Vec3::Zero();
    const double weight4[] = {0.125, 0.375, 0.375, 0.125}, weight2[] = {0.5, 0.5};
    for (size_t i = 0; i < piece.size(); ++i)
      middle +=
          (piece.size() == 4 ? weight4 : weight2)[i] * Vec3(piece[i][0], piece[i][1], piece[i][2]);
    double nearest = 0.02 * made.network->size();
    int arc = -1;
    for (size_t a = 0; a < made.network->arcs().size(); ++a) {
      const double d = made.network->arcs()[a].curve.closest_point(middle).distance;
      if (d < nearest) {
        nearest = d;
        arc = static_cast<int>(a);
      }
    }
    if (arc >= 0) segments[arc].insert(s["id"].get<int>());
  }
  std::set<std::set<int>> regions;
  for (const NetworkRegion& region : made.found.regions) {
    std::set<int> all;
    for (const ArcLoop& loop : region.loops)
      for (const ArcUse& use : loop) all.insert(segments[use.arc].begin(), segments[use.arc].end());
    regions.insert(all);
  }
  return regions;
}

struct Score {
  int found = 0, right = 0, expected = 0, hit = 0;
};
Score score(const fs::path& expected_file, const std::set<std::set<int>>& found) {
  const auto json = nlohmann::json::parse(std::ifstream(expected_file));
  const auto sets = [&](const char* key) {
    std::set<std::set<int>> all;
    for (const auto& r : json[key])
      if (r.contains("segments")) all.insert(r["segments"].get<std::set<int>>());
    return all;
  };
  const auto expected = sets("regions"), doubtful = sets("doubtful");
  Score s;
  s.expected = static_cast<int>(expected.size());
  for (const auto& r : found) {
    if (doubtful.count(r)) continue;
    ++s.found;
    s.right += static_cast<int>(expected.count(r));
  }
  s.hit = s.right;
  return s;
}

// Distances to a stored mesh.
class StoredMesh {
 public:
  explicit StoredMesh(const fs::path& file) {
    const MeshFile read = MeshFile::read(file);
    const ShellMesh& mesh = read.shells();
    vtkNew<vtkPoints> points;
    for (long i = 0; i < mesh.points.rows(); ++i)
      points->InsertNextPoint(mesh.points(i, 0), mesh.points(i, 1), mesh.points(i, 2));
    vtkNew<vtkCellArray> cells;
    for (int f = 0; f < mesh.face_count(); ++f) {
      cells->InsertNextCell(static_cast<vtkIdType>(mesh.corners(f).size()));
      for (const int v : mesh.corners(f)) cells->InsertCellPoint(v);
    }
    data_->SetPoints(points);
    data_->SetPolys(cells);
    locator_->SetDataSet(data_);
    locator_->BuildLocator();
    size_ = data_->GetLength();
  }
  double size() const { return size_; }
  double distance(const Vec3& p) {
    double nearest[3], squared = 0;
    vtkIdType cell = 0;
    int sub = 0;
    locator_->FindClosestPoint(p.data(), nearest, cell, sub, squared);
    return std::sqrt(squared);
  }

 private:
  vtkNew<vtkPolyData> data_;
  vtkNew<vtkCellLocator> locator_;
  double size_ = 1;
};

struct Far {
  double max = 0, sum = 0, area = 0;
  void add(double distance, double weight) {
    max = std::max(max, distance);
    sum += weight * distance * distance;
    area += weight;
  }
  double rms() const { return area > 0 ? std::sqrt(sum / area) : 0; }
};

// Sampled at the middles of 16 parts of each triangle, by area.
void add_triangle(const Vec3& a, const Vec3& b, const Vec3& c, StoredMesh& mesh, Far& far) {
  const double area = 0.5 * (b - a).cross(c - a).norm();
  constexpr int n = 4;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n - i; ++j)
      for (int up = 0; up < (i + j < n - 1 ? 2 : 1); ++up) {
        const double s = (i + (up ? 2 : 1) / 3.0) / n, t = (j + (up ? 2 : 1) / 3.0) / n;
        far.add(mesh.distance(a + s * (b - a) + t * (c - a)), area / (n * n));
      }
}

std::string short_list(const std::vector<std::string>& items) {
  std::string all;
  for (const auto& item : items) all += (all.empty() ? "" : "; ") + item;
  return all;
}

}  // namespace

int main() {
  Promises promises;
  const auto sketches = batten_test::optional_data("sketch-cassie/sketch_graph");
  if (sketches.empty()) {
    std::printf("The sketches are not on this machine: nothing to do.\n");
  } else {
    Table table;
    table.add({"sketch", "lines", "repaired", "listed", "arcs", "regions", "skinned", "smooth",
               "open", "creases", "rims", "bare", "choices", "flaws", "min J", "join deg", "s"});
    std::vector<std::string> notes;
    int unnamed = 0;
    for (const char* name :
         {"computer-mouse", "hat", "shield", "teapot", "vacuum", "guitar", "vintage_car",
          "hmd_modern", "architecture", "02-1-2", "02-2-2", "03-1-1"}) {
      const fs::path file = sketches / (std::string(name) + ".json");
      const Made made = make(read_sketch_graph(file));
      int repaired = 0, listed = 0, skinned = 0, smooth = 0, open = 0, creases = 0;
      for (const NetworkFinding& f : made.network->findings()) ++(f.repaired ? repaired : listed);
      double jacobian = 1, join = 0;
      for (const ModelRegion& r : made.model.regions) {
        if (!r.skinned) {
          notes.push_back(std::string(name) + ", " + r.plan.name + " not skinned: " + r.why_not);
          continue;
        }
        ++skinned;
        jacobian = std::min(jacobian, r.quality.min_jacobian_ratio);
        const bool wrong = !(r.quality.min_jacobian_ratio > 0);
        const auto index = static_cast<int>(&r - made.model.regions.data());
        const bool said = std::any_of(
            made.model.flaws.begin(), made.model.flaws.end(), [&](const SurfaceFlaw& f) {
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
      for (const SurfaceFlaw& f : made.model.flaws)
        notes.push_back(std::string(name) + ": " + f.text);
      table.add({name, std::to_string(made.network->lines().size()), std::to_string(repaired),
                 std::to_string(listed), std::to_string(made.network->arcs().size()),
                 std::to_string(made.model.regions.size()), std::to_string(skinned),
                 std::to_string(smooth), std::to_string(open), std::to_string(creases),
                 std::to_string(made.found.rims.size()), std::to_string(made.found.bare.size()),
                 std::to_string(made.found.choices.size()), std::to_string(made.model.flaws.size()),
                 text("%.2f", jacobian), text("%.2g", join), text("%.2f", made.seconds)});
      const fs::path expected =
          fs::path(BATTEN_SOURCE_DIR) / "tests/reference/networks" / (std::string(name) + ".json");
      if (!fs::exists(expected)) continue;
      const Score s = score(expected, by_segments(file, made));
      promises.at_least(std::string("precision, ") + name, static_cast<double>(s.right) / s.found,
                        0.9);
      promises.at_least(std::string("recall, ") + name, static_cast<double>(s.hit) / s.expected,
                        0.8);
    }
    table.print();
    for (const std::string& note : notes) std::printf("%s\n", note.c_str());
    std::printf("\n");
    promises.at_most("surfaces that turn over and are not named", unnamed, 0);
  }

  const auto shells = batten_test::optional_data("curvenet-shells");
  if (!shells.empty()) {
    Table table;
    table.add({"network", "lines", "arcs", "regions", "skinned", "smooth", "flaws", "max", "rms",
               "plain: max", "plain: rms", "s"});
    for (const auto& [lines_file, mesh_file] : {std::pair("hill_3", "hill"),
                                                {"shell_3", "shell"},
                                                {"tent_3_regular_curves", "tent"},
                                                {"roof_75", "roof"},
                                                {"shell_100", "shell"}}) {
      std::vector<CharacterLine> lines;
      for (const auto& line :
           read_point_lines(shells / "curves" / (std::string(lines_file) + ".txt")))
        lines.push_back({line.name, curve_through_points(line.name, line.points)});
      const Made made = make(lines);
      StoredMesh mesh(shells / "meshes" / (std::string(mesh_file) + ".obj"));
      Far ours, plain;
      int skinned = 0, smooth = 0;
      for (const ModelRegion& r : made.model.regions) {
        if (!r.skinned) continue;
        ++skinned;
        const DisplayFacets f = facets(*r.skinned, 2);
        std::vector<Vec3> x;
        for (const Location& p : f.tessellation.points) x.push_back(r.skinned->surface.position(p));
        for (const auto& t : f.tessellation.facets) {
          const Vec3 &a = x[t[0]], &b = x[t[1]], &c = x[t[2]];
          ours.add(mesh.distance((a + b + c) / 3), 0.5 * (b - a).cross(c - a).norm());
        }
        std::vector<Vec3> loop;
        for (const ArcUse& use : r.plan.loops[0]) {
          const HermiteCurve& curve = made.network->arcs()[use.arc].curve;
          constexpr int per_arc = 16;
          for (int i = 0; i < per_arc; ++i) {
            const double s = static_cast<double>(i) / per_arc;
            loop.push_back(curve.evaluate(curve.end() * (use.reversed ? 1 - s : s)));
          }
        }
        if (const auto fill = plain_fill(loop))
          for (const auto& t : fill->triangles)
            add_triangle(loop[t[0]], loop[t[1]], loop[t[2]], mesh, plain);
      }
      for (const ModelJoin& j : made.model.joins) smooth += j.kind == ModelJoin::Kind::Smooth;
      const auto share = [&](double d) { return text("%.1e", d / mesh.size()); };
      table.add(
          {lines_file, std::to_string(lines.size()), std::to_string(made.network->arcs().size()),
           std::to_string(made.model.regions.size()), std::to_string(skinned),
           std::to_string(smooth), std::to_string(made.model.flaws.size()), share(ours.max),
           share(ours.rms()), share(plain.max), share(plain.rms()), text("%.2f", made.seconds)});
      if (skinned > 0)
        promises.at_most(
            std::string("rms distance from the stored surface over plain filling's, ") + lines_file,
            ours.rms() / plain.rms(), 1);
    }
    table.print();
  }
  promises.print("sketches");
}
