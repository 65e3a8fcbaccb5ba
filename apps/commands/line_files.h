// The lines of a scene, from wherever they are.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/scene.h"

namespace batten {

/// How a file of lines is read, by its extension.
enum class LineFileKind { None, Points, Cad };
LineFileKind line_file_kind(const std::filesystem::path& file);

/// All lines of a file as outline lines, in model units. `unit`: of the file's numbers, for files
/// of points; files of CAD say it themselves. Throws InputError.
std::vector<CharacterLine> read_line_file(const std::filesystem::path& file,
                                          const std::string& unit, const std::string& model_unit,
                                          double corner_angle);

/// All lines of a scene in its order. Throws InputError with the place in the scene: a file that is
/// missing or of an unknown kind, a file of several lines where one was asked for, a name that its
/// file does not have, a name that two lines have.
std::vector<CharacterLine> read_lines(const Scene& scene);

}  // namespace batten
