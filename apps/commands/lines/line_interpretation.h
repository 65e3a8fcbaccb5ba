// How lines that are given by points were read: corners, closedness.
#pragma once

#include <string>
#include <vector>

#include "batten/apps/commands/lines/line_files.h"

namespace batten {

struct LineInterpretation {
  int points = 0;
  std::vector<int> corners;           ///< numbers of points, from 1
  std::vector<double> corner_angles;  ///< degrees from chord to chord there
  bool closed = false;
  double max_smooth_angle = 0;  ///< largest turn at a point that is no corner, degrees
};

/// Of a line that is given by points; `curve`: what SourceLine::as_curve() made of it.
LineInterpretation interpret_points(const SourceLine& line, const InputCurve& curve);

/// In words: "49 points, closed, corners at 3, 7".
std::string describe(const LineInterpretation& interpretation);
/// What a person may not expect, in words: large turns that are no corners, slight ones that are.
/// "" where there is nothing of the kind, or where corners are stated.
std::string reading_note(const SourceLine& line, const InputCurve& curve);

}  // namespace batten
