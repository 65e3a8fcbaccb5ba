// Measures STEP files that are read back. Internal.
#pragma once

#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <filesystem>
#include <vector>
#include <Geom_BSplineCurve.hxx>

#include "batten/io/step/step_report.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// Reads the shape of a file, in the unit of the present OccSettings. Throws InputError when it
/// cannot be read or holds no shape.
TopoDS_Shape read_step(const std::filesystem::path& path);

/// Measures everything in StepReport but the file's name and size, the area, and what compares with
/// regions.
/// `region_of_face`: the region of each face, in the file's order; faces beyond its end are one
/// region.
StepReport measure_shape(const TopoDS_Shape& shape, const std::vector<int>& region_of_face);

/// Measures a file as check_step() does, but without the patches, in the unit of the present
/// OccSettings. `fitted` gets the faces of cut regions, in their order; none when write_step() did
/// not write the file from these regions.
StepReport measured_file(const std::filesystem::path& path,
                         const std::vector<const SkinnedRegion*>& regions,
                         std::vector<TopoDS_Face>& fitted);

/// The largest distance of points inside the face from the nearest of the regions' surfaces.
/// O(triangles) for each point.
double nearest_deviation(const TopoDS_Face& face, const std::vector<const SkinnedRegion*>& regions);


// The parameter of edges, such that readers see how far an edge is from its faces. Internal.

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
