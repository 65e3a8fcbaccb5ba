// Measures how good a finished surface is.
#pragma once

#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// Returns the largest distance |x(c(t)) - X(t)| of a shape from its embedded line, of 20 samples
/// between any two points.
double line_gap(const Surface& surface, const EmbeddedLine& line);

/// Marks the triangles, one mark for each of the region, under the stretches of embedded lines that
/// the surface leaves by more than `target` between two points.
void mark_gaps(const SkinnedRegion& region, double target, char* marks);

/// How far the finished surface is from what it promises, measured by sampling.
struct SkinQuality {
  double max_line_residual = 0;    ///< surface from its fitted lines, over the region's size
  double max_line_gap = 0;         ///< surface from the curves of embedded lines, model units
  double max_line_deviation = 0;   ///< surface from the input lines, both ways, model units
  double max_normal_jump_deg = 0;  ///< between normals across inner element edges
  double min_jacobian_ratio = 0;   ///< smallest |x_u × x_v| (oriented) over the median
  double max_shear = 1;            ///< largest σ1/σ2 of (x_u, x_v)
  double rms_strain = 0;           ///< Distortion::rms of the domain against the surface
  int singular_nodes = 0;          ///< vertices where x_u × x_v is below 1e-6 of the median
  double area = 0;                 ///< model units²
};
SkinQuality measure(const SkinnedRegion& region);
/// The part of it that needs no line: normals, Jacobians, singular nodes, area. A tenth of the time.
SkinQuality measure(const Surface& surface);

}  // namespace batten
