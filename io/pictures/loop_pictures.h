// Pictures of a network's lines, with surfaces that could be made in loops of them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/fem/hermite_curve.h"
#include "batten/io/pictures/image.h"

namespace batten {

/// One way to have surfaces: the loops that have one.
struct LoopAlternative {
  std::string title;
  /// The lines of each loop, one after the other, any way round.
  std::vector<std::vector<HermiteCurve>> loops;
  bool one_surface = false;  ///< the loops bound one surface, a ring or a hole, not one each
};

/// Panels side by side. The first shows all lines from afar, with all loops of all panels; then
/// follows one panel for each way, from near; loops that are nearly flat are seen at right angles.
struct LoopPicture {
  std::vector<HermiteCurve> lines;  ///< all lines of the network
  std::vector<LoopAlternative> alternatives;
  double azimuth = -30, elevation = 30;  ///< of the first panel, degrees as in PictureScene
};

/// Draws one PNG, which appears whole or not at all: the loops' lines as tubes, a sheet in each
/// loop in a colour of its own (a fan around its middle; a band between the two loops of one
/// surface: no surfaces of Batten), other lines thin.
/// To be called on the main thread. Throws InputError: no display, no way, ways without a loop, a
/// file that cannot be written.
void draw_loops(const std::filesystem::path& path, const LoopPicture& picture);

}  // namespace batten
