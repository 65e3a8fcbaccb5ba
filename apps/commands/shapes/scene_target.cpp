#include "batten/apps/commands/shapes/scene_target.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/io/files/length_units.h"
#include "batten/io/lines/cad_plugin.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/mesh/catmull_clark.h"

namespace batten {
namespace {

/// As many rounds as make the chords of the limit's quads short enough, or as 200,000 quads allow.
ShellMesh limit_of(const MeshFile& file, double chord) {
  constexpr int max_rounds = 8;
  constexpr double most = 2e5;
  const ShellMesh& cage = file.shells();
  const CageTags& tags = file.cage_tags();
  ShellMesh fine = catmull_clark(cage, {1, tags});
  for (int rounds = 2; rounds <= max_rounds && 4.0 * fine.face_count() <= most; ++rounds) {
    ShellMesh next = catmull_clark(cage, {rounds, tags});
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

void append_target(TargetFaces& all, const Scene& scene, const SceneTarget& target, double chord) {
  const double unit = unit_in_metres(scene.unit);
  if (MeshFile::can_read(target.file)) {
    const double own = target.unit.empty() ? unit : unit_in_metres(target.unit);
    const MeshFile mesh = MeshFile::read(target.file);
    const ShellMesh& shells = mesh.shells();
    all.append(target.cage ? limit_of(mesh, chord * unit / own) : shells, own / unit);
    return;
  }
  if (!target.unit.empty())
    throw InputError("'unit' of a CAD file, expected none: the file states it");
  if (target.cage) throw InputError("a CAD file as a cage, expected a mesh of polygons");
  CadFacetOptions options;
  options.unit_in_metres = unit;
  options.chord = chord;
  options.curved = true;
  const CadFacets facets = cad_plugin().tessellate_cad(target.file, options);
  all.append(facets.mesh, 1, facets.normals, facets.faces);
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

TargetParts target_of(const Scene& scene, double size, const Progress& progress) {
  constexpr double fraction = 0.25;  // of the tolerance
  const double chord = fraction * target_tolerance(scene, size);
  TargetFaces all;
  for (const SceneTarget& target : scene.targets) {
    progress.update("read the target", 0);
    try {
      append_target(all, scene, target, chord);
    } catch (const InputError& e) {
      throw InputError(scene.at(target.location) + e.what());
    }
  }
  try {
    return target_parts(all);
  } catch (const InputError& e) {
    throw InputError(scene.at(scene.targets.front().location) + e.what());
  }
}

}  // namespace batten
