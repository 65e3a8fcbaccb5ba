// Describes the faces of CAD files, and draws how they meet.
#pragma once

#include <filesystem>
#include <string>

namespace batten {

bool is_step_file(const std::filesystem::path& file);
bool is_cad_file(const std::filesystem::path& file);  ///< STEP or IGES, by its ending

/// What the faces of a STEP or IGES file are, and how they meet; "" for a file without faces. Throws
/// InputError.
std::string faces_text(const std::filesystem::path& file, const std::string& unit);

/// Draws the edges of a CAD file with combs of the curvature across them, on both sides. Returns false
/// for a file that has no faces. Throws InputError.
bool draw_face_edges(const std::filesystem::path& picture, const std::filesystem::path& file,
                     const std::string& unit);

}  // namespace batten
