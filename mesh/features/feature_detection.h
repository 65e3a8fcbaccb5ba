// Form features that a panel shows by itself: its holes with their rims, and what closed creases
// enclose.
#pragma once

#include <string>
#include <vector>

#include "batten/mesh/triangle_mesh.h"
#include "batten/core/eigen.h"

namespace batten {

// Where a hole is, how large, how round and how flat.

/// Place, size and shape of a hole. Lengths are in the unit of the points.
struct HoleMeasure {
  Vec3 centre;       ///< centre of the circle
  Vec3 axis;         ///< unit normal of the plane, on the side of the mesh's normals
  double radius;     ///< radius of the circle
  double roundness;  ///< largest | |x_i - centre| - radius | in the plane
  double flatness;   ///< largest distance of a vertex from the plane
  double perimeter;  ///< length of the closed polygon
  /// Radius of the circle of the same area as the polygon in the plane: what a slotted or hexagonal
  /// hole is as large as.
  double equivalent_radius;
  /// Whether it has five vertices or more, roundness up to the given share of the radius, and
  /// encloses half of the circle's area or more. Four vertices never tell: every rectangle has a
  /// circle through its corners; a slender loop lies on a short arc of a large circle.
  bool circular;
};

/// The circle nearest to a closed loop of vertices.
///
/// Plane: through the centroid of the vertices, its normal the right singular vector of the least
/// singular value of the centred points (least sum of squared distances). Circle in this plane:
/// first the algebraic fit, |x|² = 2 m·x + c in the least-squares sense, from it by Gauss-Newton
/// the geometric one, min Σ (|x_i - m| - R)². Both are exact for points on a circle, to rounding.
///
/// The axis points to where the loop runs clockwise: for loops of MeshTopology, which have the
/// surface on their left, that is the side of the mesh's normals. A loop keeps its direction when
/// the mesh deforms, so axes before and after are comparable.
///
/// Loops that are no circles (door openings) have a measure, too: the best circle, whose roundness
/// says how far it is off. Throws InputError for fewer than three vertices, numbers out of range,
/// a coordinate that is not finite. O(loop).
HoleMeasure measure_hole(const Points& points, const std::vector<int>& loop,
                         double circular_tolerance = 0.02);


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
