#include "batten/apps/commands/lines/line_interpretation.h"

#include <algorithm>

#include "batten/core/format.h"
#include "batten/core/isize.h"

namespace batten {
namespace {

std::string numbers_of(const std::vector<int>& list) {
  constexpr size_t most = 8;
  std::string text;
  for (size_t i = 0; i < std::min(list.size(), most); ++i)
    text += (i ? ", " : "") + std::to_string(list[i]);
  return text + (list.size() > most ? ", …" : "");
}

}  // namespace

LineInterpretation interpret_points(const SourceLine& line, const InputCurve& curve) {
  const std::vector<Vec3>& p = line.points;
  const std::vector<double> t = curve.breaks(), corners = curve.corners();
  const int last = isize(p) - 1;
  LineInterpretation interpretation;
  interpretation.points = last + 1;
  interpretation.closed = (p.front() - p.back()).norm() < 1e-9 * curve.end();
  for (int i = interpretation.closed ? 0 : 1; i < last; ++i) {
    const double turning_angle =
        degrees_between(p[i] - p[i > 0 ? i - 1 : last - 1], p[i + 1] - p[i]);
    // The seam of a closed line is a corner where its tangents say so.
    const bool is_corner =
        i > 0 ? std::binary_search(corners.begin(), corners.end(), t[static_cast<size_t>(i)])
              : degrees_between(curve.evaluate(curve.end(), 1), curve.evaluate(curve.start(), 1)) >
                    0.01;
    if (is_corner) {
      interpretation.corners.push_back(i + 1);
      interpretation.corner_angles.push_back(turning_angle);
    } else {
      interpretation.max_smooth_angle = std::max(interpretation.max_smooth_angle, turning_angle);
    }
  }
  return interpretation;
}

std::string describe(const LineInterpretation& interpretation) {
  std::string text = std::to_string(interpretation.points) + " points";
  if (interpretation.closed) text += ", closed";
  if (!interpretation.corners.empty())
    text += (interpretation.corners.size() > 1 ? ", corners at " : ", a corner at ") +
            numbers_of(interpretation.corners);
  return text;
}

std::string reading_note(const SourceLine& line, const InputCurve& curve) {
  if (line.points.empty() || line.corners) return "";
  const LineInterpretation interpretation = interpret_points(line, curve);
  constexpr double large = 20, slight = 40;
  std::string text;
  if (interpretation.max_smooth_angle > large)
    text = std::to_string(interpretation.points) + " points that turn by up to " +
           format_number(interpretation.max_smooth_angle) + " degrees, taken as smooth";
  std::vector<int> weak;
  for (size_t i = 0; i < interpretation.corners.size(); ++i)
    if (interpretation.corner_angles[i] < slight) weak.push_back(interpretation.corners[i]);
  if (!weak.empty())
    text +=
        (text.empty() ? "" : "; ") +
        std::string(weak.size() > 1 ? "slight corners at points " : "a slight corner at point ") +
        numbers_of(weak);
  return text.empty() ? text : "'" + line.name + "': " + text;
}

}  // namespace batten
