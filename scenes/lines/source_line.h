// SPDX-License-Identifier: MPL-2.0
// A line of a scene as it is given: points, or a curve, with the interpretation of its points.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/fairing/curves/staged_fairing.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

/// A line as given: points, or a curve.
struct SourceLine {
  std::string name;
  std::string at;                           ///< location for messages: "FILE:LINE:COLUMN: "
  std::vector<Vec3> points;                 ///< model units; empty if `curve` is set
  std::shared_ptr<const InputCurve> curve;  ///< set for lines that are not given by points
  /// Given corners, indices of `points`; empty: detected.
  std::optional<std::vector<int>> corners = {};
  /// What `points` are, unless `corners` is given.
  enum class Vertices {
    Points,        ///< points of a curve: corners are detected
    Polyline,      ///< vertices of a polyline of a drawing or CAD file: all are corners
    SampledCurve,  ///< vertices of such a polyline, which samples a smooth curve: as points
    Measured       ///< vertices of such a polyline, which is to be read as points
  } vertices = Vertices::Points;
  double polyline_deviation = 0;  ///< SampledCurve: largest distance of the curve from the polyline
  /// Further corners, where other lines cross (find_crossing_corners()); indices of `points`.
  std::vector<int> crossing_corners = {};
  /// True: all points that turn by more than the corner angle are corners, since it was stated.
  bool corner_angle_is_stated = false;
  std::string format_note = {};  ///< how the file was interpreted, if that is not obvious
  /// About entities of the file that were not read; set at the first of its lines.
  std::vector<std::string> notes = {}, warnings = {};
  CharacterLine::Role role = CharacterLine::Role::Outline;
  CharacterLine::MeshAlignment mesh_alignment = CharacterLine::MeshAlignment::Auto;
  bool constrains_surface = true;

  /// The corners of `points` that do not follow from their turning angles alone: those given, those
  /// of a polyline, those of a stated corner angle, and those at crossings together with all others.
  /// Empty: all corners are detected.
  std::optional<std::vector<int>> known_corners(double corner_angle) const;
  /// The curve, or one through the points. Throws InputError like curve_through_points().
  std::shared_ptr<const InputCurve> as_curve(double corner_angle) const;
};

/// Converts a line to a character line. Throws InputError like as_curve().
CharacterLine character_line(const SourceLine& line, double corner_angle);

/// Samples a line for fairing. Given points are used unchanged; a curve is sampled as by
/// sample_line() of skinning/lines/line_samples.h, which throws InputError.
CurveSamples sample_line(const SourceLine& line, double corner_angle);

// Interpretation of point lists: corners, closedness.

/// How a line given by points was interpreted.
struct LineInterpretation {
  int points = 0;
  std::vector<int> corners;           ///< 1-based point numbers
  std::vector<double> corner_angles;  ///< angles between adjacent chords there, degrees
  bool closed = false;
  double max_smooth_angle = 0;  ///< largest angle at a point that is no corner, degrees
};

/// Interprets a line given by points; `curve`: result of SourceLine::as_curve().
LineInterpretation interpret_points(const SourceLine& line, const InputCurve& curve);

/// Text such as "49 points, closed, corners at 3, 7".
std::string describe(const LineInterpretation& interpretation);
/// A remark on interpretations that may surprise: large angles that are no corners, small ones that
/// are. Empty if there are none, or if the corners are given.
std::string reading_note(const SourceLine& line, const InputCurve& curve);

}  // namespace batten
