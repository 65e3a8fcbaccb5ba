// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/shell_definition.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <utility>

#include "batten/analysis/models/line_sides.h"
#include "batten/analysis/models/part_quadrature.h"
#include "batten/analysis/models/vertex_constraints.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

// The directions of a support at a point, in space.
Mat3 frame_at(const std::optional<CylindricalAxes>& axes, const Vec3& x) {
  return axes ? axes->at(x) : Mat3::Identity();
}

void add_point_support(const ModelLayout& model, const Points& shape, const PointSupport& support,
                       ConstraintSet& set) {
  const ConstraintEntries position = shape_functions_at(model, support.position.where);
  const Mat3 frame = frame_at(support.axes, value_of(position, shape));
  for (const Vec3& unit : unit_directions(support.name, support.directions))
    add_summed(support.name, along(frame * unit, position), unit.dot(support.displacement), set);
}

// Statically determinate supports at three vertices far from each other: all displacements of the
// first one, those of the second one across the line between them, that of the third one normal to
// the plane of the three. Throws InputError if all vertices lie on a line.
std::vector<PointSupport> determinate_supports(const ModelLayout& model, const Points& shape) {
  const Surface surface = model.surface(shape);
  const Trim* trim = surface.trim().get();
  std::vector<Location> places;
  std::vector<Vec3> at;
  for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
    if (trim && trim->side(t) != Trim::Side::Inside) continue;
    for (int i = 0; i < 3; ++i) {
      places.push_back({t, Vec3::Unit(i)});
      at.push_back(surface.position(places.back()));
    }
  }
  const auto farthest = [&](const auto& distance) {
    int best = 0;
    for (int i = 1; i < isize(at); ++i)
      if (distance(at[i]) > distance(at[best])) best = i;
    return best;
  };
  if (at.empty()) throw InputError("found no element inside of the boundary of the shell");
  const Vec3 c = centre(model, shape);
  const int first = farthest([&](const Vec3& p) { return (p - c).norm(); });
  const int second = farthest([&](const Vec3& p) { return (p - at[first]).norm(); });
  const Vec3 line = (at[second] - at[first]).normalized();
  const int third = farthest([&](const Vec3& p) { return (p - at[first]).cross(line).norm(); });
  const Vec3 normal = line.cross(at[third] - at[first]).normalized();
  constexpr double collinear = 1e-9;
  if (!((at[third] - at[first]).cross(line).norm() > collinear * model.size()))
    throw InputError("found a shell along a line, expected a surface");
  const auto support = [&](int i, const std::vector<Vec3>& directions) {
    return PointSupport{"inertia relief", {{}, places[i], 0}, directions};
  };
  return {support(first, {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()}),
          support(second, {normal, normal.cross(line)}), support(third, {normal})};
}

void add_area_support(const ModelLayout& model, const Points& shape,
                      const std::vector<ShellSection>& sections, const AreaSupport& support,
                      ShellSprings& springs) {
  const std::vector<Vec3> directions = unit_directions(support.name, support.directions);
  const Surface surface = model.surface(shape);
  constexpr int degree = 4;
  bool any = false;
  const TabulatedRule whole(surface.kind(), symmetric_triangle_rule(degree + 2));
  for_each_part_point(model, surface, support.part, whole, degree, [&](const PartPoint& at) {
    any = true;
    if (!(at.area.norm() > 0)) return;
    const int r = model.region_of(at.where.triangle);
    const SpringStiffness k(surface, sections[sections.size() == 1 ? 0 : r], at.where.triangle);
    const ConstraintEntries position = at.entries();
    const Mat3 frame = frame_at(support.axes, at.x);
    for (const Vec3& unit : directions)
      springs.add(support.name, along(frame * unit, position),
                  k.displacement / k.edge * at.area.norm(), unit.dot(support.displacement));
  });
  if (!any) throw InputError("support '" + support.name + "' contains no part of the surface");
}

}  // namespace

