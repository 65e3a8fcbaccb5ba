// Measures STEP files that are read back. Internal.
#pragma once

#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>

#include <filesystem>
#include <vector>

#include "batten/io/cad/step_report.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// Reads the shape of a file, in the unit of the present OccSettings. Throws InputError when it
/// cannot be read or holds no shape.
TopoDS_Shape read_step(const std::filesystem::path& path);

/// Measures everything in StepReport but the file's name and size, the area, and what compares with
/// regions.
/// `region_of_face`: the region of each face, in the file's order; faces beyond its end are one
/// region.
StepReport fit_primitive(const TopoDS_Shape& shape, const std::vector<int>& region_of_face);

/// Measures a file as check_step() does, but without the patches, in the unit of the present
/// OccSettings. `fitted` gets the faces of cut regions, in their order; none when write_step() did
/// not write the file from these regions.
StepReport measured_file(const std::filesystem::path& path,
                         const std::vector<const SkinnedRegion*>& regions,
                         std::vector<TopoDS_Face>& fitted);

/// The largest distance of points inside the face from the nearest of the regions' surfaces.
/// O(triangles) for each point.
double nearest_deviation(const TopoDS_Face& face, const std::vector<const SkinnedRegion*>& regions);

}  // namespace batten
