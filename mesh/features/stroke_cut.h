// Separating a form feature by two strokes of the mouse: one on it, one beside it.
#pragma once

#include <vector>

#include "batten/mesh/features/feature_cut.h"

namespace batten {

/// The cheapest set of edges between two strokes, at the price of edges of cut_feature(): the mean
/// bend is over all edges of that part of the mesh. Triangles that touch `inside` are the feature's,
/// those that touch `outside` are not; of several cheapest cuts the one nearest to the inside is
/// taken. It works on closed solids as on panels.
///
/// Strokes: vertices, in any order. `feature_vertex` of the options is not looked at. Throws
/// InputError: a stroke that is empty or out of range, strokes that touch each other (it says at
/// which vertex or triangle), that lie in different parts of the mesh, η that are negative or not
/// finite.
///
/// O(mesh) and the maximum flow between the strokes, which may grow with the square of the number
/// of triangles where nothing bends.
FeatureCut stroke_cut(const TriangleMesh& mesh, const std::vector<int>& inside,
                      const std::vector<int>& outside, const CutOptions& options = {});

}  // namespace batten
