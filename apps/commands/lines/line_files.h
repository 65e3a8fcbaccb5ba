// Reads the lines of a scene, from the scene itself and from files.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/fem/curves/hermite_curve.h"
#include "batten/io/scene/scene.h"

namespace batten {

/// The kind of a file of lines, which its extension says.
enum class LineFileKind { None, Points, Cad, Drawing, Sketch };
LineFileKind line_file_kind(const std::filesystem::path& file);

/// A line as it was given: points, or a curve.
struct SourceLine {
  std::string name;
  std::string at;                                ///< its place for messages: "FILE:LINE:COLUMN: "
  std::vector<Vec3> points;                      ///< model units; empty when there is a curve
  std::shared_ptr<const InputCurve> curve;       ///< set for lines that are not given by points
  std::optional<std::vector<int>> corners = {};  ///< of `points`, stated; not given: found
  std::string format_note = {};  ///< how its file was read, in words, where that is not obvious
  CharacterLine::Role role = CharacterLine::Role::Outline;
  CharacterLine::MeshAlignment mesh_alignment = CharacterLine::MeshAlignment::Auto;
  bool constrains_surface = true;

  /// The curve, or one through the points. Throws InputError as curve_through_points() does.
  std::shared_ptr<const InputCurve> as_curve(double corner_angle) const;
};

/// Reads all lines of a file, in model units. `unit` is that of a file of points ("": the model's)
/// or of a drawing ("": its own, where it states one). CAD files state their unit, and sketches are
/// in the model's. Throws InputError.
/// `creases`: of a CAD file also those inside of its faces.
std::vector<SourceLine> read_source_file(const std::filesystem::path& file, const std::string& unit,
                                         const std::string& model_unit, bool creases = false);

/// Reads all lines of a scene, in its order. `file` is the scene's, for messages. Throws InputError
/// with the place in the scene: a file that is missing or of an unknown kind, a file of several
/// lines where one was asked for, a name that its file does not have, a name that two lines have.
std::vector<SourceLine> read_sources(const std::vector<SceneLine>& lines,
                                     const std::filesystem::path& file, const std::string& unit);

/// Reads the points of a scan, all lines of its file one after the other, in model units; none for
/// other loads. Throws InputError with the place in the scene or in the file.
std::vector<Vec3> scan_points(const Scene& scene, const SceneLoad& load);

/// Reads the lines of a scene as curves, before any [[fair]]. Throws InputError.
std::vector<CharacterLine> read_lines(const Scene& scene);
/// The character line of a line as it was given. Throws InputError as as_curve().
CharacterLine character_line(const SourceLine& line, double corner_angle);

/// The points of a line in their order; the rest is known of a line that is given as a curve.
struct SampledLine {
  std::vector<Vec3> points;
  std::optional<std::vector<int>> corners;  ///< indices of the points at the curve's corners
  std::optional<bool> closed;               ///< whether the curve is closed
  std::vector<Vec3> extra_points;           ///< further points, to measure deviations

  bool has_length() const;
};

/// Samples a line. Points are kept as they are. A curve is sampled evenly by arc length in each of
/// its stretches between corners (where it turns by more than `corner_angle` degrees): about 200
/// points, or eight for each span of a spline. Throws InputError: a curve that is not finite.
SampledLine sample_line(const SourceLine& line, double corner_angle);

/// The parameters of the curve's points nearest to `points`. Each is looked for around its `guess`
/// (ascending). Those of points that go to and fro do too. O(points).
std::vector<double> nearest(const HermiteCurve& curve, const std::vector<Vec3>& points,
                            const std::vector<double>& guess);

/// The same, ascending in the order of `points`: none is before the one of an earlier point.
std::vector<double> closest_parameters_in_order(const HermiteCurve& curve,
                                                const std::vector<Vec3>& points,
                                                const std::vector<double>& guess);


// How lines that are given by points were read: corners, closedness.

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
