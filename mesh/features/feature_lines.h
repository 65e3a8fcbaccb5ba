// The lines along which a mesh has edges: its creases and its rims.
#pragma once

#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

struct FeatureLineOptions {
  /// An edge is a crease where the normals of its two triangles differ by more than this.
  double crease_degrees = 30;
  /// A line ends where its edges turn by more than this.
  double corner_degrees = 45;
  /// Chains of creases that end in the open and are shorter than this, of the mesh's size, are noise.
  double min_length = 0.02;
};

/// A chain of crease edges, or of edges at the boundary.
struct FeatureLine {
  std::vector<int> vertices;  ///< along it; of a closed one the first is not repeated
  std::vector<int> edges;     ///< of the mesh, along it
  bool closed = false;
  bool boundary = false;  ///< of the boundary
};

/// A part of the mesh that lines enclose.
struct FeaturePatch {
  std::vector<int> triangles;  ///< ascending
  std::vector<std::vector<int>>
      loops;  ///< lines around it, by their numbers, each loop in order; the longest first
  std::vector<int> inner;  ///< lines with this patch on both sides
  bool flat = false;       ///< its triangles lie in one plane
};

struct FeatureLines {
  std::vector<FeatureLine> lines;
  std::vector<FeaturePatch> patches;  ///< by their lowest triangle
};

/// The creases and rims, and what they enclose: creases and rims are cut where more or fewer than two of them meet and at corners, sorted by their lowest vertex. Creases that are rounded off by many small triangles are not seen. O(edges). Throws
/// InputError for angles outside (0, 180).
FeatureLines feature_lines(const TriangleMesh& mesh, const FeatureLineOptions& options = {});

}  // namespace batten
