// SPDX-License-Identifier: MPL-2.0
// Reads the lines of a scene, from the scene itself and from files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/scene/scene.h"
#include "batten/scenes/lines/source_line.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

/// Kind of a curve file, determined by its extension.
enum class LineFileKind { None, Points, Cad, Drawing, Sketch };
LineFileKind line_file_kind(const std::filesystem::path& file);

/// Reads all lines of a file, in model units.
///
/// `unit`: unit of a point file (empty: the model's) or of a drawing (empty: its own, if it states
/// one). CAD files state their unit, and sketches are in the model's unit. `creases`: for CAD
/// files, also read the creases inside faces. Throws InputError.
std::vector<SourceLine> read_source_file(const std::filesystem::path& file, const std::string& unit,
                                         const std::string& model_unit, bool creases = false);

/// The note that only the edges of a CAD file's faces are read, and not the faces.
std::string cad_faces_note(const std::filesystem::path& file, int faces);

/// Reads the lines of a list, in order. `file`: the scene, for messages. Throws InputError, with
/// the location in the scene, for a missing file or an unknown kind. Also throws it for a file with
/// several lines where one is expected, a name that the file does not have, and duplicate names.
/// Names that occur in several files are preceded by the name of the file: "wing: edge 1".
std::vector<SourceLine> read_sources(const std::vector<SceneLine>& lines,
                                     const std::filesystem::path& file, const std::string& unit);
/// Reads all lines of the surface of a scene, with the corners at crossings
/// (find_crossing_corners()). Throws InputError.
std::vector<SourceLine> read_sources(const Scene& scene);

/// Reads the points of a scan, from all lines of its file, in model units; empty for other loads.
/// Throws InputError with the location in the scene or in the file.
std::vector<Vec3> scan_points(const Scene& scene, const SceneLoad& load);

/// Reads the lines of a scene as curves, without applying [[fair]]. Throws InputError.
std::vector<CharacterLine> read_lines(const Scene& scene);

}  // namespace batten
