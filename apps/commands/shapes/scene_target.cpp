#include "batten/apps/commands/shapes/scene_target.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/io/files/length_units.h"
#include "batten/io/lines/cad_calls.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/mesh/catmull_clark.h"
#include "batten/mesh/curved_mesh.h"
#include "batten/mesh/prepare.h"

namespace batten {
namespace {

class MeshTarget : public TargetSurface {
 public:
  explicit MeshTarget(CurvedMesh mesh) : mesh_(std::move(mesh)) {}

  std::optional<Nearest> nearest(const Vec3& p, const Vec3& along) const override {
    const auto found =
        mesh_.nearest(p, along.isZero(0) ? std::optional<Vec3>() : std::optional<Vec3>(along));
    if (!found) return {};
    return Nearest{found->at, found->normal, found->at_rim};
  }

  std::vector<Nearest> samples() const override {
    constexpr double spacing = 0.01;  // of the size
    constexpr int most = 64;
    const TriangleMesh& flat = mesh_.mesh();
    const double step = spacing * flat.size();
    std::vector<Nearest> points;
    for (int t = 0; t < flat.triangle_count(); ++t) {
      const auto& [a, b, c] = flat.triangles()[t];
      const Vec3 u = flat.point(b) - flat.point(a), v = flat.point(c) - flat.point(a);
      const double longest = std::max({u.norm(), v.norm(), (v - u).norm()});
      const Vec3 normal = u.cross(v).normalized();
      const CurvedTriangle triangle = mesh_.triangle(t);
      const int n = std::clamp(static_cast<int>(std::ceil(longest / step)), 1, most);
      for (int i = 0; i < n; ++i)
        for (int j = 0; i + j < n; ++j) {
          const double s = (i + 1.0 / 3) / n, r = (j + 1.0 / 3) / n;
          points.push_back({triangle.at({1 - s - r, s, r}), normal, false});
        }
    }
    return points;
  }

 private:
  CurvedMesh mesh_;
};

/// Faces of all targets; of those that bulge the normals at their corners.
struct TargetFaces {
  ShellMesh shells;
  std::vector<std::optional<CurvedTriangle::Corners>> normals;
};

/// A triangle of a CAD face whose corners lie on a line: nothing is nearest to its inside.
bool is_needle(const ShellMesh& mesh, int f) {
  constexpr double least_height = 1e-9;  // of the longest edge
  const auto corners = mesh.face(f);
  const Vec3 a = mesh.points.row(corners[0]), u = mesh.points.row(corners[1]).transpose() - a,
             v = mesh.points.row(corners[2]).transpose() - a;
  const double longest = std::max({u.squaredNorm(), v.squaredNorm(), (v - u).squaredNorm()});
  return u.cross(v).norm() <= least_height * longest;
}

void append(TargetFaces& faces, const ShellMesh& more, double scale,
            const std::vector<CurvedTriangle::Corners>& normals = {}) {
  ShellMesh& all = faces.shells;
  const int first = all.node_count();
  Points points(first + more.node_count(), 3);
  points << all.points, scale * more.points;
  all.points = std::move(points);
  for (int f = 0; f < more.face_count(); ++f) {
    if (!normals.empty() && is_needle(more, f)) continue;
    std::vector<int> nodes(more.face(f).begin(), more.face(f).end());
    for (int& node : nodes) node += first;
    all.add_face(nodes, more.second_order(f));
    faces.normals.emplace_back();
    if (!normals.empty()) faces.normals.back() = normals[f];
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

/// The normals of curved faces at the corners of the triangles that they became.
CurvedMesh curved_mesh(const TargetFaces& faces) {
  const PreparedMesh prepared = prepare(faces.shells);
  if (std::none_of(faces.normals.begin(), faces.normals.end(), [](const auto& n) { return !!n; }))
    return CurvedMesh(prepared.mesh);
  std::vector<CurvedTriangle::Corners> normals;
  for (int t = 0; t < prepared.mesh.triangle_count(); ++t) {
    const Vec3 flat = prepared.mesh.area_vector(t).normalized();
    const int f = prepared.face_of_triangle[t];
    CurvedTriangle::Corners& corners =
        normals.emplace_back(CurvedTriangle::Corners{flat, flat, flat});
    if (!faces.normals[f]) continue;
    for (size_t c = 0; c < 3; ++c) {
      const int node = prepared.mesh.topology().node_of(prepared.mesh.triangles()[t][c]);
      for (size_t k = 0; k < 3; ++k) {
        if (faces.shells.face(f)[k] != node) continue;
        const Vec3& n = (*faces.normals[f])[k];
        corners[c] = n.dot(flat) < 0 ? Vec3(-n) : n;
      }
    }
  }
  return CurvedMesh(prepared.mesh, std::move(normals));
}

void append_target(TargetFaces& all, const Scene& scene, const SceneTarget& target, double chord) {
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
  options.curved = true;
  const CadFacets facets = cad_calls().facets_of_cad(target.file, options);
  append(all, facets.mesh, 1, facets.normals);
}

}  // namespace

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
  TargetFaces all;
  all.shells.points.resize(0, 3);
  for (const SceneTarget& target : scene.targets) {
    progress.at("read the target", 0);
    try {
      append_target(all, scene, target, chord);
    } catch (const InputError& e) {
      throw InputError(scene.at(target.place) + e.what());
    }
  }
  try {
    return std::make_shared<MeshTarget>(curved_mesh(all));
  } catch (const InputError& e) {
    throw InputError(scene.at(scene.targets.front().place) + e.what());
  }
}

}  // namespace batten
