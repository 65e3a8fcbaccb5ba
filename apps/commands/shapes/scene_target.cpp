#include "batten/apps/commands/shapes/scene_target.h"

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/io/files/text.h"
#include "batten/io/lines/cad_plugin.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/mesh/catmull_clark.h"

namespace batten {
namespace {

void append_target(TargetFaces& all, const Scene& scene, const SceneTarget& target, double chord) {
  const double unit = unit_in_metres(scene.unit);
  if (MeshFile::can_read(target.file)) {
    const double own = target.unit.empty() ? unit : unit_in_metres(target.unit);
    const MeshFile mesh = MeshFile::read(target.file);
    const ShellMesh& shells = mesh.shells();
    all.append(
        target.cage ? catmull_clark_limit(shells, mesh.cage_tags(), chord * unit / own) : shells,
        own / unit);
    return;
  }
  if (!target.unit.empty())
    throw InputError("found a 'unit' for a CAD file, expected none: CAD files state their unit");
  if (target.cage) throw InputError("found a CAD file as control cage, expected a mesh");
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
    progress.update("reading the target", 0);
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