std::vector<ShellSection> triangle_sections(const ModelLayout& model,
                                            const ShellDefinition& definition) {
  const auto& sections = definition.sections;
  const VecX& thickness_offset = definition.nodal_thickness_offset;
  if (sections.size() != 1 && isize(sections) != model.region_count())
    throw InputError("found " + std::to_string(sections.size()) + " shell sections for " +
                     std::to_string(model.region_count()) +
                     " faces, expected one, or one for each");
  for (const ShellSection& section : sections) require_section(section);
  if (thickness_offset.size() > 0 && thickness_offset.size() != model.mesh()->vertex_count())
    throw InputError("found " + std::to_string(thickness_offset.size()) + " thicknesses for " +
                     std::to_string(model.mesh()->vertex_count()) +
                     " vertices, expected one for each");
  if (sections.size() == 1 && thickness_offset.size() == 0) return sections;
  std::vector<ShellSection> all;
  for (int t = 0; t < model.mesh()->triangle_count(); ++t) {
    all.push_back(sections[sections.size() == 1 ? 0 : model.region_of(t)]);
    if (thickness_offset.size() == 0) continue;
    for (int i = 0; i < 3; ++i)
      all.back().thickness_offset[i] = thickness_offset[model.mesh()->triangles()[t][i]];
    require_section(all.back());
  }
  return all;
}

ShellTies shell_ties(const ModelLayout& model, const Points& shape,
                     const ShellDefinition& definition) {
  ShellTies ties = shell_ties(model, shape, definition.sections, definition.hinges);
  for (const LineSupport& support : definition.lines)
    add_support(model, shape, definition.sections, support, ties);
  for (const PointSupport& support : definition.points)
    add_point_support(model, shape, support, ties.constraints);
  if (definition.inertia_relief)
    for (const PointSupport& support : determinate_supports(model, shape))
      add_point_support(model, shape, support, ties.constraints);
  for (const AreaSupport& support : definition.areas)
    add_area_support(model, shape, definition.sections, support, ties.springs);
  for (const ElasticSupport& support : definition.elastic)
    add_elastic_support(model, shape, support, ties.springs);
  Stiffeners(model, shape, definition.stiffeners).add_to(ties.springs);
  std::vector<Stiffener> rigid;
  for (const std::string& line : definition.rigid_lines)
    rigid.push_back(rigid_line(model, definition.sections, line));
  Stiffeners(model, shape, std::move(rigid)).add_to(ties.springs);
  relax_dependent_constraints(model, shape, definition.sections, ties);
  return ties;
}

Mat3 CylindricalAxes::at(const Vec3& x) const {
  const Vec3 a = axis.normalized(), arm = x - origin, radial = arm - arm.dot(a) * a;
  constexpr double singular = 1e-9;
  if (!(radial.norm() > singular * std::max(arm.norm(), 1e-300)))
    throw InputError("found a support on the axis of its cylindrical directions at " +
                     format_point(x) + ", expected a support away from it");
  Mat3 frame;
  frame << radial.normalized(), a.cross(radial).normalized(), a;
  return frame;
}

double CylindricalAxes::turning(const Vec3& x, const Vec3& along) const {
  const Vec3 a = axis.normalized(), arm = x - origin, radial = arm - arm.dot(a) * a;
  return a.cross(radial).dot(along) / radial.squaredNorm();
}

Stiffener rigid_line(const ModelLayout& model, const std::vector<ShellSection>& sections,
                     const std::string& line) {
  constexpr double stiff = 100;
  LineSides sides(model);
  const JoinEdge side = sides(model.model_line(line));
  double length = 0, membrane = 0, bending = 0;
  for_each_line_point(side, side, [&](double, double dl) { length += dl; });
  for (const ShellSection& section : sections) {
    membrane = std::max(membrane, section.membrane_stiffness());
    bending = std::max(bending, section.bending_stiffness());
  }
  const double radius = length / (2 * std::numbers::pi);
  StiffenerSection rigid;
  rigid.young = rigid.shear_modulus = stiff;
  rigid.area = membrane * radius;
  rigid.lateral_inertia = membrane * radius * radius * radius;
  rigid.inertia = rigid.torsion = bending * radius;
  return {"rigid " + line, line, rigid};
}

