// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/runs/target_files.h"

#include <algorithm>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/text.h"
#include "batten/io/lines/cad_plugin.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/mesh/catmull_clark.h"

namespace batten {
void append_target_file(TargetFaces& all, const std::filesystem::path& file,
                        const TargetFileOptions& options) {
  const double unit = unit_in_metres(options.unit);
  if (MeshFile::can_read(file)) {
    const double own = options.own_unit.empty() ? unit : unit_in_metres(options.own_unit);
    const MeshFile mesh = MeshFile::read(file);
    const ShellMesh& shells = mesh.shells();
    all.append(options.cage
                   ? catmull_clark_limit(shells, mesh.cage_tags(), options.chord * unit / own)
                   : shells,
               own / unit);
    return;
  }
  if (!options.own_unit.empty())
    throw InputError("found a 'unit' for a CAD file, expected none: CAD files state their unit");
  if (options.cage) throw InputError("found a CAD file as control cage, expected a mesh");
  CadFacetOptions facet_options;
  facet_options.unit_in_metres = unit;
  facet_options.chord = options.chord;
  facet_options.curved = true;
  facet_options.coarse_primitives = true;
  const CadFacets facets = cad_plugin().tessellate_cad(file, facet_options);
  for (int f = 0; f < isize(facets.primitives); ++f)
    if (facets.primitives[f].kind != FittedPrimitive::Kind::Free || facets.swept[f])
      all.analytic[all.next_part + f] = facets.primitives[f];
  all.deviation = std::max(all.deviation, facets.deviation);
  all.append(facets.mesh, 1, facets.normals, facets.faces);
}

}  // namespace batten
