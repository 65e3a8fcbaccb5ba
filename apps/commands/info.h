// Describes a file in a few lines of text.
#pragma once

#include <filesystem>
#include <string>

#include "batten/io/scene/scene.h"

namespace batten {

/// Describes a scene (.toml) by its lines and parameters; a file of points, CAD, drawings or
/// sketches by its lines with lengths, ends, planes and how they were read; a CAD file by its unit,
/// products, names, colours and layers, and how its faces meet; a STEP file also by whether it is
/// valid; a mesh, or a deforming one, by what is in it. `unit` is that of lengths in the text, and
/// of files of points; a scene has its own. Throws InputError.
std::string file_info(const std::filesystem::path& file, const std::string& unit);

/// Draws the lines of a scene or a file as they were read, with their points and curvature combs,
/// to a PNG; of a CAD file with faces their edges (draw_face_edges). Throws InputError: no lines, no display.
void draw_lines(const std::filesystem::path& picture, const std::filesystem::path& file,
                const std::string& unit);

/// Finds the regions of a scene with a network, and the choices that could as well have been made
/// otherwise. Draws each into `folder` as choice_1.png, choice_2.png …: where it is, the surfaces as
/// they are, and every other way. Returns what each is about, and for every way the words for a
/// scene that settle it. Throws InputError: no network, no display, what network_of() and
/// regions_of() throw.
std::string draw_alternatives(const std::filesystem::path& folder, const Scene& scene);


// What kind of thing a file holds.

/// What the program takes a file for: by its ending, and where lines and meshes share one, by what
/// is in it. `.obj` with faces is a mesh, `.dat` with grid points a Nastran deck.
enum class FileKind { None, Scene, Mesh, Sequence, Cad, Lines };
FileKind file_kind(const std::filesystem::path& file);

}  // namespace batten