SparseMatrix mass_matrix(const ModelLayout& model, const Points& shape,
                         const ShellDefinition& definition, const ShellAssembler& assembler) {
  SparseMatrix M = assembler.mass();
  Stiffeners(model, shape, definition.stiffeners).add_mass(M);
  if (definition.masses.empty()) return M;
  std::vector<Triplet> entries;
  for (const PointMass& of : definition.masses) {
    const ConstraintEntries position = shape_functions_at(model, of.position.where);
    for (const auto& a : position)
      for (const auto& b : position)
        if (a.dof >= b.dof)
          entries.emplace_back(a.dof, b.dof, of.mass * a.coefficient * b.coefficient);
  }
  SparseMatrix masses(M.rows(), M.cols());
  masses.setFromTriplets(entries.begin(), entries.end());
  M += masses;
  return M;
}

double added_mass(const ModelLayout& model, const Points& shape,
                  const ShellDefinition& definition) {
  double sum = Stiffeners(model, shape, definition.stiffeners).mass();
  for (const PointMass& of : definition.masses) sum += of.mass;
  return sum;
}

Points body_load(const ModelLayout& model, const Points& shape, const ShellDefinition& definition,
                 const AccelerationField& acceleration) {
  Points F = body_load(model, shape, triangle_sections(model, definition), acceleration);
  const Stiffeners stiffeners(model, shape, definition.stiffeners);
  if (!stiffeners.empty()) F += stiffeners.body_load(acceleration);
  const Surface surface = model.surface(shape);
  for (const PointMass& of : definition.masses)
    F += point_force(model, of.position,
                     of.mass * acceleration(surface.position(of.position.where)));
  return F;
}

std::vector<std::string> support_names(const ShellDefinition& definition) {
  std::vector<std::string> names;
  const auto add = [&](const auto& supports) {
    for (const auto& support : supports)
      if (std::find(names.begin(), names.end(), support.name) == names.end())
        names.push_back(support.name);
  };
  add(definition.lines);
  add(definition.points);
  add(definition.areas);
  add(definition.elastic);
  return names;
}

namespace {

void constrain_edge_aligned(const JoinEdge& side, const Points& shape, const LineSupport& support,
                            const std::vector<Vec3>& directions, ConstraintSet& set) {
  for (const Vec3& direction : directions)
    for (int k = 0; k < side.count(); ++k) {
      ConstraintEntries position, slope;
      side.add_position(k, 1, position);
      side.add_along(k, 1, slope);
      const Vec3 x = value_of(position, shape), here = frame_at(support.axes, x) * direction;
      add_summed(support.name, along(here, position), direction.dot(support.displacement), set);
      CoupledEntries row = along(here, slope);
      if (support.axes) {  // the direction rotates along the curve
        const double rate = support.axes->turning(x, value_of(slope, shape));
        for (const auto& e : along(rate * support.axes->axis.normalized().cross(here), position))
          row.push_back(e);
      }
      add_summed(support.name, row, 0, set);
    }
  if (!support.rotation) return;
  const LineRotation rotation(side, shape);
  for (int k = 0; k < side.count(); ++k) {
    CoupledEntries row;
    rotation.at_vertex(k, 1, row);
    add_summed(support.name, row, 0, set);
  }
  for (int k = 0; k + 1 < side.count(); ++k) {
    CoupledEntries row;
    rotation.at_edge_midpoint(k, 1, row);
    add_summed(support.name, row, 0, set);
  }
}

template <class Stiffness>
void constrain_by_springs(const JoinEdge& side, const Points& shape, const LineSupport& support,
                          const std::vector<Vec3>& directions, const Stiffness& stiffness,
                          ShellSprings& springs) {
  const LineRotation rotation(side, shape);
  bool any = false;
  for_each_line_point(side, side, [&](double f, double dl) {
    if (support.box && !support.box->contains(point_on_line(side, shape, f))) return;
    any = true;
    const SpringStiffness k = stiffness(f);
    ConstraintEntries position;
    side.add_at(f, 0, 0, 1, position);
    const Mat3 frame = frame_at(support.axes, value_of(position, shape));
    for (const Vec3& direction : directions)
      springs.add(support.name, along(frame * direction, position), k.displacement * dl,
                  direction.dot(support.displacement));
    if (!support.rotation) return;
    CoupledEntries row;
    rotation.at_fraction(f, 1, row);
    springs.add(support.name, row, k.rotation * dl, 0);
  });
  if (!any)
    throw InputError("support '" + support.name + "': its box contains no part of the curve");
}

const std::vector<Vec3> kAll = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};

}  // namespace

