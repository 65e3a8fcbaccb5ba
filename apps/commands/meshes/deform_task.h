// From the words of a deform scene to the problem that is solved.
#pragma once

#include <optional>
#include <vector>

#include "batten/apps/commands/meshes/mesh_curve.h"
#include "batten/apps/commands/meshes/vertex_selector.h"
#include "batten/mesh/deform/deform_problem.h"

namespace batten {

/// What all edits keep: vertices of features, guides, chains, rows.
struct Kept {
  std::vector<FormFeature> features;
  std::vector<GuidedPoint> guided;
  std::vector<std::optional<Vec3>> through;  // of each guide
  std::vector<CharacterChain> chains;
  std::vector<CombinationRow> rows;
  std::vector<MeshCurve> curves;
  std::vector<std::vector<int>> lines;  // of both, for pictures; a closed one ends as it begins
};

/// Throws InputError with the place of what cannot be found.
Kept gather(const DeformScene& scene, VertexSelector& select, const TriangleMesh& mesh);

/// The problem of one edit and how it moves.
struct Task {
  DeformProblem problem;
  DeformEdit edit;
};

/// `mesh`: as the edit before left it. Throws InputError.
Task task_of(const DeformScene& scene, const EditRule& rule, const Kept& kept,
             VertexSelector& select, const TriangleMesh& mesh);

}  // namespace batten
