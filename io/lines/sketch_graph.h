// Reads sketches of connected strokes: JSON files of strokes, segments and nodes.
#pragma once

#include <filesystem>
#include <vector>

#include "batten/skinning/lines/character_line.h"

namespace batten {

/// Reads the strokes of a sketch graph as CASSIE writes it (Yu, Arora, Stanko, Bærentzen, Singh,
/// Bousseau 2021):
///
///     strokes   [{"id", "segments": [segment ids, along the stroke]}]
///     segments  [{"id", "stroke_id", "ctrl_pts": [pieces], "nodes": [2 node ids]}]
///     nodes     [{"id", "position", "neighbor_edges"}]
///
/// A piece has four control points of a cubic Bézier, or the two ends of a straight piece. Each
/// stroke becomes one line, "stroke 5", of exactly these pieces, with breaks between them. Pieces
/// without length, strokes without pieces and other keys are passed over. The nodes of the file are
/// not used, because drawn sketches lack some and have some too many: a network finds its own.
///
/// Throws InputError, "file: segment 7: found X, expected Y": a file that is missing or no such
/// JSON, ids that are missing or doubled, points that are not three finite numbers, pieces that do
/// not follow each other within 1e-6 of the sketch's size, no stroke.
std::vector<CharacterLine> read_sketch_graph(const std::filesystem::path& path);

}  // namespace batten
