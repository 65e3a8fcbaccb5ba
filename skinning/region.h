// A skinned region: one C1 surface and the lines it hangs on.
#pragma once

#include <string>
#include <vector>

#include "batten/fem/curve.h"
#include "batten/fem/surface.h"
#include "batten/skinning/character_line.h"

namespace batten {

/// One character line as the surface carries it: a chain of element edges along a straight run of
/// the domain, on which the surface is exactly the fitted curve.
struct LineRun {
  CharacterLine line;              ///< as the user gave it
  HermiteCurve fitted;             ///< the C1 cubic curve that the surface interpolates
  std::vector<int> vertices;       ///< mesh vertices from the line's start to its end
  std::vector<double> parameters;  ///< of `fitted`, at each of these vertices
  std::vector<int> edges;          ///< mesh edges between them
};

struct SkinnedRegion {
  std::string name;
  Surface surface;
  std::vector<LineRun> runs;
  double size = 1;  ///< length scale of the region in model units: diagonal of its lines' box
};

}  // namespace batten
