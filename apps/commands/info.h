// What is in a file, in a few lines of text.
#pragma once

#include <filesystem>
#include <string>

namespace batten {

/// A scene (.toml): its lines and parameters. Points or CAD: its lines with lengths and ends. STEP
/// with faces: what is in it and whether it is valid. `unit`: of lengths in the answer, for a file
/// that is not a scene; also what files of points are taken to be in. Throws InputError.
std::string file_info(const std::filesystem::path& file, const std::string& unit);

}  // namespace batten
