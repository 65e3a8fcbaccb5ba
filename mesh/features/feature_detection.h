// Form features that a panel shows by itself: its holes with their rims, and what closed creases
// enclose.
#pragma once

#include <string>
#include <vector>

#include "batten/mesh/features/hole_measure.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

struct FeatureDetectionOptions {
  /// An edge is a crease where the normals of its two triangles differ by more than this.
  double crease_degrees = 20;
  /// The crease around a hole is looked for up to so many rings of vertices from its loop.
  int flange_rings = 8;
  /// Width of a rim without a crease, along the surface; 0: one ring of triangles.
  double flange_width = 0;
  /// Every boundary loop is a hole, not all but the longest of each part of the mesh.
  bool outer_loops = false;
  /// Patches of fewer triangles are noise: a single vertex that sticks out has six or so.
  int min_triangles = 10;
  /// Creases inside of creases are proposed too (the floor of a cavity inside its upper edge).
  bool nested = false;
};

struct DetectedFeature {
  enum class Kind { Hole, Crease };
  Kind kind;
  std::string name;            ///< "hole-1", "crease-1"
  std::vector<int> vertices;   ///< ascending: the feature, to be kept as it is
  std::vector<int> loop;       ///< the hole's edge, or the crease; the panel on its left
  HoleMeasure measure;         ///< place, size and shape of the loop
  bool flange_ends_at_crease;  ///< holes: the rim goes up to a closed crease; creases: true
};

/// Holes first, then creases, each kind numbered by the lowest vertex of its loop.
///
/// Creases: the mesh falls into patches at its crease edges. The panel is the patches at the
/// longest boundary loop; what is left falls into groups of patches, and a group that the panel
/// surrounds along one closed chain of edges is a feature: its outermost crease with everything
/// inside, holes, too. A group with more than half of the area is no feature but panel within a
/// flange: its largest patch is added to the panel. Creases that do not close enclose nothing and
/// propose nothing, nor do strips between two parts of the panel (the wall of a flange).
///
/// Holes: all boundary loops but the longest of each sheet, each with its rim, the
/// flange around it. The rim is, the first that there is within `flange_rings` rings:
/// - everything up to the outermost closed crease, when that holds no other hole; this crease is
///   not proposed a second time;
/// - everything up to the first closed crease: all triangles that can be reached from the loop
///   without crossing a crease, when they reach no other boundary;
/// - one ring of triangles, or all vertices up to `flange_width`.
///
/// Creases that are rounded off by many small elements (no edge above `crease_degrees`) are not
/// seen: that is what cut_feature is for.
///
/// Throws InputError on a crease angle outside (0, 180). O(n log n).
std::vector<DetectedFeature> detect_features(const TriangleMesh& mesh,
                                             const FeatureDetectionOptions& options = {});

}  // namespace batten
