// Faces in a STEP file: written, and measured on the file read back. Internal.
#pragma once

#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>

#include <filesystem>
#include <vector>

#include "batten/io/face_maker.h"
#include "batten/io/occ_settings.h"

namespace batten {

/// OpenCASCADE's settings for write_faces().
void set_up_faces(OccSettings& occ, const std::string& unit, const std::string& product);

/// Whether OpenCASCADE finds nothing wrong with what is written; readers repair silently.
/// `tolerance`: what the file declares. Throws Error.
bool write_faces(const std::filesystem::path& path, const TopoDS_Shape& shape, double tolerance,
                 OccSettings& occ, const StepFaceOptions& options);

/// The file read back, its faces in the order in which they were written (made), each against its
/// region. Fills all of a StepFaceReport but file and seconds; `shape` becomes what was read.
/// Throws Error when there are other faces.
StepFaceReport measured_faces(const std::filesystem::path& path,
                              const std::vector<const FaceMaker*>& made, double tolerance,
                              TopoDS_Shape& shape);

/// Throws InputError.
void check_options(const std::filesystem::path& path, const StepFaceOptions& options);

}  // namespace batten
