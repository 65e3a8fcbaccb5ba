// Fitted faces in a STEP file, measured on the file read back. Internal.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "batten/io/cad/face_maker.h"
#include "batten/io/cad/step_report.h"

namespace batten {

using FittedFaces = std::vector<std::unique_ptr<FaceMaker>>;

/// Fits every region, on all threads. `options` and regions are to live as long.
FittedFaces fitted_faces(const std::vector<const SkinnedRegion*>& regions, const StepPlan& plan,
                         const StepFaceOptions& options);

/// Writes a file and measures it, with finer fits of faces that miss the tolerance as long as that
/// helps, four times at most. `written` makes all faces, writes them and gives the report, patches
/// in the order of `made`.
StepReport refined(const FittedFaces& made, const std::function<StepReport()>& written);

/// Adds to the report what `faces` of the file read back are against the regions of `made`.
void measure_patches(StepReport& report, const std::vector<TopoDS_Face>& faces,
                     const FittedFaces& made, double tolerance);

/// The file read back, its faces in the order in which they were written (made), each against its
/// region: all of a StepReport but file and warnings. Throws Error when there are other faces.
StepReport measured_faces(const std::filesystem::path& path, const FittedFaces& made,
                          double tolerance);

/// Throws InputError.
void check_options(const std::filesystem::path& path, const StepFaceOptions& options);

}  // namespace batten
