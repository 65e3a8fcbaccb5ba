// Sets of tensor-product B-spline patches, as G+Smo writes them (.xml). Internal.
#pragma once

#include <TopoDS_Shape.hxx>
#include <filesystem>
#include <string>

namespace batten {

/// Every TensorBSpline2 and TensorNurbs2 of three coordinates as a face on its whole domain; poles come with
/// the first direction running fastest. Edges of patches that lie within 1e-5 of the size of each other are one.
/// Throws InputError with the number of the patch: no patch at all, knots that do not rise, too few or too
/// many poles, numbers that are none or not finite, weights that are not positive.
TopoDS_Shape read_patches(const std::filesystem::path& file, const std::string& text);

}  // namespace batten
