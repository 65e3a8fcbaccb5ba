// Describes the faces of CAD files, and draws how they meet.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace batten {

/// What a CAD file holds, and how its faces meet. `lines` gives the text about its lines, which is added where
/// they are few or all that there is. Throws InputError.
std::string cad_info(const std::filesystem::path& file, const std::string& unit,
                     const std::function<std::string()>& lines);

/// Draws the edges of a CAD file with combs of the curvature across them, on both sides. Returns false
/// for a file that has no faces. Throws InputError.
bool draw_face_edges(const std::filesystem::path& picture, const std::filesystem::path& file,
                     const std::string& unit);

}  // namespace batten
