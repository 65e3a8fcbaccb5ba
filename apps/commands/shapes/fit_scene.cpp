#include "batten/apps/commands/shapes/fit_scene.h"

#include <algorithm>
#include <optional>
#include <set>

#include "batten/apps/commands/shapes/run_scene.h"
#include "batten/core/errors.h"
#include "batten/io/files/length_units.h"
#include "batten/io/lines/cad_plugin.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/mesh/features/feature_lines.h"
#include "batten/mesh/prepared_mesh.h"

namespace batten {

namespace {

/// Patches without a border, or around which a line runs twice, are left to the search for regions.
std::optional<RegionSpec> spec_of(const FeaturePatch& patch, const std::vector<SceneLine>& lines) {
  RegionSpec spec;
  std::set<int> used;
  for (const auto& loop : patch.loops) {
    auto& names = spec.loops.emplace_back();
    for (const int l : loop) {
      if (!used.insert(l).second) return {};
      names.push_back(lines[l].name);
    }
  }
  if (spec.loops.empty()) return {};
  for (const int l : patch.inner) spec.inner.push_back(lines[l].name);
  spec.annulus = patch.loops.size() == 2 && !patch.flat && patch.loops[0].size() == 1 &&
                 patch.loops[1].size() == 1;
  return spec;
}

}  // namespace

void add_mesh_lines(Scene& scene, const TriangleMesh& mesh) {
  const FeatureLines found = feature_lines(mesh);
  int creases = 0, rims = 0;
  for (const FeatureLine& feature : found.lines) {
    SceneLine line;
    line.name =
        feature.boundary ? "rim " + std::to_string(++rims) : "crease " + std::to_string(++creases);
    for (const int v : feature.vertices) line.points.push_back(mesh.point(v));
    if (feature.closed) line.points.push_back(line.points.front());
    line.corners.emplace();  // they end where they have corners
    if (!feature.boundary) scene.network.joins.push_back({line.name, JoinSpec::Kind::Crease, ""});
    scene.lines.push_back(std::move(line));
  }
  if (found.lines.empty())
    throw InputError("found no crease and no rim in the mesh, expected --lines with lines to keep");
  for (int p = 0; p < isize(found.patches); ++p)
    if (auto spec = spec_of(found.patches[p], scene.lines)) {
      spec->name = "patch " + std::to_string(p + 1);
      scene.network.regions.push_back(std::move(*spec));
    }
}

namespace {

constexpr double kMeet = 1e-5;  // of the size: exact lines need no repair

/// What each face of a CAD file encloses; a face around which a line runs twice is left to the search.
void add_cad_regions(Scene& scene, const std::filesystem::path& file) {
  const CadFaceTopology found = cad_plugin().read_cad_loops(file, unit_in_metres(scene.unit));
  scene.network.tolerance = std::max(kMeet * found.size, 1.1 * found.gap);
  constexpr double smooth = 0.5;  // degrees: faces that meet by more are no one surface
  for (const CadSharedEdge& join : found.joins)
    if (join.angle_deg > smooth)
      scene.network.joins.push_back({join.line, JoinSpec::Kind::Crease, ""});
  for (const CadFaceBoundary& face : found.faces) {
    RegionSpec spec;
    std::set<std::string> used;
    bool once = !face.loops.empty();
    for (const auto& loop : face.loops)
      for (const std::string& line : loop) once = once && used.insert(line).second;
    if (!once) continue;
    spec.name = face.name;
    spec.loops = face.loops;
    spec.inner = face.inner;
    spec.annulus = face.annulus();
    spec.skin.convex = face.convex;
    scene.network.regions.push_back(std::move(spec));
  }
}

}  // namespace

Scene scene_of_target(const std::filesystem::path& target,
                      const std::vector<std::filesystem::path>& lines, const std::string& unit) {
  const bool mesh = MeshFile::can_read(target);
  Scene scene;
  if (lines.empty() && mesh) {
    scene.unit = unit;
    const TriangleMesh surface = prepare(MeshFile::read(target).shells()).mesh;
    add_mesh_lines(scene, surface);
    scene.network.tolerance = kMeet * surface.size();
  } else {
    scene = scene_of_lines(lines.empty() ? std::vector{target} : lines, {}, unit);
    if (lines.empty()) {
      scene.lines.front().creases = true;
      add_cad_regions(scene, target);
    }
  }
  scene.network.fair_noisy_lines = false;  // the lines are the target's own
  scene.name = target.stem().string();
  scene.step = scene.name + ".step";
  scene.vtp = scene.name + ".vtp";
  scene.targets.push_back({{}, target, "", 0});
  return scene;
}

}  // namespace batten
