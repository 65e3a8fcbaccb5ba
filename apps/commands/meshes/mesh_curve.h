// A line of mesh vertices as a deformable curve that drives the mesh.
#pragma once

#include <vector>

#include "batten/apps/commands/meshes/vertex_selector.h"
#include "batten/fairing/fairness.h"

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

}  // namespace batten
