// SPDX-License-Identifier: MPL-2.0
// Edit commands for curves, joins and faces of a scene.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/apps/documents/document_command.h"
#include "batten/apps/documents/document_view.h"
#include "batten/io/report/network_report.h"

namespace batten {

/// Name of the [[curve]] that defines a curve or a part of it between nodes ("rim.2"); empty: none.
std::string defining_line(const SceneText& scene, const std::string& name);

/// The key that holds the points of a [[curve]]. None: the curve is defined otherwise (file,
/// circle), so its points cannot be edited.
enum class LineKey {
  None,
  Points,  ///< the curve interpolates all of them
  Bezier,  ///< control points: the second and third define the end tangents
  Arc      ///< start, intermediate point, end
};
/// The point key of a [[curve]].
LineKey line_key(const SceneText& scene, const std::string& line);
/// The points of a [[curve]] as given in its scene; empty for LineKey::None.
std::vector<Vec3> defining_points(const SceneText& scene, const std::string& line);
/// Parses a TOML list of points; empty for anything else.
std::vector<Vec3> parse_points(const std::string& value);

/// Rounds a point to a millionth of the size: the precision of interactive input.
Vec3 rounded_point(const Vec3& p, double size);

/// Commands that create a curve through points, or replace the points of an existing curve.
DocumentCommand line_command(const std::string& name, const std::vector<Vec3>& points,
                             LineKey key = LineKey::Points);
DocumentCommand points_edit(const std::string& line, const std::vector<Vec3>& points,
                            LineKey key = LineKey::Points);
/// Converts a straight line between two points to a Bézier curve with editable tangents; empty for
/// other curves.
std::vector<DocumentCommand> tangent_edits(const SceneText& scene, const std::string& line);
/// The scene after `set` of a key of a curve. A curve has only one shape key, so setting another one
/// removes the previous key.
SceneText with_single_shape_key(SceneText scene, const SceneTable& table, const std::string& key,
                                const std::string& value);
/// Moves a point in all curves that contain it.
DocumentCommand move_point_command(const Vec3& from, const Vec3& to);
/// The scene after such a move; `from_to` is the command's text. Throws InputError unless there are
/// two positions and a curve contains the first one.
SceneText with_moved_point(SceneText scene, const std::string& from_to);
/// Splits a curve in two at one of its inner points (0-based).
std::vector<DocumentCommand> split_edits(const DocumentView& view, const std::string& line,
                                         int point);
/// Joins a curve with the adjacent one, which is merged into it. Empty unless exactly one other
/// editable curve ends at the same point.
std::vector<DocumentCommand> join_line_edits(const DocumentView& view, const std::string& line);
/// Adds a copy, mirrored in the plane through the origin perpendicular to an axis (0 to 2).
std::vector<DocumentCommand> mirror_edits(const DocumentView& view, const std::string& line,
                                          int axis);

// Edits of joins and faces.

/// Sets the continuity at a curve: "G0", "G1", "G2" or "smooth". Empty `continuity`:
/// automatic, as the adjacent surfaces determine. Existing entries of the curve in any [[join]]
/// are changed or removed.
std::vector<DocumentCommand> join_edits(const SceneText& scene, const std::string& line,
                                        const std::optional<std::string>& continuity);

/// Selects an alternative of an ambiguous decision. Adds a [[face]] for each of its loops that
/// does not exist yet, and suppresses surfaces in chosen loops that do not belong to the
/// alternative.
std::vector<DocumentCommand> alternative_edits(const NetworkReport::Choice& choice,
                                               int alternative);

}  // namespace batten
