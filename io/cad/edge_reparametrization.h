// The parameter of edges, such that readers see how far an edge is from its faces. Internal.
#pragma once

#include <Geom_BSplineCurve.hxx>
#include <TopoDS_Shape.hxx>

namespace batten {

/// Changes the parameter along edges, and no curve's shape, so that the largest distance between an
/// edge and its faces is at one of the 23 evenly spaced parameters where OpenCASCADE's STEP reader
/// looks for it. A STEP file cannot state an edge's tolerance: the reader takes the largest distance
/// that it sees, and its check before boolean operations (FreeCAD's "BOP check") refuses an edge
/// that is farther from a face in between.
///
/// From shares s of the new parameter to shares x of the old one: x = s / (s + w (1 - s)). A
/// B-spline stays one with the same poles; a pole's weight is the product of s + w (1 - s) over its
/// knots. Edges within `least` of their faces stay as they are, closed edges, and edges with a curve that is
/// no B-spline. O(edges · knots).
void reparametrize_for_gap_check(const TopoDS_Shape& shape, double least);

/// Returns w of a curve that reparametrize_for_gap_check() may have changed; 1 when it did not.
double parameter_weight(const Geom_Curve& curve);

/// Returns the share s of the new parameter at a share x of the old one.
inline double reparametrized_fraction(double x, double w) { return w * x / (1 - x + w * x); }

}  // namespace batten
