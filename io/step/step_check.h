// SPDX-License-Identifier: MPL-2.0
// Measures STEP files that are read back.
#pragma once

#include <Geom_BSplineCurve.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <filesystem>
#include <vector>

#include "batten/io/step/step_report.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// Reads the shape of a file, in the unit of the current OccSettings. Throws InputError if the file
/// cannot be read or contains no shape.
TopoDS_Shape read_step(const std::filesystem::path& path);

/// Measures a shape. Sets everything in StepReport except file name, file size, area, and the
/// comparison with model faces. `region_of_face`: the model face index of each face, in file order;
/// faces beyond its end form one model face.
StepReport measure_shape(const TopoDS_Shape& shape, const std::vector<int>& region_of_face);

/// Measures a file as check_step() does, but without the patches, in the unit of the current
/// OccSettings. `fitted` receives the faces of the trimmed model faces, in order. It stays empty if
/// write_step() did not write the file from these model faces.
StepReport measured_file(const std::filesystem::path& path,
                         const std::vector<const SkinnedRegion*>& regions,
                         std::vector<TopoDS_Face>& fitted);

/// The largest distance between sample points inside the face and the closest of the model faces'
/// surfaces. O(triangles) per point.
double nearest_deviation(const TopoDS_Face& face, const std::vector<const SkinnedRegion*>& regions);

// Reparametrisation of edges, so that readers detect the distance between an edge and its faces.

/// Reparametrises edges without changing the shape of any curve. Afterwards, the largest distance
/// between an edge and its faces occurs at one of the 23 evenly spaced parameters that
/// OpenCASCADE's STEP reader samples. A STEP file cannot store the tolerance of an edge, so the
/// reader uses the largest distance it samples. Its check before Boolean operations (FreeCAD's "BOP
/// check") rejects an edge that is farther from a face in between.
///
/// A fraction s of the new parameter range maps to the fraction x = s / (s + w (1 - s)) of the old
/// one. A B-spline remains a B-spline with the same poles; the weight of a pole is the product of s
/// + w (1 - s) over its knots. Edges within `least` of their faces, closed edges, and edges with a
/// curve that is not a B-spline stay unchanged. O(edges · knots).
void reparametrize_for_gap_check(const TopoDS_Shape& shape, double least);

/// The weight w of a curve that reparametrize_for_gap_check() may have changed; 1 if it did not.
double parameter_weight(const Geom_Curve& curve);

/// The fraction s of the new parameter range that corresponds to the fraction x of the old one.
inline double reparametrized_fraction(double x, double w) { return w * x / (1 - x + w * x); }

}  // namespace batten
