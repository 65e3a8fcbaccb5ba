// Makes the problem that is solved from the words of a deform scene.
#pragma once

#include <optional>
#include <vector>

#include "batten/apps/commands/meshes/attached_nodes.h"
#include "batten/apps/commands/meshes/vertex_selector.h"
#include "batten/fairing/fairness.h"
#include "batten/mesh/deform/deform_problem.h"

namespace batten {

/// A line of vertices and its curve, which drives the mesh. Lengths are in model units.
struct MeshCurve {
  std::string name;
  std::vector<int> vertices;
  HermiteCurve curve;         ///< the curve, faired and shaped by its loads
  std::vector<Vec3> targets;  ///< the place on the curve where each vertex goes
  Deviation fairing;          ///< deviation of the vertices from the faired curve, without loads
  double wavelength = 0;      ///< wavelength of the fairing
  Fairness before, after;     ///< fairness of the line as it is, and of the curve
  double largest_shift = 0;   ///< largest displacement of a vertex by the loads
};

/// Fairs and loads the curve of a [[curve]]. Throws InputError with the place in the scene.
MeshCurve shape_curve(const DeformScene& scene, const CurveRule& rule, VertexSelector& select,
                      const TriangleMesh& mesh);

/// The largest distance of the vertices, at positions p (n×3), from the curve.
double distance_from(const MeshCurve& curve, const Points& p);

/// What all edits of a scene have in common: features, guides, chains and rows.
struct Kept {
  std::vector<FormFeature> features;
  const AttachedNodes* attached = nullptr;   ///< its connections are features, too
  std::vector<VertexCombination> centres;    ///< of each feature
  std::vector<std::vector<int>> same_turns;  ///< features that turn alike
  std::vector<GuidedPoint> guided;
  std::vector<std::optional<Vec3>> through;  // GuideRule::through of each guide
  std::vector<CharacterChain> chains;
  std::vector<CombinationRow> rows;
  std::vector<MeshCurve> curves;
  std::vector<std::vector<int>> lines;  // vertices of chains and curves, for pictures; a closed
                                        // line ends with its first vertex
};

/// Collects what all edits have in common. Throws InputError with the place of what cannot be
/// found.
Kept gather(const DeformScene& scene, VertexSelector& select, const AttachedNodes& attached,
            const TriangleMesh& mesh);

/// The problem of one edit and how it moves.
struct Task {
  DeformProblem problem;
  DeformEdit edit;
};

/// The task with the centres of all features where they are at `unscaled`, positions without any
/// scale of a feature: scaling one then moves no other.
Task with_kept_centres(Task task, const Kept& kept, const Points& unscaled);

/// Makes the task of one edit. `mesh` is the result of the edit before. Throws InputError with the
/// place of a name that cannot be found.
Task task_of(const DeformScene& scene, const EditRule& rule, const Kept& kept,
             VertexSelector& select, const TriangleMesh& mesh);

}  // namespace batten
