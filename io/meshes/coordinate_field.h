// The characters that stand for a coordinate in a field of a file. Internal.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "batten/io/meshes/mesh_source_text.h"

namespace batten {

/// Whether fields of this kind fill columns.
bool is_fixed_width(FieldKind kind);
/// Whether it is a field of a deck, whose width is bounded.
inline bool is_deck_field(FieldKind kind) { return width_of(kind) > 0; }
/// The characters that stand for `value`, and what a reader will make of them; empty where none do.
std::string format_field(double value, FieldKind kind, double& written);
/// `text` where the old field has its own: at the left, or in the last column.
std::string aligned(const std::string& text, const Field& field, std::string_view old);
/// A small-field GRID as two large-field lines.
std::string large_field_grid(std::string_view line, const std::array<std::string, 3>& coordinates,
                             const std::string& line_end);

}  // namespace batten
