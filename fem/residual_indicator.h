// Where a mesh is too coarse: jumps of curvature across edges.
#pragma once

#include "batten/fem/surface.h"

namespace batten {

/// An estimate of the bending energy's error, one η_T² for each triangle:
///
///     η_T² = ½ Σ_edges of T  h_e ∫_e |[x_nn]|² ds  +  Σ_spokes of T  h_s ∫_s |[x_nn]|² ds
///
/// [x_nn] is the jump of the second normal derivative, a vector. A C1 surface has no other jumps of
/// second derivatives, and so [x_nn] is also the jump of x_uu + x_vv, which is what is computed.
/// Spokes are the inner edges of HCT triangles. All in (u, v), unit beta: x² over domain length².
/// Zero for a cubic; O(h⁴) in sum on a smooth shape, as the energy's error. With a trim, only what
/// is inside counts; edges of the mesh's boundary have no jump. Integrals by three Gauss points:
/// exact for HCT. O(triangles), about a microsecond each.
/// Source: residual estimator of the plate, Verfürth 1996, with the edge term that dominates.
VecX residual_indicator(const Surface& surface);

}  // namespace batten
