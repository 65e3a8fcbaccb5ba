// How near a fitted face comes to its surface, and how large it may become.
#pragma once

#include <string>

namespace batten {

struct StepFaceOptions {
  double tolerance = 0;          ///< of the surface, in model units; > 0
  std::string name = "surface";  ///< of the product
  std::string author = "";
  int most_poles = 400;            ///< in one direction, 16 or more
  int most_poles_in_all = 60'000;  ///< of one face, 256 or more: about 6 MB
};

}  // namespace batten
