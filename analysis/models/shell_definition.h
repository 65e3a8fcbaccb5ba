// SPDX-License-Identifier: MPL-2.0
// Definition of a shell model: sections, supports and hinges.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/analysis/models/shell_loads.h"
#include "batten/analysis/models/shell_ties.h"
#include "batten/analysis/models/stiffeners.h"
#include "batten/analysis/shell_assembler.h"
#include "batten/core/geometry.h"

namespace batten {

// Elastic supports.

/// Elastic support by springs: at a point, per length of a curve, or per area (Winkler foundation).
struct ElasticSupport {
  std::string name;
  /// Location of a point support; unset: support along a curve or on an area.
  std::optional<ShellLocation> position;
  /// Name of the curve along which the support acts, in the box of `part`; empty: area support.
  std::string line;
  ShellPart part;
  /// Stiffness along x, y, z: force per displacement at a point, per length of a curve, or per
  /// area.
  Vec3 stiffness = Vec3::Zero();
  /// Stiffness per area along the surface normal (Winkler foundation); areas only.
  double normal = 0;
};

/// Adds the springs of an elastic support to `springs`. Throws InputError if a curve or region does
/// not exist, if a stiffness is negative or all are zero, or if the part contains no point of the
/// surface.
void add_elastic_support(const ModelLayout& model, const Points& shape,
                         const ElasticSupport& support, ShellSprings& springs);

// Rigid supports along curves, at points and on areas.

/// Cylindrical axes: the directions radial, hoop and axial at each point.
struct CylindricalAxes {
  Vec3 origin = Vec3::Zero(), axis = Vec3::UnitZ();  ///< a point of the axis, and its direction
  /// The directions radial, hoop and axial at x, as columns. Throws InputError on the axis.
  Mat3 at(const Vec3& x) const;
  /// Angle per length of a motion from x along the vector `along`.
  double turning(const Vec3& x, const Vec3& along) const;
};

/// Support along one curve: constrains the displacement in given directions, and optionally the
/// rotation about the curve.
///
///     clamped      directions x, y, z; rotation
///     pinned       directions x, y, z
///     symmetric    the normal of the plane; rotation (the surface meets the plane at right angles)
///     diaphragm    the two directions in the wall
struct LineSupport {
  std::string name;  ///< names the constraints of this support, and its reaction in the results
  std::string line;
  std::vector<Vec3> directions;      ///< constrained directions; any length except zero
  Vec3 displacement = Vec3::Zero();  ///< prescribed displacement along `directions`
  bool rotation = false;
  /// If set, only the part of the curve in this box is supported, by penalty springs.
  std::optional<Box3> box = {};
  /// If set, `directions` and `displacement` are components (radial, hoop, axial).
  std::optional<CylindricalAxes> axes = {};

