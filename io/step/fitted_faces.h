// Fits faces, and measures them on the STEP file read back. Internal.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "batten/io/step/face_maker.h"
#include "batten/io/step/step_report.h"

namespace batten {

using FittedFaces = std::vector<std::unique_ptr<FaceMaker>>;

/// Fits a face to every region that is none of `analytic`, on all threads. `options`, `analytic` and the regions must
/// outlive the result. Regions whose analytic face alone is not valid, or misses a smooth join, are put into `failed`,
/// and nothing is fitted then.
FittedFaces fitted_faces(const std::vector<const SkinnedRegion*>& regions, const StepPlan& plan,
                         const StepFaceOptions& options, const AnalyticFaces& analytic = {},
                         std::vector<const SkinnedRegion*>* failed = nullptr);

/// Writes a file and measures it, and again with finer fits of the faces that miss the tolerance or
/// an angle, as long as that helps: six times at most. `written` makes all faces, writes them and returns
/// the report with patches in the order of `made`.
StepReport refined(const FittedFaces& made, const StepFaceOptions& options,
                   const std::function<StepReport()>& written);

/// Measures the `faces` of the file read back against the regions of `made`, on all threads, and
/// adds the patches to the report. `rest` measures the rest of the report meanwhile.
void measure_patches(StepReport& report, const std::vector<TopoDS_Face>& faces,
                     const FittedFaces& made, const StepPlan& plan, const StepFaceOptions& options,
                     const std::function<void()>& rest = {});

/// Reads the file back and measures each face, in the order of `made`, against its region: all of a
/// StepReport but file and warnings. `beside` is work for another thread while the file is read.
/// Throws Error when the file has another number of faces.
StepReport measured_faces(const std::filesystem::path& path, const FittedFaces& made,
                          const StepPlan& plan, const StepFaceOptions& options,
                          const std::function<void()>& beside);

/// Throws InputError for a tolerance or a limit of poles out of its range.
void check_options(const std::filesystem::path& path, const StepFaceOptions& options);

}  // namespace batten
