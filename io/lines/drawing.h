// The lines of a drawing.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/fairing/input_curve.h"

namespace batten {

/// One line of a drawing.
struct DrawnLine {
  std::string name;          ///< unique in the file
  std::vector<Vec3> points;  ///< of a polyline, in the drawing's numbers; else there is a curve
  std::shared_ptr<const InputCurve> curve = {};
};

struct Drawing {
  std::vector<DrawnLine> lines;
  double unit_in_metres = 0;       ///< 0: the file does not say
  std::vector<std::string> notes;  ///< what was passed over, in words
};

}  // namespace batten
