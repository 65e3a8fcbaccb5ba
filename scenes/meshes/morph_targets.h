// SPDX-License-Identifier: MPL-2.0
// Surfaces that the mesh of a deform scene follows.
#pragma once

#include "batten/io/scene/deform_scene.h"
#include "batten/scenes/meshes/edit_session.h"
#include "batten/scenes/meshes/vertex_selector.h"

namespace batten {

/// Reads the surfaces of [[target]]: CAD files, meshes, and scenes (.toml), whose surface is solved.
/// Throws InputError, with the location, for unknown names and files that cannot be read, and the
/// exceptions of load() (scenes/model.h).
void gather_targets(const DeformScene& scene, VertexSelector& select, const TriangleMesh& mesh,
                    SharedConstraints& shared);

}  // namespace batten
