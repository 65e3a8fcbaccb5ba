// What features of a deform scene keep between them, as rows and shared turns.
#pragma once

#include "batten/apps/commands/meshes/shared_constraints.h"
#include "batten/apps/commands/meshes/vertex_selector.h"

namespace batten {

/// The point that stands for a feature: the mean of its loop where it is a proposed hole, otherwise of
/// its vertices.
VertexCombination centre_of(const FormFeature& feature, VertexSelector& select,
                            const TriangleMesh& mesh);

/// Adds the rows, guides and shared turns of all [[relation]]s to what is kept. Throws InputError with
/// the place: no such feature, too few, features that are not what the relation keeps (axes apart,
/// uneven steps, no mirror images).
void gather_relations(const DeformScene& scene, VertexSelector& select, const TriangleMesh& mesh,
                      SharedConstraints& shared);

}  // namespace batten
