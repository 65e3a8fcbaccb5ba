// SPDX-License-Identifier: MPL-2.0
// The curves and faces of a scene whose surface is fitted to a mesh.
#pragma once

#include <vector>

#include "batten/io/meshes/mesh_file_types.h"
#include "batten/io/scene/scene.h"
#include "batten/mesh/prepared_mesh.h"

namespace batten {

/// Gap tolerance of lines that meet exactly, relative to the size of the model: they need no repair.
constexpr double kExactLineTolerance = 1e-5;

/// Adds the feature lines of a mesh to a network scene, and the faces that they enclose. Sets the gap
/// tolerance, because these lines meet exactly.
///
/// Feature lines are the creases and free edges of the mesh, and the node sets that are chains of
/// edges; the latter join their faces smoothly where they are no creases. A line has the name of the
/// smallest node set that contains it, if that set is at most four times as large, otherwise
/// "crease 1", "free edge 1", …; further lines of a set are numbered "NAME 2", …. Likewise, a face
/// has the name of the smallest face set that contains it, otherwise "patch 1", …. `sets`: sets of
/// nodes and faces of the mesh from which `mesh` was made. Throws InputError if there are no feature
/// lines.
void add_mesh_lines(Scene& scene, const PreparedMesh& mesh, const std::vector<MeshSet>& sets = {});

}  // namespace batten
