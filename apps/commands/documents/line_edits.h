// Edits of lines that a scene states by their points, as commands on its document.
#pragma once

#include <string>
#include <vector>
#include <optional>

#include "batten/apps/commands/documents/document_command.h"
#include "batten/apps/commands/documents/document_view.h"
#include "batten/io/report/network_report.h"

namespace batten {

/// The [[line]] that a name of a line or of its piece between nodes ("rim.2") means; "" for none.
std::string defining_line(const SceneText& scene, const std::string& name);

/// The points of a [[line]] as its scene states them, by the key that has them; none where it is stated
/// otherwise (a file, a circle), for those cannot be moved one by one.
enum class LineKey {
  None,
  Points,  ///< the curve goes through all of them
  Bezier,  ///< control points: the second and the third say the tangents at the ends
  Arc      ///< start, a point between, end
};
LineKey line_key(const SceneText& scene, const std::string& line);
std::vector<Vec3> defining_points(const SceneText& scene, const std::string& line);
/// The points of a list as TOML writes it; none of anything else.
std::vector<Vec3> parse_points(const std::string& value);

/// A point as words, with no more digits than a hand can mean in a shape of this size: a millionth.
std::string point_to_toml(const Vec3& p);
Vec3 rounded_point(const Vec3& p, double size);

/// A line through points, as a new one or in the place of its points.
DocumentCommand line_command(const std::string& name, const std::vector<Vec3>& points,
                             LineKey key = LineKey::Points);
DocumentCommand points_edit(const std::string& line, const std::vector<Vec3>& points,
                            LineKey key = LineKey::Points);
/// A straight line between two points with tangents that a hand can move; none of other lines.
std::vector<DocumentCommand> tangent_edits(const SceneText& scene, const std::string& line);
/// The scene after `set` of a key of a line: of what says its shape a line has one key, so that the one
/// before goes.
SceneText with_single_shape_key(SceneText scene, const SceneTable& table, const std::string& key,
                                const std::string& value);
/// Moves a point of all lines that have it.
DocumentCommand move_point_command(const Vec3& from, const Vec3& to);
/// The scene after such a command's text. Throws InputError: not two places, no line that has the
/// first.
SceneText with_moved_point(SceneText scene, const std::string& from_to);
/// Two lines instead of one, which meet at one of its inner points (counted from 0).
std::vector<DocumentCommand> split_edits(const DocumentView& view, const std::string& line,
                                         int point);
/// One line instead of two that share an end: the other line is taken into this one. None where no
/// other stated line ends where this one does, or several do.
std::vector<DocumentCommand> join_line_edits(const DocumentView& view, const std::string& line);
/// A copy on the other side of a plane through the origin whose normal is an axis (0 to 2).
std::vector<DocumentCommand> mirror_edits(const DocumentView& view, const std::string& line,
                                          int axis);


// Edits of a scene's words about lines and regions, as commands on its document.

/// What makes a line a crease or smooth ("crease", "smooth", "tangent", "curvature"), or, without a
/// word, what the surfaces at it say: the words about it in any [[join]] are changed or taken out.
std::vector<DocumentCommand> join_edits(const SceneText& scene, const std::string& line,
                                        const std::optional<std::string>& kind);

/// What asks for one of the alternatives of a choice: a [[region]] for each loop that is not there yet,
/// and no surface in loops that were chosen and are not among them.
std::vector<DocumentCommand> alternative_edits(const NetworkReport::Choice& choice,
                                               int alternative);

}  // namespace batten
