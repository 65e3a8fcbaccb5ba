// SPDX-License-Identifier: MPL-2.0
// Quality measures of shell elements as used by FE preprocessors, and detection of inverted
// elements.
#pragma once

#include <span>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/shell_mesh.h"

namespace batten {

/// Quality measures of one face with k corners. Repeated corners are counted once (a quad whose
/// last two nodes coincide is a triangle). The normal n is the unit vector along Σ p_i × p_i+1,
/// summed over the corners p_i.
///
/// - aspect: ratio of the longest edge to the smallest width, times ½ cot(π/2k) for odd k or
///   cot(π/k) for even k. The aspect is 1 for all regular polygons. The width at an edge is the
///   largest distance of a corner from the line of the edge. The aspect of a triangle is (√3/2) ·
///   longest edge / shortest height, that of a degenerate face is infinite.
/// - warpage: for quads, the angle between the normals of the two triangles, for the diagonal that
///   gives the larger angle; for triangles 0; for k > 4, the largest angle between the normals at
///   two corners. A re-entrant corner has a reversed normal, so its face has a warpage above 90.
/// - jacobian: ratio of the smallest to the largest Jacobian determinant of the face. At a corner
///   the determinant is n · (e_i × e_i-1), where e_i are the edges from the corner to its
///   neighbours; the ratio is 1 for triangles and parallelograms. For second-order faces it is
///   n · (x_ξ × x_η) of the quadratic or serendipity element at all its nodes. A ratio ≤ 0 means an
///   invalid element. The ratio is 0 if no determinant is positive, and for degenerate triangles
///   (height below 10⁻¹² of the longest edge).
/// - smallest and largest angle: angles between the two edges at a corner, 0 to 360. The angle is
///   above 180 if the normal of the corner points against n.
///
/// If there are fewer than three distinct corners, the aspect is infinite, and Jacobian and angles
/// are 0. If a coordinate is not finite, all measures are NaN. Aspect, warpage and angles of
/// second-order faces are computed from the corners only. Angles and warpage are in degrees.
struct ElementQuality {
  double aspect, warpage_degrees, jacobian, smallest_angle_degrees, largest_angle_degrees;
};

/// Quality measures of one face of `shells`, for example after a deformation. `points`: positions
/// of all nodes (n×3), used instead of `shells.points`.
ElementQuality quality_of(const ShellMesh& shells, const Points& points, int face);

/// Limits beyond which a quality measure of an element counts as a violation. Angles are in
/// degrees.
struct QualityLimits {
  double aspect = 5, warpage_degrees = 15, jacobian = 0.5;
  double smallest_triangle_angle_degrees = 20, largest_triangle_angle_degrees = 120;
  /// Limits of the angles of faces with four or more corners.
  double smallest_angle_degrees = 45, largest_angle_degrees = 135;
};

/// Summary of one quality measure over the faces of a mesh. NaN is the worst value and a violation.
struct MeasureSummary {
  double worst = 0;
  int worst_face = -1;  ///< face with the worst value (ties: lowest index); -1: no faces
  double mean = 0;      ///< mean of the finite values over the faces
  int violations = 0;   ///< number of faces beyond the limit of QualityLimits
};

/// Summary of all quality measures over all faces of a mesh.
struct QualitySummary {
  int faces = 0;
  MeasureSummary aspect, warpage_degrees, jacobian, smallest_angle_degrees, largest_angle_degrees;
};

/// Computes the quality measures of all faces of `shells`, and compares them with `limits`.
/// `points`: positions of all nodes (n×3), used instead of `shells.points`. Throws InputError
/// unless there is one point per node. O(faces).
QualitySummary summarize(const ShellMesh& shells, const Points& points,
                         const QualityLimits& limits = {});

/// Indices of the faces that a deformation inverted or folded, ascending. `before` and `after` are
/// the node positions before and after the deformation (n×3). The faces listed are:
///
/// - Faces whose `jacobian` (see ElementQuality) was above 1e-6 before and is zero, negative or NaN
///   afterwards. These are quads that fold onto themselves and triangles that lost their area.
/// - Folded faces. At a folded edge, which two faces share (and no third one), the angle between
///   the normals of these faces was below 90 degrees before and is above 120 degrees afterwards.
///   The normals are taken as if both faces had the same orientation. Of the two faces, the one
///   with more folded edges is listed, or both if the numbers are equal. Therefore a single flipped
///   triangle is listed, but its three neighbours are not.
///
/// The result is empty for rigid motions. Throws InputError unless there is one point per node.
/// O(faces · log faces).
std::vector<int> inverted_faces(const ShellMesh& shells, const Points& before, const Points& after);

// Solid elements inverted by a deformation.

/// Indices of the solid elements that a deformation inverted. An element is inverted if, at one of
/// its corners, the Jacobian determinant (triple product of the three edges) changes its sign or
/// becomes 0. `before`, `after`: node positions before and after the deformation (n×3). Tetrahedra,
/// pyramids (except at the apex), wedges and hexahedra are supported; their corner nodes come
/// first. Corners whose determinant before the deformation is 0, or has not the sign of the sum over
/// all corners, are ignored: they were bad before. O(elements).
std::vector<int> inverted_solids(std::span<const NonShellElement> elements, const Points& before,
                                 const Points& after);

/// Number of corners of a solid element (4, 5, 6 or 8), deduced from its number of nodes; 0 for an
/// element that is not solid or has an unsupported number of nodes.
int corner_count(const NonShellElement& solid);

}  // namespace batten
