// SPDX-License-Identifier: MPL-2.0
// Detection of form features of a panel: holes with their flanges, and regions enclosed by closed
// creases.
#pragma once

#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

// Position, size, roundness and flatness of a hole.

/// Position, size and shape of a hole. Lengths are in the unit of the vertex positions.
struct HoleMeasure {
  Vec3 centre = Vec3::Zero();  ///< centre of the fitted circle
  Vec3 axis = Vec3::UnitZ();   ///< unit normal of the fitted plane, on the side of the mesh normals
  double radius = 0;           ///< radius of the fitted circle
  double roundness = 0;        ///< largest in-plane distance of a vertex from the fitted circle
  double flatness = 0;         ///< largest distance of a vertex from the fitted plane
  double perimeter = 0;        ///< length of the boundary loop of the hole
  /// Radius of the circle with the same area as the boundary loop projected to the plane. It
  /// measures the size of holes that are not circular (slotted or hexagonal, for example).
  double equivalent_radius = 0;
  /// True if the boundary loop has at least five vertices and encloses at least half of the area of
  /// the fitted circle, and `roundness` is at most `circular_tolerance` × radius (see
  /// measure_hole()). Four vertices are never sufficient, since every rectangle has a circumscribed
  /// circle. The area test excludes slender loops, which lie on a short arc of a large circle.
  bool circular = false;
};

/// Fits a plane and a circle to a closed loop of vertices.
///
/// The plane passes through the centroid of the vertices. Its normal is the right singular vector
/// of the smallest singular value of the centred points (total least squares). For the circle in
/// this plane with centre m and radius R, the algebraic fit, |x|² = 2 m·x + c in the least-squares
/// sense, gives initial values. Gauss-Newton iterations then give the geometric fit, which
/// minimises Σ (|x_i - m| - R)². For points x_i on a circle both fits are exact to rounding.
///
/// The loop is clockwise when seen from the tip of HoleMeasure::axis. For boundary loops of
/// MeshTopology, which have the surface on their left, the axis is therefore on the side of the
/// mesh normals. A deformation does not change the direction of a loop, so axes before and after a
/// deformation are comparable.
///
/// `points`: vertex positions (n×3). `loop`: vertices in order, the first one not repeated. Loops
/// need not be circular (door openings, for example). `circular_tolerance`: largest roundness of a
/// circular hole, relative to the radius, default 0.02. Throws InputError if the loop has fewer
/// than three vertices, an index is out of range, or a coordinate is not finite. O(loop).
HoleMeasure measure_hole(const Points& points, const std::vector<int>& loop,
                         double circular_tolerance = 0.02);

/// Options of detect_features().
struct FeatureDetectionOptions {
  /// An edge is a crease if the normals of its two triangles differ by more than this angle, in
  /// degrees; between 0 and 180.
  double crease_degrees = 20;
  /// Largest extent of the flange around a hole, in rings of vertices: the crease that ends the
  /// flange is searched within this number of rings.
  int flange_rings = 8;
  /// Width of the flange around a hole if no crease encloses it: geodesic distance from the hole,
  /// in model units. 0: one ring of triangles.
  double flange_width = 0;
  /// True: every boundary loop is a hole. False: the longest boundary loop of each manifold patch
  /// is its outline.
  bool outer_loops = false;
  /// Smallest number of triangles of a crease feature. Smaller features are regarded as noise; a
  /// single vertex that sticks out affects about six triangles.
  int min_triangles = 10;
  /// True: creases inside other creases are detected too, such as the floor of a pocket inside its
  /// upper edge.
  bool nested = false;
};

/// A detected form feature.
struct DetectedFeature {
  enum class Kind { Hole, Crease };
  Kind kind;
  std::string name;           ///< "hole-1", "crease-1" and so on
  std::vector<int> vertices;  ///< indices of all vertices of the feature, ascending
  /// Closed chain of vertices: the boundary of the hole, with the surface on its left, or the
  /// crease, with the panel on its left.
  std::vector<int> loop;
  HoleMeasure measure;  ///< position, size and shape of `loop`
  /// True if the flange of a hole ends at a closed crease; always true for Kind::Crease.
  bool flange_ends_at_crease;
};

/// Detects the form features of a panel. The result contains the holes, then the creases; each kind
/// is numbered in the order of the lowest-numbered vertices of the loops.
///
/// Crease features: the crease edges divide the mesh into patches. The patches at the longest
/// boundary loop form the panel; the other patches are grouped into connected regions. A region
/// surrounded by the panel along one closed chain of edges is a feature: it consists of the
/// outermost crease and everything inside, including holes. A region with more than half of the
/// area is not a feature but the inner part of a panel with a flange; its largest patch is added to
/// the panel. Creases that are not closed give no feature, nor do strips between two parts of the
/// panel, such as the web of a flange.
///
/// Holes: every boundary loop except the longest of each manifold patch, together with the flange
/// around it. The flange is the first of the following sets that exists within `flange_rings`
/// rings:
/// - Everything up to the outermost closed crease, if this crease encloses no other hole. This
///   crease is not reported as a crease feature.
/// - Everything up to the first closed crease: all triangles that are reachable from the loop
///   without crossing a crease, if they reach no other boundary.
/// - One ring of triangles, or all vertices within `flange_width`.
///
/// Creases rounded off by many small elements (no dihedral angle above `crease_degrees`) are not
/// detected; use cut_feature() to separate such features.
///
/// Throws InputError if `crease_degrees` is not between 0 and 180. O(n log n).
std::vector<DetectedFeature> detect_features(const TriangleMesh& mesh,
                                             const FeatureDetectionOptions& options = {});

}  // namespace batten
