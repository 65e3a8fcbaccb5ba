#include "batten/apps/commands/lines/line_reading.h"

#include <algorithm>

#include "batten/core/index.h"
#include "batten/core/words.h"

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

LineReading reading_of(const SourceLine& line, const InputCurve& curve) {
  const std::vector<Vec3>& p = line.points;
  const std::vector<double> t = curve.breaks(), corners = curve.corners();
  const int last = count_of(p) - 1;
  LineReading reading;
  reading.points = last + 1;
  reading.closed = (p.front() - p.back()).norm() < 1e-9 * curve.end();
  for (int i = reading.closed ? 0 : 1; i < last; ++i) {
    const double turn = degrees_between(p[i] - p[i > 0 ? i - 1 : last - 1], p[i + 1] - p[i]);
    // The seam of a closed line is a corner where its tangents say so.
    const bool is_corner =
        i > 0 ? std::binary_search(corners.begin(), corners.end(), t[static_cast<size_t>(i)])
              : degrees_between(curve.evaluate(curve.end(), 1), curve.evaluate(curve.start(), 1)) >
                    0.01;
    if (is_corner) {
      reading.corners.push_back(i + 1);
      reading.corner_turns.push_back(turn);
    } else {
      reading.smooth_turn = std::max(reading.smooth_turn, turn);
    }
  }
  return reading;
}

std::string words_of(const LineReading& reading) {
  std::string text = std::to_string(reading.points) + " points";
  if (reading.closed) text += ", closed";
  if (!reading.corners.empty())
    text += (reading.corners.size() > 1 ? ", corners at " : ", a corner at ") +
            numbers_of(reading.corners);
  return text;
}

std::string surprise(const SourceLine& line, const InputCurve& curve) {
  if (line.points.empty() || line.corners) return "";
  const LineReading reading = reading_of(line, curve);
  constexpr double large = 20, slight = 40;
  std::string text;
  if (reading.smooth_turn > large)
    text = std::to_string(reading.points) + " points that turn by up to " +
           number(reading.smooth_turn) + " degrees, taken as smooth";
  std::vector<int> weak;
  for (size_t i = 0; i < reading.corners.size(); ++i)
    if (reading.corner_turns[i] < slight) weak.push_back(reading.corners[i]);
  if (!weak.empty())
    text +=
        (text.empty() ? "" : "; ") +
        std::string(weak.size() > 1 ? "slight corners at points " : "a slight corner at point ") +
        numbers_of(weak);
  return text.empty() ? text : "'" + line.name + "': " + text;
}

}  // namespace batten
