// Measuring STEP files that are read back. Internal.
#pragma once

#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>

#include <filesystem>
#include <vector>

#include "batten/io/cad/step_report.h"
#include "batten/skinning/region/region.h"

namespace batten {

/// What is in the file, in the unit of the OccSettings alive. Throws InputError.
TopoDS_Shape read_step(const std::filesystem::path& path);

/// Everything in StepReport but the file's name and size and what compares with regions.
/// `region_of_face`: of each face in the file's order; faces beyond its end are one region.
StepReport measured_shape(const TopoDS_Shape& shape, const std::vector<int>& region_of_face);

/// As check_step, in the unit of the OccSettings alive, but for the patches: `fitted` gets the
/// faces of cut regions, in their order; none where the file is not one of write_step with these
/// regions.
StepReport measured_file(const std::filesystem::path& path,
                         const std::vector<const SkinnedRegion*>& regions,
                         std::vector<TopoDS_Face>& fitted);

/// Largest distance of points inside the face from the nearest of the regions' surfaces.
/// O(triangles) a point.
double nearest_deviation(const TopoDS_Face& face, const std::vector<const SkinnedRegion*>& regions);

}  // namespace batten
