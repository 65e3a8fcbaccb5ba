// Supports of a shell along the lines of its model.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/analysis/models/shell_ties.h"
#include "batten/core/box.h"

namespace batten {

/// What holds a shell along one line: the displacement in some directions, the rotation about the
/// line.
///
///     clamped      directions x, y, z; rotation
///     pinned       directions x, y, z
///     symmetric    the normal of the plane; rotation (the surface meets the plane at right angles)
///     diaphragm    the two directions in the wall
struct LineSupport {
  std::string name;  ///< of its rows
  std::string line;
  std::vector<Vec3> directions;      ///< any length but zero
  Vec3 displacement = Vec3::Zero();  ///< of the line, in those directions
  bool rotation = false;
  /// What of the line lies in it only, held by springs, as embedded lines are.
  std::optional<Box3> box = {};

  static LineSupport clamped(const std::string& line);
  static LineSupport pinned(const std::string& line);
  static LineSupport symmetric(const std::string& line, const Vec3& normal);
};

/// Adds a support to shell_ties(). On a run it is rows, which hold everywhere in its directions, and
/// the rotation at vertices and in the middles of edges; on an embedded line it is springs, as ties
/// are. Other regions of the line follow by their ties. Throws InputError: no such line (with the
/// nearest name), a direction of length zero, nothing to hold, a box that holds nothing of it.
void add_support(const ModelLayout& model, const Points& shape,
                 const std::vector<ShellSection>& sections, const LineSupport& support,
                 ShellTies& ties);

}  // namespace batten
