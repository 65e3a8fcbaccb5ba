// What is measured of how faces of a CAD file meet: G0, G1, G2.
#pragma once

#include <array>
#include <vector>
#include <filesystem>
#include <string>

#include "batten/core/eigen.h"

namespace batten {

struct ContinuityOptions {
  double angle_deg = 0.1;   ///< faces that meet by less than this along a whole edge are tangent
  double curvature = 0.05;  ///< and have one curvature where the jump is below this share
  /// Rims of faces that lie within this of each other, of the size, count as one edge: faces of
  /// IGES files share none.
  double sewing = 1e-5;
  int comb_samples = 0;  ///< about how many teeth an edge gets, for pictures; 0: none, and no rims
};

/// How the two faces bend across an edge at a place of it.
struct EdgeCombSample {
  Vec3 at = Vec3::Zero();
  /// Normal curvature times unit normal of each face: towards the centre of curvature, model units⁻¹.
  std::array<Vec3, 2> curvature_vectors{};
};

/// One edge with a face on either side (a seam has the same face twice), measured at 17 points, or
/// four a knot of its splines, the ends left out by a hundredth of its length. Lengths are in model units.
struct EdgeContinuity {
  int edge = 0;                ///< its number, from 1
  std::array<int, 2> faces{};  ///< numbers of its faces, from 1
  double length = 0;
  double gap = 0;        ///< largest distance between the two faces
  double angle_deg = 0;  ///< largest angle between their tangent planes
  /// Largest difference of the normal curvatures across the edge, κ_a - κ_b, model units⁻¹; and over
  /// the larger of |κ_a|, |κ_b| and 1 / size of the file.
  double curvature_jump = 0, relative_jump = 0;
  Vec3 at = Vec3::Zero();  ///< where the angle is largest; of tangent faces the jump
  enum class Kind { Crease, Tangent, Curvature } kind = Kind::Crease;
  std::vector<EdgeCombSample> comb_samples;  ///< in its direction; ContinuityOptions::comb_samples
};

struct ContinuityReport {
  int solids = 0, shells = 0, faces = 0, edges = 0;
  int free_edges = 0;                 ///< edges with one face
  int non_manifold_edges = 0;         ///< edges with three faces or more
  int unmeasured = 0;                 ///< edges without a direction or a curvature at some point
  double size = 0;                    ///< diagonal of the box around all edges
  double area = 0;                    ///< of all faces
  std::vector<EdgeContinuity> inner;  ///< edges with two faces, in the file's order
  std::vector<int> slivers;           ///< faces narrower than a thousandth of their length
  std::vector<std::vector<Vec3>>
      free_edge_lines;  ///< points along the rims; ContinuityOptions::comb_samples
  int count(EdgeContinuity::Kind kind) const;
  /// The edge of that kind where gap, angle or jump is largest; nullptr: none. Creases by their gap,
  /// tangent edges by their angle, those of one curvature by the jump.
  const EdgeContinuity* worst(EdgeContinuity::Kind kind) const;
  /// The largest angle of edges that are no creases; 0 without any.
  double max_smooth_deg() const;
};


// How faces of a CAD file meet along their edges: G0, G1, G2.

/// Reads a STEP, IGES or BREP file and measures it. At a point of an edge each face is taken at its
/// nearest point (Newton's method on the surface); curvature is II/I in the direction across the
/// edge. Throws InputError as read_cad_lines() does, on options out of range, and for a file
/// without faces. About 0.1 ms an edge.
ContinuityReport measure_continuity(const std::filesystem::path& file, double model_unit_in_metres,
                                    const ContinuityOptions& options = {});

/// The report in a few lines of text, with the worst edges.
std::string continuity_text(const ContinuityReport& report, const ContinuityOptions& options,
                            const std::string& unit);

}  // namespace batten