  static LineSupport clamped(const std::string& line);
  static LineSupport pinned(const std::string& line);
  static LineSupport symmetric(const std::string& line, const Vec3& normal);
};

/// Adds the constraints and springs of a support along a curve to `ties`.
///
/// On a curve along element edges, displacements are constrained exactly on the whole curve, and
/// the rotation at vertices and edge midpoints. On an embedded curve, penalty springs are used, as
/// for ties. Only one region at the curve is supported; the others follow through their ties.
/// Throws InputError if the curve does not exist (the message suggests the closest name), a
/// direction has zero length, neither a direction nor the rotation is constrained, or the box
/// contains no part of the curve.
void add_support(const ModelLayout& model, const Points& shape,
                 const std::vector<ShellSection>& sections, const LineSupport& support,
                 ShellTies& ties);

/// Support at one point of the surface: constrains the displacement in given directions.
struct PointSupport {
  std::string name;
  ShellLocation position;
  std::vector<Vec3> directions;              ///< constrained directions; any length except zero
  Vec3 displacement = Vec3::Zero();          ///< prescribed displacement along `directions`
  std::optional<CylindricalAxes> axes = {};  ///< as LineSupport::axes
};

/// Support on a part of the surface: constrains the displacement in given directions, and thereby
/// the rotation. Penalty springs are used: their stiffness per area is that of springs along an
/// embedded curve (shell_ties()), divided by the length of an element edge.
struct AreaSupport {
  std::string name;
  ShellPart part;
  std::vector<Vec3> directions;              ///< constrained directions; any length except zero
  Vec3 displacement = Vec3::Zero();          ///< prescribed displacement along `directions`
  std::optional<CylindricalAxes> axes = {};  ///< as LineSupport::axes
};

/// A mass at a point of the surface.
struct PointMass {
  ShellLocation position;
  double mass = 0;
};

/// Complete definition of a shell, except its shape and its loads.
struct ShellDefinition {
  std::vector<ShellSection> sections;  ///< one for all regions, or one per region
  std::vector<LineSupport> lines;
  std::vector<PointSupport> points;
  std::vector<std::string> hinges;  ///< curves about which regions rotate freely
  std::vector<ElasticSupport> elastic = {};
  std::vector<AreaSupport> areas = {};
  /// Offset that is added to the thickness at each vertex of the model's mesh, linear in between;
  /// empty: no offsets.
  VecX nodal_thickness_offset = {};
  std::vector<Stiffener> stiffeners = {};
  std::vector<std::string> rigid_lines = {};  ///< curves that move as rigid bodies
  std::vector<PointMass> masses = {};
  /// The shell is free, and its loads are balanced (InertiaRelief). There are no other supports.
  bool inertia_relief = false;
};

/// Assigns sections to the triangles of a model. The result contains a single section for all
/// triangles if `definition` has one section and no thickness offsets, otherwise one section per
/// triangle of the model's mesh. Throws InputError if the number of sections is neither one nor the
/// number of regions, if there are thickness offsets but not one per vertex, or if a section is
/// invalid (require_section()).
std::vector<ShellSection> triangle_sections(const ModelLayout& model,
                                            const ShellDefinition& definition);

/// Creates all ties between regions and all supports of a shell. Throws InputError under the
/// conditions of add_support() and of the overload of shell_ties() in shell_ties.h. Also throws
/// InputError if a direction has zero length, a part contains no point of the surface, or a
/// stiffness is negative.
ShellTies shell_ties(const ModelLayout& model, const Points& shape,
                     const ShellDefinition& definition);

/// A stiffener that keeps a curve of a shell rigid: with the radius r of the curve (its length/2π), the
/// membrane stiffness A = A11 t and the bending stiffness D = D11 t³ of the stiffest section,
///
///     EA = α A r,   EI = GJ = α D r,   EI = α A r³ in the plane of the shell,   α = 100
///
/// The curve then deforms by about 1/α of what a free one does. Stiffer ones would stiffen the whole
/// elements that an embedded curve cuts: with EI = 1000 A r³, the moment on the rigid hole of a clamped
/// annulus turned it by up to 29 % too little, and with these values within 1.5 %.
Stiffener rigid_line(const ModelLayout& model, const std::vector<ShellSection>& sections,
                     const std::string& line);

/// Mass matrix of one coordinate (lower triangle, n×n): that of the shell (ShellAssembler::mass()), of
/// its stiffeners and of its point masses.
SparseMatrix mass_matrix(const ModelLayout& model, const Points& shape,
                         const ShellDefinition& definition, const ShellAssembler& assembler);
/// Mass of the stiffeners and point masses.
double added_mass(const ModelLayout& model, const Points& shape, const ShellDefinition& definition);
/// Load vector of an acceleration a(x) on shell, stiffeners and point masses.
Points body_load(const ModelLayout& model, const Points& shape, const ShellDefinition& definition,
                 const AccelerationField& acceleration);

/// Names of all supports, each listed once: the pieces of a curve that is split at corners form one
/// support.
std::vector<std::string> support_names(const ShellDefinition& definition);

}  // namespace batten
