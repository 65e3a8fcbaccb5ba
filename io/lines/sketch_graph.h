// Reads sketches of connected strokes from JSON files of strokes, segments and nodes.
#pragma once

#include <filesystem>
#include <vector>

#include "batten/skinning/lines/character_line.h"

namespace batten {

/// Reads the strokes of a sketch graph in the format of CASSIE [Yu2021]:
///
///     strokes   [{"id", "segments": [segment ids, along the stroke]}]
///     segments  [{"id", "stroke_id", "ctrl_pts": [pieces], "nodes": [2 node ids]}]
///     nodes     [{"id", "position", "neighbor_edges"}]
///
/// A piece has four control points of a cubic Bézier curve, or the two ends of a straight line.
/// Each stroke becomes one curve, "stroke 5", of exactly these pieces, with breaks between them.
/// Pieces of length zero, strokes without pieces and other keys are skipped. The nodes of the file
/// are not used, because in drawn sketches some are missing and some are superfluous; the curve
/// network detects its own.
///
/// Throws InputError, "file: segment 7: found X, expected Y": a missing file, invalid JSON, missing
/// or duplicate ids, points that are not three finite numbers, consecutive pieces with a gap of
/// more than 1e-6 of the sketch's size, no stroke.
/// not follow each other within 1e-6 of the sketch's size, no stroke.
std::vector<CharacterLine> read_sketch_graph(const std::filesystem::path& path);

}  // namespace batten
