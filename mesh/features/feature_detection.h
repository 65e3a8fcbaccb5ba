// Detects form features of a panel: holes with their flanges, and regions enclosed by closed
// creases.
#pragma once

#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

// Position, size, roundness and flatness of a hole.

/// Position, size and shape of a hole. Lengths are in the unit of the points.
struct HoleMeasure {
  Vec3 centre = Vec3::Zero();  ///< centre of the fitted circle
  Vec3 axis = Vec3::UnitZ();   ///< unit normal of the fitted plane, on the side of the mesh normals
  double radius = 0;           ///< radius of the fitted circle
  double roundness = 0;        ///< largest | |x_i - centre| - radius | within the plane
  double flatness = 0;         ///< largest distance of a vertex from the plane
  double perimeter = 0;        ///< length of the closed polygon
  /// Radius of the circle with the same area as the polygon in the plane; the size of slotted or
  /// hexagonal holes.
  double equivalent_radius = 0;
  /// True if the loop has at least five vertices, its roundness is at most `circular_tolerance` ×
  /// radius, and it encloses at least half of the area of the circle. Four vertices are never
  /// sufficient, since every rectangle has a circumscribed circle. The area test excludes slender
  /// loops, which lie on a short arc of a large circle.
  bool circular = false;
};

/// Fits a plane and a circle to a closed loop of vertices.
///
/// The plane passes through the centroid of the vertices. Its normal is the right singular vector
/// of the smallest singular value of the centred points (total least squares). The circle in this
/// plane starts from the algebraic fit, |x|² = 2 m·x + c in the least-squares sense. Gauss-Newton
/// iterations then give the geometric fit, min Σ (|x_i - m| - R)². For points on a circle both are
/// exact to rounding.
///
/// Seen from the tip of the axis, the loop runs clockwise. For loops of MeshTopology, which have
/// the surface on their left, this is the side of the mesh normals. A deformation does not change
/// the direction of a loop, so axes before and after are comparable.
///
/// Loops that are not circular (door openings) are measured as well; `roundness` then states the
/// deviation from the best circle. `circular_tolerance`: limit for `circular`, relative to the
/// radius, default 0.02. Throws InputError for fewer than three vertices, indices out of range, or
/// a coordinate that is not finite. O(loop).
HoleMeasure measure_hole(const Points& points, const std::vector<int>& loop,
                         double circular_tolerance = 0.02);

/// Options of detect_features().
struct FeatureDetectionOptions {
  /// An edge is a crease if the normals of its two triangles differ by more than this angle, in
  /// degrees; between 0 and 180.
  double crease_degrees = 20;
  /// Largest number of vertex rings around a hole in which its enclosing crease is searched.
  int flange_rings = 8;
  /// Width of the flange around a hole without an enclosing crease, as geodesic distance. 0: one
  /// ring of triangles.
  double flange_width = 0;
  /// True: every boundary loop is a hole. False: the longest loop of each patch is its outline.
  bool outer_loops = false;
  /// Regions with fewer triangles are noise; a single vertex that sticks out has about six.
  int min_triangles = 10;
  /// True: creases inside other creases are detected too, such as the floor of a pocket inside its
  /// upper edge.
  bool nested = false;
};

/// A detected form feature.
struct DetectedFeature {
  enum class Kind { Hole, Crease };
  Kind kind;
  std::string name;           ///< "hole-1", "crease-1"
  std::vector<int> vertices;  ///< vertices of the feature, which keeps its shape, ascending
  /// Boundary of the hole (the surface is on its left), or the crease (the panel is on its left).
  std::vector<int> loop;
  HoleMeasure measure;  ///< position, size and shape of the loop
  /// holes: the flange extends to a closed crease; creases: always true.
  bool flange_ends_at_crease;
};

/// Detects the form features of a panel. Holes come first, then creases; each kind is numbered in
/// the order of the lowest vertices of the loops.
///
/// Creases: the crease edges divide the mesh into patches. The patches at the longest boundary loop
/// form the panel; the others are grouped into connected regions. A region surrounded by the panel
/// along one closed chain of edges is a feature: its outermost crease and everything inside, holes
/// included. A region with more than half of the area is not a feature but panel inside a flange;
/// its largest patch is added to the panel. Creases that are not closed enclose nothing and give no
/// feature. Neither do strips between two parts of the panel, such as the web of a flange.
///
/// Holes: every boundary loop except the longest of each manifold patch, together with the flange
/// around it. The flange is the first of these that exists within `flange_rings` rings:
/// - Everything up to the outermost closed crease, if that encloses no other hole. This crease is
///   not reported a second time.
/// - Everything up to the first closed crease: all triangles that are reachable from the loop
///   without crossing a crease, if they reach no other boundary.
/// - One ring of triangles, or all vertices within `flange_width`.
///
/// Creases rounded off by many small elements (no edge above `crease_degrees`) are not detected;
/// use cut_feature() for those.
///
/// Throws InputError if the crease angle is outside (0, 180). O(n log n).
std::vector<DetectedFeature> detect_features(const TriangleMesh& mesh,
                                             const FeatureDetectionOptions& options = {});

}  // namespace batten