LineSupport LineSupport::clamped(const std::string& line) {
  return {"clamped " + line, line, kAll, Vec3::Zero(), true};
}

LineSupport LineSupport::pinned(const std::string& line) {
  return {"pinned " + line, line, kAll, Vec3::Zero(), false};
}

LineSupport LineSupport::symmetric(const std::string& line, const Vec3& normal) {
  return {"symmetric " + line, line, {normal}, Vec3::Zero(), true};
}

void add_support(const ModelLayout& model, const Points& shape,
                 const std::vector<ShellSection>& sections, const LineSupport& support,
                 ShellTies& ties) {
  if (support.directions.empty() && !support.rotation)
    throw InputError("support '" + support.name +
                     "' constrains nothing: expected directions, the rotation, or both");
  const std::vector<Vec3> directions = support.directions.empty()
                                           ? std::vector<Vec3>{}
                                           : unit_directions(support.name, support.directions);
  LineSides sides(model);
  const ModelLine& line = model.model_line(support.line);
  const JoinEdge side = sides(line);
  if (!side.embedded() && !support.box) {
    constrain_edge_aligned(side, shape, support, directions, ties.constraints);
    return;
  }
  const int r = line.sides[0].region;
  const Surface surface = model.surface(shape);
  constrain_by_springs(
      side, shape, support, directions,
      [&](double f) {
        return SpringStiffness(surface, sections[sections.size() == 1 ? 0 : r],
                               model.first_triangle(r) + side.where(f).triangle);
      },
      ties.springs);
}

namespace {

// Adds the springs at one point: along the axes, and along n.
void add_at(const ElasticSupport& support, const ConstraintEntries& position, double weight,
            const Vec3& n, ShellSprings& springs) {
  const auto add = [&](const Vec3& direction, double stiffness) {
    if (stiffness > 0) springs.add(support.name, along(direction, position), stiffness * weight, 0);
  };
  for (int c = 0; c < 3; ++c) add(Vec3::Unit(c), support.stiffness[c]);
  add(n, support.normal);
}

void add_on_area(const ModelLayout& model, const Points& shape, const ElasticSupport& support,
                 ShellSprings& springs) {
  constexpr int degree = 4;
  bool any = false;
  const Surface surface = model.surface(shape);
  const TabulatedRule whole(surface.kind(), symmetric_triangle_rule(degree + 2));
  for_each_part_point(model, surface, support.part, whole, degree, [&](const PartPoint& at) {
    any = true;
    if (at.area.norm() > 0)
      add_at(support, at.entries(), at.area.norm(), at.area.normalized(), springs);
  });
  if (!any)
    throw InputError("elastic support '" + support.name + "' contains no part of the surface");
}

}  // namespace

void add_elastic_support(const ModelLayout& model, const Points& shape,
                         const ElasticSupport& support, ShellSprings& springs) {
  const std::string who = "elastic support '" + support.name + "': ";
  if (!support.stiffness.allFinite() || support.stiffness.minCoeff() < 0 ||
      !(support.normal >= 0) || !(support.stiffness.sum() + support.normal > 0))
    throw InputError(who + "found no stiffness above 0, expected at least one");
  if (support.position) {
    add_at(support, shape_functions_at(model, support.position->where), 1, Vec3::Zero(), springs);
  } else if (!support.line.empty()) {
    LineSides sides(model);
    const JoinEdge side = sides(model.model_line(support.line));
    bool any = false;
    for_each_line_point(side, side, [&](double f, double dl) {
      if (support.part.box && !support.part.box->contains(point_on_line(side, shape, f))) return;
      any = true;
      ConstraintEntries position;
      side.add_at(f, 0, 0, 1, position);
      add_at(support, position, dl, Vec3::Zero(), springs);
    });
    if (!any) throw InputError(who + "its box contains no part of the curve");
  } else {
    add_on_area(model, shape, support, springs);
  }
}

}  // namespace batten
