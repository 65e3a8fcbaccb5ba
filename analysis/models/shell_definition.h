// What a shell is made of and how it is held.
#pragma once

#include <string>
#include <vector>

#include "batten/analysis/models/elastic_supports.h"
#include "batten/analysis/models/line_supports.h"
#include "batten/analysis/models/shell_loads.h"

namespace batten {

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
