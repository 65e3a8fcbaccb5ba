// What a shell is made of and how it is held.
#pragma once

#include <string>
#include <vector>
#include <optional>

#include "batten/analysis/models/shell_loads.h"
#include "batten/analysis/models/shell_ties.h"
#include "batten/core/geometry.h"

namespace batten {

// Springs that hold a shell.

/// Springs that hold a shell at a place, per length of a line or per area of a part.
struct ElasticSupport {
  std::string name;
  std::optional<ShellLocation> position;  ///< of a point; else
  std::string line;  ///< of a line, as far as it lies in the part's box; "": an area
  ShellPart part;
  Vec3 stiffness = Vec3::Zero();  ///< along x, y, z: force over displacement, or per length or area
  double normal = 0;              ///< of an area: along its normal (an elastic foundation)
};

/// Adds its springs. Throws InputError: no such line or region, stiffness below 0 or none, a part that
/// holds nothing.
void add_elastic_support(const ModelLayout& model, const Points& shape,
                         const ElasticSupport& support, ShellSprings& springs);


// Supports of a shell along the lines of its model.

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


/// What holds a shell at one place of its surface: the displacement in some directions.
struct PointSupport {
  std::string name;
  ShellLocation position;
  std::vector<Vec3> directions;      ///< any length but zero
  Vec3 displacement = Vec3::Zero();  ///< in those directions
};

/// What holds a part of a shell's area: the displacement in some directions, and so the rotation. By
/// stiff springs, per area those of an embedded line over the length of an edge (shell_ties.h).
struct AreaSupport {
  std::string name;
  ShellPart part;
  std::vector<Vec3> directions;      ///< any length but zero
  Vec3 displacement = Vec3::Zero();  ///< in those directions
};

/// All of a shell but its shape and its loads.
struct ShellDefinition {
  std::vector<ShellSection> sections;  ///< one, or one for each region
  std::vector<LineSupport> lines;
  std::vector<PointSupport> points;
  std::vector<std::string> hinges;  ///< lines about which regions turn freely
  std::vector<ElasticSupport> elastic = {};
  std::vector<AreaSupport> areas = {};
  /// Added to the thickness at each vertex of the model's mesh, linear between them; none: nothing.
  VecX nodal_thickness_offset = {};
};

/// The sections of a model: one, or one for each triangle of its mesh. Throws InputError: sections or
/// thicknesses of another number, what require_section() throws.
std::vector<ShellSection> triangle_sections(const ModelLayout& model,
                                            const ShellDefinition& definition);

/// Everything that ties regions to each other and holds them. Throws InputError: what shell_ties() and
/// add_support() throw, directions of length zero, parts that hold nothing, negative stiffness.
ShellTies shell_ties(const ModelLayout& model, const Points& shape,
                     const ShellDefinition& definition);

/// Names of the supports, each once: the parts of a line that is cut at corners are one support.
std::vector<std::string> support_names(const ShellDefinition& definition);

}  // namespace batten
