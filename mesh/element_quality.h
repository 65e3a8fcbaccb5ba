// Quality measures of shell elements as used by FE preprocessors, and detection of inverted
// elements.
#pragma once

#include <span>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/shell_mesh.h"

namespace batten {

/// Quality measures of one face. The corners p_1 … p_k are taken without repetition (a quad whose
/// last two nodes coincide is a triangle). N = ½ Σ p_i × p_i+1 is the area vector, n = N/|N|.
///
/// - aspect: longest edge over smallest width, times ½ cot(π/2k) for odd k or cot(π/k) for even k.
///   It is 1 for all regular polygons. The width at an edge is the largest distance of a corner
///   from the line of the edge. For triangles it is (√3/2) · longest edge / shortest height.
///   Infinite for degenerate faces.
/// - warpage: for quads, the angle between the normals of the two triangles, for the diagonal that
///   gives the larger one. 0 for triangles. For k > 4, the largest angle between the normals of two
///   corners. A re-entrant corner has a reversed normal, so its face has a warpage above 90.
/// - jacobian: smallest over largest Jacobian. At a corner it is n · (e_i × e_i-1), with e_i the
///   edges from the corner to its neighbours; the ratio is 1 for triangles and parallelograms. For
///   second-order faces it is n · (x_ξ × x_η) of the quadratic or serendipity element at all its
///   nodes. Values ≤ 0 mean an invalid element. The ratio is 0 if no Jacobian is positive, and for
///   degenerate triangles (height below 10⁻¹² of the longest edge).
/// - smallest and largest angle: between the edges at a corner, 0 to 360. Above 180 if the normal
///   of the corner points against n.
///
/// With fewer than three distinct corners, aspect is infinite, Jacobian and angles are 0. If a
/// coordinate is not finite, all five measures are NaN. Aspect, warpage and angles of second-order
/// faces are computed from the corners only. Angles and warpage are in degrees.
struct ElementQuality {
  double aspect, warpage_degrees, jacobian, smallest_angle_degrees, largest_angle_degrees;
};

/// Quality of one face of `shells` with its nodes at `points`.
ElementQuality quality_of(const ShellMesh& shells, const Points& points, int face);

/// Limits beyond which an element counts as bad. Angles are in degrees.
struct QualityLimits {
  double aspect = 5, warpage_degrees = 15, jacobian = 0.5;
  double smallest_triangle_angle_degrees = 20, largest_triangle_angle_degrees = 120;
  double smallest_angle_degrees = 45, largest_angle_degrees = 135;  ///< quads and polygons
};

/// Summary of one measure over all faces. NaN counts as worse than any value and as a violation.
struct MeasureSummary {
  double worst = 0;
  int worst_face = -1;  ///< face with the worst value (lowest index of ties); -1 without faces
  double mean = 0;      ///< mean of the finite values
  int violations = 0;   ///< number of faces beyond the limit
};

/// Summary of all measures over all faces.
struct QualitySummary {
  int faces = 0;
  MeasureSummary aspect, warpage_degrees, jacobian, smallest_angle_degrees, largest_angle_degrees;
};

/// Computes the quality of all faces with the nodes at `points`. Throws InputError unless there is
/// one point per node. O(faces).
QualitySummary summarize(const ShellMesh& shells, const Points& points,
                         const QualityLimits& limits = {});

/// Faces that a deformation inverted or folded, ascending:
///
/// - Faces whose Jacobian measure was positive `before` and is not positive `after` (zero, negative
///   or NaN). These are quads that fold onto themselves and triangles that lost their area.
/// - Folds: two faces share an edge (with no third face), the angle between their normals was below
///   90 degrees before and is above 120 after. The normals are taken as if both faces had the same
///   orientation. Of the two faces, the one with more such edges is listed, or both if the numbers
///   are equal. So a single flipped triangle is listed, but its three neighbours are not.
///
/// Rigid motions never cause an entry. Throws InputError unless there is one point per node.
/// O(faces · log faces).
std::vector<int> inverted_faces(const ShellMesh& shells, const Points& before, const Points& after);

// Solid elements inverted by a deformation.

/// Indices of solids that a deformation inverted. At some corner the Jacobian (triple product of
/// the three edges) changes its sign from `before` to `after`, or becomes 0. Supports tetrahedra,
/// pyramids (except at the apex), wedges and hexahedra, whose corner nodes come first. Corners that
/// had no volume before are ignored. O(elements).
std::vector<int> inverted_solids(std::span<const NonShellElement> elements, const Points& before,
                                 const Points& after);

/// Number of corners of a solid (4, 5, 6 or 8), deduced from its number of nodes; 0 for other
/// elements and unknown node counts.
int corner_count(const NonShellElement& solid);

}  // namespace batten
