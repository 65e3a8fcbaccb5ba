// Definition of a shell model: sections, supports and hinges.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/analysis/models/shell_loads.h"
#include "batten/analysis/models/shell_ties.h"
#include "batten/core/geometry.h"

namespace batten {

// Elastic supports.

/// Elastic support by springs: at a point, per length of a curve, or per area (Winkler foundation).
struct ElasticSupport {
  std::string name;
  std::optional<ShellLocation> position;  ///< for a point support
  std::string line;  ///< for a curve, as far as it lies in the part's box; empty: an area
  ShellPart part;
  /// Along x, y, z: force per displacement, or this per length or area.
  Vec3 stiffness = Vec3::Zero();
  double normal = 0;  ///< for an area: along its normal (elastic foundation)
};

/// Adds the springs of an elastic support to `springs`. Throws InputError if a curve or region does
/// not exist, if a stiffness is negative or all are zero, or if the part is empty.
void add_elastic_support(const ModelLayout& model, const Points& shape,
                         const ElasticSupport& support, ShellSprings& springs);

// Rigid supports along curves, at points and on areas.

/// Support along one curve: constrains the displacement in given directions, and optionally the
/// rotation about the curve.
///
///     clamped      directions x, y, z; rotation
///     pinned       directions x, y, z
///     symmetric    the normal of the plane; rotation (the surface meets the plane at right angles)
///     diaphragm    the two directions in the wall
struct LineSupport {
  std::string name;  ///< identifies its constraints
  std::string line;
  std::vector<Vec3> directions;      ///< of any length except zero
  Vec3 displacement = Vec3::Zero();  ///< prescribed, in those directions
  bool rotation = false;
  /// If set, only the part of the curve in this box is supported, by springs as for embedded
  /// curves.
  std::optional<Box3> box = {};

  static LineSupport clamped(const std::string& line);
  static LineSupport pinned(const std::string& line);
  static LineSupport symmetric(const std::string& line, const Vec3& normal);
};

/// Adds a support along a curve to shell_ties().
///
/// On a curve along element edges, displacements are constrained exactly on the whole curve, and
/// the rotation at vertices and edge midpoints. On an embedded curve, penalty springs are used, as
/// for ties. Other regions at the curve follow by their ties. Throws InputError if the curve does
/// not exist (names the closest match), a direction has zero length, nothing is constrained, or the
/// box contains nothing of the curve.
void add_support(const ModelLayout& model, const Points& shape,
                 const std::vector<ShellSection>& sections, const LineSupport& support,
                 ShellTies& ties);

/// Support at one point of the surface: constrains the displacement in given directions.
struct PointSupport {
  std::string name;
  ShellLocation position;
  std::vector<Vec3> directions;      ///< of any length except zero
  Vec3 displacement = Vec3::Zero();  ///< prescribed, in those directions
};

/// Support on a part of the area: constrains the displacement in given directions, and thereby the
/// rotation. It uses penalty springs: their stiffness per area is that of an embedded curve,
/// divided by the length of an element edge (shell_ties.h).
struct AreaSupport {
  std::string name;
  ShellPart part;
  std::vector<Vec3> directions;      ///< of any length except zero
  Vec3 displacement = Vec3::Zero();  ///< prescribed, in those directions
};

/// Complete definition of a shell, except its shape and its loads.
struct ShellDefinition {
  std::vector<ShellSection> sections;  ///< one for all, or one per region
  std::vector<LineSupport> lines;
  std::vector<PointSupport> points;
  std::vector<std::string> hinges;  ///< curves about which regions rotate freely
  std::vector<ElasticSupport> elastic = {};
  std::vector<AreaSupport> areas = {};
  /// Added to the thickness at each vertex of the model's mesh, linear in between; empty: nothing.
  VecX nodal_thickness_offset = {};
};

/// Sections of the triangles of a model: one for all, or one per triangle of its mesh. Throws
/// InputError if the number of sections or thickness offsets is wrong, or a section is invalid
/// (require_section()).
std::vector<ShellSection> triangle_sections(const ModelLayout& model,
                                            const ShellDefinition& definition);

/// All ties between regions, and all supports. Throws InputError as shell_ties() and add_support()
/// do, and if directions have zero length, parts are empty, or stiffness is negative.
ShellTies shell_ties(const ModelLayout& model, const Points& shape,
                     const ShellDefinition& definition);

/// Names of all supports, each once: pieces of a curve that is split at corners form one support.
std::vector<std::string> support_names(const ShellDefinition& definition);

}  // namespace batten
