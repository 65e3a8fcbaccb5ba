// Text summaries of files: scenes, curves, CAD models, meshes and sequences.
#pragma once

#include <filesystem>
#include <string>

#include "batten/io/scene/scene.h"

namespace batten {

/// Describes a file in a few lines of text:
/// - a scene (.toml): its curves and parameters;
/// - points, CAD curves, drawings or sketches: the curves with lengths, ends, planes, and how they
///   were interpreted;
/// - a CAD file: unit, products, names, colours and layers, and the continuity of its edges; for
///   STEP also its validity;
/// - a mesh or a mesh sequence: its contents.
///
/// `unit`: length unit of the text and of point files; a scene has its own. Throws InputError.
std::string file_info(const std::filesystem::path& file, const std::string& unit);

/// Draws the curves of a scene or file as they were read, with points and curvature combs, to a PNG.
/// For a CAD file with faces it draws their edges (draw_face_edges). Throws InputError if there are
/// no curves or no display.
void draw_lines(const std::filesystem::path& picture, const std::filesystem::path& file,
                const std::string& unit);

/// Finds the faces of a network scene, and draws every ambiguous face with its alternatives
/// into `folder`: alternatives_1.png, alternatives_2.png, … Each picture shows the location, the current
/// surfaces, and all alternatives. The result describes each decision, with the TOML that selects
/// each alternative. Throws InputError if there is no network or no display, and the exceptions of
/// build_network() and require_regions().
std::string draw_alternatives(const std::filesystem::path& folder, const Scene& scene);

// Detection of the kind of a file.

/// Determines the kind of a file by its extension, or by its contents if curves and meshes share
/// the extension. A `.obj` with faces is a mesh; a `.dat` with grid points is a Nastran deck.
enum class FileKind { None, Scene, Mesh, Sequence, Cad, Lines };
FileKind file_kind(const std::filesystem::path& file);

}  // namespace batten
