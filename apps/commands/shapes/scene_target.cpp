#include "batten/apps/commands/shapes/scene_target.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/io/files/length_units.h"
#include "batten/io/lines/cad_calls.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/mesh/catmull_clark.h"
#include "batten/mesh/prepare.h"
#include "batten/mesh/surface_search.h"

namespace batten {
namespace {

class MeshTarget : public TargetSurface {
 public:
  explicit MeshTarget(TriangleMesh mesh) : mesh_(std::move(mesh)), search_(mesh_) {}

  std::optional<Nearest> nearest(const Vec3& p, const Vec3& along) const override {
    const auto found =
        search_.nearest(p, along.isZero(0) ? std::optional<Vec3>() : std::optional<Vec3>(along));
    if (!found) return {};
    return Nearest{found->at, mesh_.area_vector(found->triangle).normalized(),
                   is_at_rim(found->triangle, found->weights)};
  }

  std::vector<Nearest> samples() const override {
    constexpr double spacing = 0.01;  // of the size
    constexpr int most = 64;
    const double step = spacing * mesh_.size();
    std::vector<Nearest> points;
    for (const auto& [a, b, c] : mesh_.triangles()) {
      const Vec3 p = mesh_.point(a), u = mesh_.point(b) - p, v = mesh_.point(c) - p;
      const double longest = std::max({u.norm(), v.norm(), (v - u).norm()});
      const Vec3 normal = u.cross(v).normalized();
      const int n = std::clamp(static_cast<int>(std::ceil(longest / step)), 1, most);
      for (int i = 0; i < n; ++i)
        for (int j = 0; i + j < n; ++j)
          points.push_back({p + ((i + 1.0 / 3) * u + (j + 1.0 / 3) * v) / n, normal, false});
    }
    return points;
  }

 private:
  bool is_at_rim(int triangle, const Vec3& weights) const {
    constexpr double hair = 1e-9;
    const MeshTopology& topology = mesh_.topology();
    for (int corner = 0; corner < 3; ++corner)
      if (weights[corner] < hair) {
        const auto& edge = topology.edges()[topology.edges_of(triangle)[corner]];
        if (edge.left < 0 || edge.right < 0) return true;
      }
    return false;
  }

  TriangleMesh mesh_;
  SurfaceSearch search_;
};

void append(ShellMesh& all, const ShellMesh& more, double scale) {
  const int first = all.node_count();
  Points points(first + more.node_count(), 3);
  points << all.points, scale * more.points;
  all.points = std::move(points);
  for (int f = 0; f < more.face_count(); ++f) {
    std::vector<int> nodes(more.face(f).begin(), more.face(f).end());
    for (int& node : nodes) node += first;
    all.add_face(nodes, more.second_order(f));
  }
}

/// As many rounds as make the chords of the limit's quads short enough, or as 200,000 quads allow.
ShellMesh limit_of(const ShellMesh& cage, double chord) {
  constexpr int most_rounds = 8;
  constexpr double most = 2e5;
  ShellMesh fine = catmull_clark(cage, {1});
  for (int rounds = 2; rounds <= most_rounds && 4.0 * fine.face_count() <= most; ++rounds) {
    ShellMesh next = catmull_clark(cage, {rounds});
    // The middles of the faces were made one after the other, behind the nodes that were there.
    double off = 0;
    for (int f = 0; f < fine.face_count(); ++f) {
      Vec3 middle = Vec3::Zero();
      for (const int v : fine.corners(f)) middle += fine.points.row(v).transpose() / 4;
      off = std::max(off, (middle - next.points.row(fine.node_count() + f).transpose()).norm());
    }
    fine = std::move(next);
    if (off < 4 * chord) break;  // a quarter of it is left
  }
  return fine;
}

void append_target(ShellMesh& all, const Scene& scene, const SceneTarget& target, double chord) {
  const double unit = unit_in_metres(scene.unit);
  if (MeshFile::reads(target.file)) {
    const double own = target.unit.empty() ? unit : unit_in_metres(target.unit);
    const MeshFile mesh = MeshFile::read(target.file);
    const ShellMesh& shells = mesh.shells();
    append(all, target.cage ? limit_of(shells, chord * unit / own) : shells, own / unit);
    return;
  }
  if (!target.unit.empty())
    throw InputError("'unit' of a CAD file, expected none: the file states it");
  if (target.cage) throw InputError("a CAD file as a cage, expected a mesh of polygons");
  CadFacetOptions options;
  options.unit_in_metres = unit;
  options.chord = chord;
  const CadFacets facets = cad_calls().facets_of_cad(target.file, options);
  append(all, facets.mesh, 1);
}

}  // namespace

std::shared_ptr<const TargetSurface> mesh_target(TriangleMesh mesh) {
  return std::make_shared<MeshTarget>(std::move(mesh));
}

double target_tolerance(const Scene& scene, double size) {
  double least = 0;
  for (const SceneTarget& target : scene.targets) {
    const double own = target.tolerance > 0 ? target.tolerance : 1e-4 * size;
    least = least > 0 ? std::min(least, own) : own;
  }
  return least;
}

std::shared_ptr<const TargetSurface> target_of(const Scene& scene, double size,
                                               const Progress& progress) {
  constexpr double share = 0.25;  // of the tolerance
  const double chord = share * target_tolerance(scene, size);
  ShellMesh all;
  all.points.resize(0, 3);
  for (const SceneTarget& target : scene.targets) {
    progress.at("read the target", 0);
    try {
      append_target(all, scene, target, chord);
    } catch (const InputError& e) {
      throw InputError(scene.at(target.place) + e.what());
    }
  }
  try {
    return mesh_target(prepare(all).mesh);
  } catch (const InputError& e) {
    throw InputError(scene.at(scene.targets.front().place) + e.what());
  }
}

}  // namespace batten
