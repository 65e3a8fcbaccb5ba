// SPDX-License-Identifier: MPL-2.0
// Reads the lines of a scene, from the scene itself and from files.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/fairing/curves/staged_fairing.h"
#include "batten/io/scene/scene.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

/// Kind of a curve file, determined by its extension.
enum class LineFileKind { None, Points, Cad, Drawing, Sketch };
LineFileKind line_file_kind(const std::filesystem::path& file);

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

/// Reads all lines of a file, in model units.
///
/// `unit`: unit of a point file (empty: the model's) or of a drawing (empty: its own, if it states
/// one). CAD files state their unit, and sketches are in the model's unit. `creases`: for CAD
/// files, also read the creases inside faces. Throws InputError.
std::vector<SourceLine> read_source_file(const std::filesystem::path& file, const std::string& unit,
                                         const std::string& model_unit, bool creases = false);

/// The note that only the edges of a CAD file's faces are read, and not the faces.
std::string cad_faces_note(const std::filesystem::path& file, int faces);

/// Reads the lines of a list, in order. `file`: the scene, for messages. Throws InputError, with
/// the location in the scene, for a missing file or an unknown kind. Also throws it for a file with
/// several lines where one is expected, a name that the file does not have, and duplicate names.
/// Names that occur in several files are preceded by the name of the file: "wing: edge 1".
std::vector<SourceLine> read_sources(const std::vector<SceneLine>& lines,
                                     const std::filesystem::path& file, const std::string& unit);
/// Reads all lines of the surface of a scene, with the corners at crossings
/// (find_crossing_corners()). Throws InputError.
std::vector<SourceLine> read_sources(const Scene& scene);

/// Reads the points of a scan, from all lines of its file, in model units; empty for other loads.
/// Throws InputError with the location in the scene or in the file.
std::vector<Vec3> scan_points(const Scene& scene, const SceneLoad& load);

/// Reads the lines of a scene as curves, without applying [[fair]]. Throws InputError.
std::vector<CharacterLine> read_lines(const Scene& scene);
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
