// Words for curves in scenes: arc, circle, ellipse, helix, rectangle, spline, and copies.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/fairing/primitive_curves.h"
#include "batten/io/files/toml_table.h"

namespace batten {

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
