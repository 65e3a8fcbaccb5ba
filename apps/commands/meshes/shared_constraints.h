// What all edits of a deform scene have in common.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/apps/commands/meshes/attached_nodes.h"
#include "batten/fairing/curve_fit.h"
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

/// What all edits of a scene have in common: features, guides, chains and rows.
struct SharedConstraints {
  std::vector<FormFeature> features;
  const AttachedNodes* attached = nullptr;         ///< its connections are features, too
  std::vector<VertexCombination> centres;          ///< of each feature
  std::vector<std::vector<int>> shared_rotations;  ///< features that turn alike
  std::vector<PointConstraint> point_constraints;
  std::vector<std::optional<Vec3>> through;  // GuideSpec::through of each guide
  std::vector<CharacterChain> chains;
  std::vector<LinearConstraint> rows;
  std::vector<MeshCurve> curves;
  std::vector<std::string> notes;       // what the user should know
  std::vector<std::vector<int>> lines;  // vertices of chains and curves, for pictures; a closed
                                        // line ends with its first vertex
};

}  // namespace batten
