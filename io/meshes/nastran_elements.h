// Elements and connections of Nastran decks that are no shells. Internal.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "batten/io/meshes/deck_mesh_builder.h"

namespace batten {

/// Whether cards of this name are elements or connections beside the shells.
bool is_non_shell_element(const std::string& name);

/// Adds such a card to a deck. `values`: those of all its lines. Cards whose nodes are not read are
/// counted only. Throws InputError, with its place: a node that is no number.
void add_non_shell_element(const std::string& name, std::span<const std::string_view> values,
                           const MeshSourceText& file, DeckMeshBuilder& deck);

}  // namespace batten
