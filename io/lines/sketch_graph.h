// Sketches of connected strokes: JSON files of strokes, segments and nodes.
#pragma once

#include <filesystem>
#include <vector>

#include "batten/skinning/lines/character_line.h"

namespace batten {

/// The strokes of a sketch graph as CASSIE writes it (Yu, Arora, Stanko, Bærentzen, Singh,
/// Bousseau 2021):
///
///     strokes   [{"id", "segments": [segment ids, along the stroke]}]
///     segments  [{"id", "stroke_id", "ctrl_pts": [pieces], "nodes": [2 node ids]}]
///     nodes     [{"id", "position", "neighbor_edges"}]
///
/// A piece has four control points of a cubic Bézier, or two of a straight piece. Each stroke
/// becomes one line, "stroke 5", with breaks between its pieces, each piece exactly as it is;
/// pieces without length are passed over, strokes without any too. The nodes of the file are not
/// used: who drew left some out and has some too many, so a network finds its own.
///
/// Throws InputError, "file: segment 7: found X, expected Y": a file that is missing or no such
/// JSON, ids that are missing or doubled, points that are no three finite numbers, pieces that do
/// not follow each other within 1e-6 of the sketch's size, no stroke. Other keys are passed over.
std::vector<CharacterLine> read_sketch_graph(const std::filesystem::path& path);

}  // namespace batten
