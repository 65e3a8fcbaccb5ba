// Measures the continuity (G0, G1, G2) between adjacent faces of a CAD file.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Thresholds and sampling options of measure_continuity().
struct ContinuityOptions {
  /// An edge is G1 if the angle between its faces stays below this, degrees.
  double angle_deg = 0.1;
  double curvature = 0.05;  ///< a G1 edge is G2 if the relative curvature jump stays below this
  /// Free edges within this distance of each other, relative to the model size, count as one edge.
  /// IGES faces share no edges, so they need this. 0 to 0.1; 0: no sewing.
  double sewing = 1e-5;
  /// Approximate number of comb teeth per edge, for pictures; 0: no combs and no free_edge_lines.
  int comb_samples = 0;
};

/// Curvature of the two adjacent faces across an edge, at one point of it.
struct EdgeCombSample {
  Vec3 at = Vec3::Zero();
  /// Normal curvature times unit normal of each face: it points towards the centre of curvature,
  /// model units⁻¹.
  std::array<Vec3, 2> curvature_vectors{};
};

/// One edge with two adjacent faces (for a seam, the same face twice). It is measured at 17 points,
/// or at four per knot of the splines if that is more (at most 401). 1 % of its length is left out
/// at both ends. Lengths are in model units.
struct EdgeContinuity {
  int edge = 0;                ///< 1-based index in the file
  std::array<int, 2> faces{};  ///< 1-based indices of its faces
  double length = 0;
  double gap = 0;        ///< largest distance between the two faces
  double angle_deg = 0;  ///< largest angle between their tangent planes
  /// Largest difference of the normal curvatures across the edge, |κ_a - κ_b|, model units⁻¹. The
  /// relative jump divides it by the largest of |κ_a|, |κ_b| and 1 / model size.
  double curvature_jump = 0, relative_jump = 0;
  /// Position of the largest angle (crease) or of the largest relative jump (otherwise).
  Vec3 at = Vec3::Zero();
  enum class Kind { Crease, Tangent, Curvature } kind = Kind::Crease;
  /// Along the edge; only with ContinuityOptions::comb_samples.
  std::vector<EdgeCombSample> comb_samples;
};

/// Continuity of all edges of a file, with counts of its shapes. Lengths are in model units.
struct ContinuityReport {
  int solids = 0, shells = 0, faces = 0, edges = 0;
  int free_edges = 0;                 ///< edges with one face
  int non_manifold_edges = 0;         ///< edges with three faces or more
  int unmeasured = 0;                 ///< edges with a point without tangent or curvature
  double size = 0;                    ///< diagonal of the bounding box of all edges
  double area = 0;                    ///< total area of the faces
  std::vector<EdgeContinuity> inner;  ///< edges with two faces, in file order
  /// 1-based indices of faces narrower than a thousandth of their length.
  std::vector<int> slivers;
  /// Polylines along the free edges; only with ContinuityOptions::comb_samples.
  std::vector<std::vector<Vec3>> free_edge_lines;
  /// The number of edges of this kind.
  int count(EdgeContinuity::Kind kind) const;
  /// The worst edge of a kind, or nullptr if there is none. Creases are compared by their gap, G1
  /// edges by their angle, G2 edges by their relative curvature jump.
  const EdgeContinuity* worst(EdgeContinuity::Kind kind) const;
  /// The largest angle over all edges that are not creases; 0 if there are none.
  double max_smooth_deg() const;
};

// Reads and measures a file.

/// Reads a STEP, IGES or BREP file and measures the continuity across its edges. Each face is
/// evaluated at the closest point to the edge point (Newton's method). The curvature is the
/// quotient II/I of the fundamental forms in the direction across the edge. Throws InputError as
/// read_cad_lines() does, for options out of range, and for a file without faces. Takes about 0.1
/// ms per edge.
ContinuityReport measure_continuity(const std::filesystem::path& file, double model_unit_in_metres,
                                    const ContinuityOptions& options = {});

/// Formats the report as a few lines of text, with the worst edges.
std::string continuity_text(const ContinuityReport& report, const ContinuityOptions& options,
                            const std::string& unit);

}  // namespace batten
