// From the words of a deform scene to the problem that is solved.
#pragma once

#include <optional>
#include <vector>

#include "batten/apps/commands/meshes/vertex_selector.h"
#include "batten/fairing/fairness.h"
#include "batten/mesh/deform/deform_problem.h"

namespace batten {

/// The vertices, the curve that was fitted to them, faired and shaped by its loads, and where on it
/// each vertex goes.
struct MeshCurve {
  std::string name;
  std::vector<int> vertices;
  HermiteCurve curve;
  std::vector<Vec3> targets;
  Deviation fairing;         ///< of the vertices from the faired curve, before its loads
  double wavelength = 0;     ///< of the fairing
  Fairness before, after;    ///< of the line as it is, and of the curve
  double largest_shift = 0;  ///< that the loads add
};

/// Throws InputError with the place in the scene.
MeshCurve shape_curve(const DeformScene& scene, const CurveRule& rule, VertexSelector& select,
                      const TriangleMesh& mesh);

/// Largest distance of the vertices from the curve, at positions p.
double distance_from(const MeshCurve& curve, const Points& p);

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
