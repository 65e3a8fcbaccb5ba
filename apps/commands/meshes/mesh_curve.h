// Makes a line of mesh vertices into a deformable curve that drives the mesh.
#pragma once

#include <vector>

#include "batten/apps/commands/meshes/vertex_selector.h"
#include "batten/fairing/fairness.h"

namespace batten {

/// A line of vertices and its curve. Lengths are in model units.
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

}  // namespace batten
