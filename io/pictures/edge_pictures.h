// Pictures of how faces bend across their edges.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/io/pictures/image.h"

namespace batten {

/// An edge between two faces: points along it, and at each of them the normal curvature across the
/// edge times the unit normal, of both faces.
struct EdgeComb {
  enum class Kind { Crease, Tangent, Curvature } kind = Kind::Crease;
  std::vector<Vec3> line;
  std::array<std::vector<Vec3>, 2> curvature_vectors;
};

struct EdgePicture {
  std::string title, unit;
  std::vector<EdgeComb> edges;
  std::vector<std::vector<Vec3>> free_edges;  ///< edges with one face
  /// Azimuth and elevation of the camera, in degrees as in PictureScene.
  std::pair<double, double> view{30, 25};
};

/// Draws one PNG, which appears whole or not at all. From each edge two combs stand out, away from
/// the centres of curvature, one for either face: where curvature goes on they are one, where it
/// jumps their tips are apart. Their colour tells creases, tangent edges and edges of one curvature
/// apart; the legend counts them. The curvature that 95 % of the teeth do not exceed is a tenth of
/// the model's size; longer teeth are cut at 1.5 times that. To be called on the main thread; needs
/// a display (require_display). Throws InputError: no display, nothing to draw, a file that cannot be
/// written.
void draw_edge_combs(const std::filesystem::path& path, const EdgePicture& picture,
                     const PictureSize& size = {1600, 1200});

}  // namespace batten
