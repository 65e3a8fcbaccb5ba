// Edits of lines that a scene states by their points, as commands on its document.
#pragma once

#include <string>
#include <vector>

#include "batten/apps/commands/documents/document_command.h"
#include "batten/apps/commands/documents/document_view.h"

namespace batten {

/// The [[line]] that a name of a line or of its piece between nodes ("rim.2") means; "" for none.
std::string stated_line(const SceneText& scene, const std::string& name);

/// The points of a [[line]] as its scene states them; none where it is stated otherwise (a file, an
/// arc), for those cannot be moved one by one.
std::vector<Vec3> stated_points(const SceneText& scene, const std::string& line);

/// A point as words, with no more digits than a hand can mean in a shape of this size: a millionth.
std::string point_word(const Vec3& p);
Vec3 rounded_point(const Vec3& p, double size);

/// A line through points, as a new one or in the place of its points.
DocumentCommand line_command(const std::string& name, const std::vector<Vec3>& points);
DocumentCommand points_edit(const std::string& line, const std::vector<Vec3>& points);
/// Moves a point of all lines that have it.
DocumentCommand move_command(const Vec3& from, const Vec3& to);
/// The scene after such a command's text. Throws InputError: not two places, no line that has the
/// first.
SceneText with_moved_point(SceneText scene, const std::string& places);
/// Two lines instead of one, which meet at one of its inner points (counted from 0).
std::vector<DocumentCommand> split_edits(const DocumentView& view, const std::string& line,
                                         int point);
/// One line instead of two that share an end: the other line is taken into this one. None where no
/// other stated line ends where this one does, or several do.
std::vector<DocumentCommand> join_line_edits(const DocumentView& view, const std::string& line);
/// A copy on the other side of a plane through the origin whose normal is an axis (0 to 2).
std::vector<DocumentCommand> mirror_edits(const DocumentView& view, const std::string& line,
                                          int axis);

}  // namespace batten
