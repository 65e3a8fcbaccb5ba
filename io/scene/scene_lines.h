// Reads [[curve]] and [[curves]] of all kinds of scenes.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "batten/fairing/curves/primitive_curves.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/scene/scene.h"

namespace batten {

/// Permitted keys of [[curve]] and [[curves]]; `roles` as in read_scene_lines().
std::vector<std::string> line_keys(bool roles);
std::vector<std::string> lines_keys(bool roles);

/// Reads all lines of a scene. `roles`: true if lines of this kind of scene have a role (outline,
/// hole, inner) and a mesh alignment. `folder`: base of relative paths. Throws InputError, also if
/// there is no line although `required` is set.
std::vector<SceneLine> read_scene_lines(const TomlTable& root, const std::filesystem::path& folder,
                                        bool roles, bool required = true);

// Shape keys of curves: arc, circle, ellipse, helix, rectangle, spline; and copies.

/// The keys that define the shape of a [[curve]], including files and points; each line has exactly
/// one.
const std::vector<std::string>& shape_keys();
/// Reads the curve of a shape key of this table: arc, circle, ellipse, helix, rectangle, spline or
/// bezier. Throws InputError with its location.
std::shared_ptr<const InputCurve> read_curve(const TomlTable& table, const std::string& word);

/// The keys that transform a copy: scale, turn, mirror, move.
const std::vector<std::string>& placement_keys();
/// Reads the transform of a copy: scaling first, then rotation, mirroring and translation. Throws
/// InputError, with the location, also if none of them is given.
AffineTransform read_placement(const TomlTable& table);

}  // namespace batten
