// Describes deforming meshes in a few lines of text.
#pragma once

#include <filesystem>
#include <string>

#include "batten/io/scene/sequence_scene.h"

namespace batten {

/// Whether a file holds many frames by its ending: .glb .gltf .pc2 .mdd .pvd .frd.
bool is_sequence_file(const std::filesystem::path& file);

/// Frames, times, nodes, the box around all frames, parts, how far nodes move from frame to frame,
/// jerks, and whether the last frame is the first one again. Throws InputError.
std::string sequence_info(const SequenceSource& source, const std::string& unit);

/// The same of a scene's sequence, its handles and features, and its steps.
std::string sequence_info(const SequenceScene& scene);

}  // namespace batten
