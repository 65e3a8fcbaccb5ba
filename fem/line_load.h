// A load along a line of the surface.
#pragma once

#include "batten/fem/hermite_curve.h"
#include "batten/fem/triangle_locator.h"

namespace batten {

/// ∫ N(c(t)) |X'(t)| dt, one number a dof: the load of a unit force per length of the line. Times a
/// direction it is a load of the surface; position dofs add up to the line's length.
/// `pcurve`: c(t) in (u, v), z = 0; `curve`: X(t) in space; both over the same parameters (EdgeAlignedLine:
/// edge_aligned_pcurve and `fitted`; EmbeddedLine: `pcurve` and `fitted`). The line is cut where it passes
/// from one cubic of an element to the next; six Gauss points on pieces no longer than half an
/// element, right to 1e-8 and better. Throws InputError when the two curves have different
/// intervals. O(length / element size), some microseconds each.
VecX line_load(const ParametricMesh& mesh, TriangleElement kind, const TriangleLocator& locator,
               const HermiteCurve& pcurve, const HermiteCurve& curve);

}  // namespace batten
