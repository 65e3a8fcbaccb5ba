// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/lines/source_line.h"

#include <algorithm>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/scenes/lines/line_corners.h"

namespace batten {

CurveSamples sample_line(const SourceLine& line, double corner_angle) {
  CurveSamples samples;
  if (line.curve)
    samples = sample_line(CharacterLine{line.name, line.curve}, corner_angle);
  else {
    samples.points = line.points;
    samples.corners = line.corners;
  }
  samples.name = line.name;
  samples.where = line.at;
  return samples;
}

namespace {

/// The points that turn by more than `corner_angle`.
std::vector<int> turns_above(const std::vector<Vec3>& points, double corner_angle) {
  std::vector<int> corners;
  for (const int i : all_corners(points)) {
    const Vec3& before = points[i > 0 ? i - 1 : isize(points) - 2];
    if (degrees_between(points[i] - before, points[i + 1] - points[i]) > corner_angle)
      corners.push_back(i);
  }
  return corners;
}

}  // namespace

std::optional<std::vector<int>> SourceLine::known_corners(double corner_angle) const {
  if (corners) return corners;
  if (vertices == Vertices::Polyline) return all_corners(points);
  if (corner_angle_is_stated) return turns_above(points, corner_angle);
  if (crossing_corners.empty()) return std::nullopt;
  std::vector<int> known = crossing_corners;
  const auto by_angles = curve_through_points(name, points, corner_angle);
  for (const int i : interpret_points(*this, *by_angles).corners) known.push_back(i - 1);
  return sorted_unique(std::move(known));
}

std::shared_ptr<const InputCurve> SourceLine::as_curve(double corner_angle) const {
  if (curve) return curve;
  try {
    const auto known = known_corners(corner_angle);
    auto through = curve_through_points(name, points, corner_angle, known);
    const bool seam = known && std::find(known->begin(), known->end(), 0) != known->end() &&
                      (points.front() - points.back()).norm() < 1e-9 * through->end();
    return seam ? with_corner_at_seam(std::move(through)) : through;
  } catch (const InputError& e) {
    throw InputError(at + e.what());
  }
}

CharacterLine character_line(const SourceLine& line, double corner_angle) {
  return {line.name, line.as_curve(corner_angle), line.role, line.mesh_alignment,
          {},        line.constrains_surface};
}

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
    // The seam of a closed line is a corner if its tangents differ there.
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
  if (line.vertices == SourceLine::Vertices::Polyline) return "";
  if (line.vertices == SourceLine::Vertices::SampledCurve)
    return "'" + line.name + "': a polyline of " + std::to_string(line.points.size() - 1) +
           " segments, interpreted as points of a smooth curve, which is up to " +
           format_number(line.polyline_deviation) +
           " away from it (corners = \"all\" keeps straight segments)";
  const LineInterpretation interpretation = interpret_points(line, curve);
  constexpr double large = 20, slight = 40;
  std::string text;
  if (interpretation.max_smooth_angle > large)
    text = std::to_string(interpretation.points) + " points, where the curve turns by up to " +
           format_number(interpretation.max_smooth_angle) + " degrees, interpreted as smooth";
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
