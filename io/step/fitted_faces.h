// Fits CAD faces to model faces, and measures them on the STEP file that is read back.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "batten/io/step/face_maker.h"
#include "batten/io/step/step_report.h"

namespace batten {

/// One FaceMaker per model face; see fitted_faces().
using FittedFaces = std::vector<std::unique_ptr<FaceMaker>>;

/// Fits a face to every model face without an analytic face, on all threads. `options`, `analytic`
/// and the model faces must outlive the result. Model faces whose analytic face is invalid by
/// itself, or misses a smooth join, are added to `failed`; in that case nothing is fitted.
FittedFaces fitted_faces(const std::vector<const SkinnedRegion*>& regions, const StepPlan& plan,
                         const StepFaceOptions& options, const AnalyticFaces& analytic = {},
                         std::vector<const SkinnedRegion*>* failed = nullptr);

/// Writes a file and measures it. Repeats this with finer fits of the faces that miss the tolerance
/// or an angle, as long as that helps, six times at most. `written` makes and writes all faces, and
/// returns the report with the patches in the order of `made`.
StepReport refined(const FittedFaces& made, const StepFaceOptions& options,
                   const std::function<StepReport()>& written);

/// Measures the `faces` of a file read back against the model faces of `made`, on all threads, and
/// adds the patches to the report. `rest` runs in parallel and measures the rest of the report.
void measure_patches(StepReport& report, const std::vector<TopoDS_Face>& faces,
                     const FittedFaces& made, const StepPlan& plan, const StepFaceOptions& options,
                     const std::function<void()>& rest = {});

/// Reads the file back and measures each face, in the order of `made`, against its model face. Sets
/// everything in StepReport except `file` and `warnings`. `beside` runs on another thread while the
/// file is read. Throws UnwritableRegions if the file has a different number of faces.
StepReport measured_faces(const std::filesystem::path& path, const FittedFaces& made,
                          const StepPlan& plan, const StepFaceOptions& options,
                          const std::function<void()>& beside);

/// Throws InputError if the tolerance or a limit on poles is out of range.
void check_options(const std::filesystem::path& path, const StepFaceOptions& options);

}  // namespace batten
