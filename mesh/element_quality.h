// Quality of shell elements, in the terms of FE preprocessors.
#pragma once

#include <vector>
#include <span>

#include "batten/mesh/shell_mesh.h"
#include "batten/core/eigen.h"

namespace batten {

/// Measures of one face with corners p_1 … p_k, without repeated ones (a quad whose last two nodes
/// are one is a triangle). N = ½ Σ p_i × p_i+1 is its area vector, n = N/|N|.
///
/// - aspect: longest edge over shortest width, times ½ cot(π/2k) for odd k or cot(π/k) for even k,
///   so that equilateral triangles, squares and all regular polygons have 1. The width at an edge
///   is the largest distance of a corner from the edge's line. Triangle: (√3/2) · longest edge /
///   shortest height. Infinite when flattened.
/// - warpage: angle between the normals of the two halves of a quad, for the diagonal where it is
///   larger; 0 for triangles; k > 4: the largest angle between the normals of two corners. A corner
///   that points inwards has its normal turned round, so its face has a warpage above 90.
/// - jacobian: smallest over largest Jacobian. At a corner it is n · (e_i × e_i-1), e_i the edges
///   from the corner to its neighbours: 1 for triangles and parallelograms. Faces of second order:
///   n · (x_ξ × x_η) of the quadratic or serendipity element at all its nodes. ≤ 0 is a bad
///   element; 0 when no Jacobian is positive, and for flattened triangles (height below 10⁻¹² of
///   the longest edge).
/// - smallest, largest angle: between edges at a corner, 0 to 360, above 180 where the corner's
///   normal points against n.
///
/// Fewer than three different corners: infinite aspect, Jacobian and angles 0. A coordinate that is
/// not a number makes all five not numbers. Aspect, warpage and angles of faces of second order are
/// those of their corners.
struct ElementQuality {
  double aspect, warpage_degrees, jacobian, smallest_angle_degrees, largest_angle_degrees;
};

/// Quality of one face of `shells` with its nodes at `points`.
ElementQuality quality_of(const ShellMesh& shells, const Points& points, int face);

/// Limits beyond which an element is counted as bad.
struct QualityLimits {
  double aspect = 5, warpage_degrees = 15, jacobian = 0.5;
  double smallest_triangle_angle_degrees = 20, largest_triangle_angle_degrees = 120;
  double smallest_angle_degrees = 45, largest_angle_degrees = 135;  ///< quads and polygons
};

/// One measure over all faces. What is not a number is worse than everything and beyond the limit.
struct MeasureSummary {
  double worst = 0;
  int worst_face = -1;  ///< the lowest of equally bad ones; -1 without faces
  double mean = 0;      ///< mean of the finite values
  int violations = 0;   ///< faces beyond the limit
};

struct QualitySummary {
  int faces = 0;
  MeasureSummary aspect, warpage_degrees, jacobian, smallest_angle_degrees, largest_angle_degrees;
};

/// Quality of all faces with the nodes at `points`. Throws InputError when there is not one point a
/// node. O(faces).
QualitySummary summarize(const ShellMesh& shells, const Points& points,
                         const QualityLimits& limits = {});

/// Faces that a change of shape spoilt, ascending:
///
/// - those whose Jacobian measure was positive `before` and is not `after` (zero, negative or not a
///   number): quads that fold in themselves, triangles that lost their area;
/// - folds: two faces share an edge (of no third face), the angle between their normals was below
///   90 degrees before and is above 120 after, normals taken as if both were wound the same way.
///   Of the two the one with more such edges is listed, both when they have equally many: a single
///   triangle turned over is listed, its three neighbours are not.
///
/// Rigid motions never make a face inverted. Throws InputError when there is not one point a node.
/// O(faces · log faces).
std::vector<int> inverted_faces(const ShellMesh& shells, const Points& before, const Points& after);


// Solid elements that a change of shape turned inside out.

/// Indices of the solids with a corner whose Jacobian (the volume that its three edges span) has
/// another sign `after` than `before`, or none: tetrahedra, pyramids (but for the tip), wedges and
/// hexahedra with their corners first. Corners without volume before do not count. O(elements).
std::vector<int> inverted_solids(std::span<const NonShellElement> elements, const Points& before,
                                 const Points& after);

/// Whether the element is a solid whose corners are known by the number of its nodes.
int corner_count(const NonShellElement& solid);

}  // namespace batten
