// The lines of a scene, from wherever they are.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/fem/curve.h"
#include "batten/io/scene/scene.h"

namespace batten {

/// How a file of lines is read, by its extension.
enum class LineFileKind { None, Points, Cad, Sketch };
LineFileKind line_file_kind(const std::filesystem::path& file);

/// A line as it was given: points, or a curve.
struct SourceLine {
  std::string name;
  std::string at;                           ///< "FILE:LINE:COLUMN: ", for messages
  std::vector<Vec3> points;                 ///< model units; empty when there is a curve
  std::shared_ptr<const InputCurve> curve;  ///< of CAD files and Béziers
  CharacterLine::Role role = CharacterLine::Role::Outline;
  CharacterLine::Treatment treatment = CharacterLine::Treatment::Auto;

  /// The curve, or the one through the points. Throws InputError: curve_through_points.
  std::shared_ptr<const InputCurve> as_curve(double corner_angle) const;
};

/// All lines of a file, in model units. `unit`: of the file's numbers, for files of points ("": the
/// model's); files of CAD say it themselves, those of sketches are in the model's. Throws
/// InputError.
std::vector<SourceLine> read_source_file(const std::filesystem::path& file, const std::string& unit,
                                         const std::string& model_unit);

/// All lines of a scene in its order; `file` is the scene's, for messages. Throws InputError with
/// the place in the scene: a file that is missing or of an unknown kind, a file of several lines
/// where one was asked for, a name that its file does not have, a name that two lines have.
std::vector<SourceLine> read_sources(const std::vector<SceneLine>& lines,
                                     const std::filesystem::path& file, const std::string& unit);

/// The points of a scan, all lines of its file one after the other, in model units; none
/// for other loads. Throws InputError with the place in the scene or in the file.
std::vector<Vec3> scan_points(const Scene& scene, const SceneLoad& load);

/// The lines of a scene as curves, before any [[fair]]. Throws InputError.
std::vector<CharacterLine> read_lines(const Scene& scene);
CharacterLine character_line(const SourceLine& line, double corner_angle);

/// A line as points in their order, whatever it was given as.
struct SampledLine {
  std::vector<Vec3> points;
  std::optional<std::vector<int>> corners;  ///< of a curve: its own
  std::optional<bool> closed;               ///< of a curve: whether it comes back
  std::vector<Vec3> between;                ///< of a curve: further points of it, to measure by

  bool has_length() const;
};

/// Points as they are. A curve is sampled evenly by arc length in each of its stretches between
/// corners (where it turns by more than `corner_angle` degrees): about 200 points, or eight for
/// each span of a spline. Throws InputError: a curve that is not finite.
SampledLine sampled(const SourceLine& line, double corner_angle);

/// Parameters of the nearest points of the curve, in the order of the points: each is looked for
/// around `guess` (ascending). O(points).
std::vector<double> nearest_in_order(const HermiteCurve& curve, const std::vector<Vec3>& points,
                                     const std::vector<double>& guess);

}  // namespace batten
