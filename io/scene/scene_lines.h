// Reads [[line]] and [[lines]] of any kind of scene. Internal.
#pragma once

#include <filesystem>
#include <vector>
#include <memory>
#include <string>

#include "batten/io/scene/scene.h"
#include "batten/fairing/curves/primitive_curves.h"
#include "batten/io/files/toml_table.h"

namespace batten {

/// Keys that [[line]] and [[lines]] may have; `roles` as in read_scene_lines().
std::vector<std::string> line_keys(bool roles);
std::vector<std::string> lines_keys(bool roles);

/// Reads all lines of a scene. `roles`: whether lines of this kind of scene have a role (outline,
/// hole, inner) and a treatment. `folder`: where paths begin. Throws InputError, also when there is
/// no line and one is required.
std::vector<SceneLine> read_scene_lines(const TomlTable& root, const std::filesystem::path& folder,
                                        bool roles, bool required = true);


// Words for curves in scenes: arc, circle, ellipse, helix, rectangle, spline, and copies.

/// The keys of a [[line]] that describe its shape, files and points among them; it has one of them.
const std::vector<std::string>& shape_keys();
/// The curve that one of the words arc, circle, ellipse, helix, rectangle, spline and bezier of
/// this table describes. Throws InputError with its place.
std::shared_ptr<const InputCurve> read_curve(const TomlTable& table, const std::string& word);

/// The keys that say where a copy lies: scale, turn, mirror, move.
const std::vector<std::string>& placement_keys();
/// Where the copy lies: scaled first, then turned, mirrored, moved. Throws InputError with the
/// place; none of them given.
AffineTransform read_placement(const TomlTable& table);

}  // namespace batten
