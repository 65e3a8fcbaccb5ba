// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/layout/region_layout.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "batten/constraints/constrained_solver.h"
#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/fem/surface.h"
#include "batten/fem/surface_assembler.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/domains/annulus_domain.h"
#include "batten/skinning/domains/domain_input.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/region/polygon_fit.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

// Lines that only trim: their curve in space follows from the surface.

/// Computes the curve x(c(t)) of a surface over a pcurve c(t) in (u, v). `pcurve` gets the nodes
/// that the curve needs to be within `tolerance` of it (at most 4,096). Cost: O(nodes).
HermiteCurve curve_on_surface(const Surface& surface, HermiteCurve& pcurve, double tolerance);

namespace {

using Domain = SkinOptions::Domain;

void require_names(const std::vector<CharacterLine>& lines, const std::string& region) {
  for (size_t i = 0; i < lines.size(); ++i)
    for (size_t j = 0; j < i; ++j)
      if (lines[i].name == lines[j].name)
        throw InputError("two curves have the name '" + lines[i].name + "'");
  if (lines.empty()) throw InputError("face '" + region + "' has no curves");
}

double diagonal_of(const std::vector<CharacterLine>& lines) {
  Box3 box;
  constexpr int samples = 256;
  for (const auto& line : lines) {
    if (!line.curve) throw InputError("curve '" + line.name + "' has no geometry");
    const InputCurve& input = *line.curve;
    const HermiteCurve* prescribed = line.prescribed ? &line.prescribed->curve : nullptr;
    if (prescribed && prescribed->segment_count() < 1)
      throw InputError("prescribed curve '" + line.name + "' is empty");
    const double a = prescribed ? prescribed->start() : input.start(),
                 b = prescribed ? prescribed->end() : input.end();
    for (int i = 0; i <= samples; ++i) {
      const double t = a + (b - a) * i / samples;
      box.extend(prescribed ? prescribed->evaluate(t) : input.evaluate(t));
    }
  }
  const double size = box.diagonal().norm();
  if (!std::isfinite(size)) throw InputError("a curve has a point that is not finite");
  if (!(size > 0)) throw InputError("all curves have zero length: they are one point");
  return size;
}

// The lines of a region, split at corners and joined into loops.
struct JoinedLines {
  std::vector<Outline> loops, holes;
  std::vector<SmoothSegment> inner;
  std::string to_embed;  // name of an outline line that must be embedded, or empty
};

JoinedLines cut_and_join(const std::vector<CharacterLine>& lines, const DomainInput& task) {
  using Role = CharacterLine::Role;
  const SkinOptions& options = task.options;
  JoinedLines joined;
  std::vector<SmoothSegment> around, hole_segments;
  for (const CharacterLine& line : lines) {
    auto& kind = line.role == Role::Outline ? around
                 : line.role == Role::Hole  ? hole_segments
                                            : joined.inner;
    for (SmoothSegment& s : split_at_corners(line, options.corner_angle))
      kind.push_back(std::move(s));
  }
  joined.loops = make_loops(around, task.size, task.gap_tolerance, options.corner_angle,
                            options.reverse_orientation);
  if (!hole_segments.empty())
    joined.holes = make_loops(hole_segments, task.size, task.gap_tolerance, options.corner_angle);
  joined.inner = split_at_holes(joined.inner, joined.holes, task);
  for (const SmoothSegment& s : around)
    if (s.mesh_alignment == CharacterLine::MeshAlignment::Embedded) joined.to_embed = s.name;
  return joined;
}

// True if a loop has a corner with an angle of almost 0 or 360 degrees: no polygon has such a
// corner.
bool has_cusp(const Outline& loop) {
  constexpr double min_sine = 2e-3;
  return std::any_of(loop.corners.begin(), loop.corners.end(), [&](int c) {
    const LoopVertex vertex = loop_vertex_at(loop, static_cast<size_t>(c));
    return vertex.incoming.cross(vertex.outgoing).norm() < min_sine;
  });
}

// Domain type for a loop whose lines are embedded.
Domain embedding_domain(const Outline& loop, const DomainInput& task) {
  return has_simple_projection(loop, task) ? Domain::Projected : Domain::Developable;
}

Domain automatic_domain(const JoinedLines& joined, const DomainInput& task) {
  const std::vector<Outline>& loops = joined.loops;
  if (loops.size() == 2 && loops[0].corners.empty() && loops[1].corners.empty())
    return Domain::Annulus;
  const size_t corners = loops[0].corners.size();
  const bool polygon = corners >= 3 && corners <= kMaxPolygonCorners && joined.to_embed.empty() &&
                       !(loops.size() == 1 && has_cusp(loops[0]));
  return polygon ? Domain::Polygon : embedding_domain(loops[0], task);
}

// The user's choice or, with Domain::Auto, the most suitable type for these loops.
Domain chosen_domain(const JoinedLines& joined, const DomainInput& task) {
  const std::vector<Outline>& loops = joined.loops;
  const Domain domain =
      task.options.domain == Domain::Auto ? automatic_domain(joined, task) : task.options.domain;
  if (!joined.to_embed.empty() && domain != Domain::Projected && domain != Domain::Developable)
    throw InputError("curve '" + joined.to_embed +
                     "' has alignment = \"embedded\", but outlines of polygonal and annular "
                     "domains are always aligned; use domain = \"projected\"");
  if (loops.size() > 1 && domain != Domain::Annulus)
    throw InputError("the outline curves form " + std::to_string(loops.size()) + " loops, with '" +
                     loops[0].segments[0].segment.name + "' and '" +
                     loops[1].segments[0].segment.name +
                     "' in different ones; use role = \"hole\" for curves around a hole (two "
                     "smooth loops without holes bound an annular face)");
  if (loops.size() != 2 && domain == Domain::Annulus)
    throw InputError("found " + std::to_string(loops.size()) +
                     (loops.size() == 1 ? " loop" : " loops") +
                     " of outline curves, expected two for domain = \"annulus\"");
  return domain;
}

Vec3 first_point(const RegionGeometry& geometry) {
  const HermiteCurve& first = geometry.edge_aligned.empty() ? geometry.embedded.front().fitted
                                                            : geometry.edge_aligned.front().fitted;
  return first.evaluate(first.start());
}

// The surface of minimum bending energy through the lines, solved relative to the first line's
// start.
Surface min_bending_surface(const RegionGeometry& geometry, TriangleElement element) {
  const Vec3 origin = first_point(geometry);
  const SurfaceAssembler assembler(*geometry.mesh, element, geometry.trim);
  const int n = assembler.dofs().count();
  VecX ones = VecX::Zero(n);
  for (int v = 0; v < geometry.mesh->vertex_count(); ++v) ones[assembler.dofs().vertex(v)] = 1;
  const ConstrainedSolver solver(make_line_constraints(geometry, element).translated(ones, origin),
                                 assembler.stiffness(SurfaceStiffness{}),
                                 nested_dissection_order(*geometry.mesh));
  return {geometry.mesh, element, solver.solve(Points::Zero(n, 3)) + ones * origin.transpose(),
          geometry.trim};
}

// True if side lengths or corner angles of the polygon differ so much from those of the lines that
// the surface may be inverted. A corner divides the Jacobian by the ratio of its sines, but only
// locally, so a large ratio is no inversion. A small one is: the polygon is straight where lines
// turn, or turns the other way.
bool is_distorted(const Outline& loop, const RegionGeometry& geometry) {
  constexpr double degree = std::numbers::pi / 180, least = 1 / 2.1, most = 4,
                   max_length_ratio = 1.5;
  double longest = 0, shortest = std::numeric_limits<double>::infinity();
  const size_t n = geometry.corners.size();
  for (size_t c = 0; c < n; ++c) {
    const DomainCorner& corner = geometry.corners[c];
    const double ratio =
        std::sin(corner.domain_angle_deg * degree) / std::sin(corner.line_angle_deg * degree);
    if (!(ratio > least && ratio < most)) return true;
    const double length_ratio =
        (geometry.corners[(c + 1) % n].uv - corner.uv).norm() / loop.side_length(c);
    longest = std::max(longest, length_ratio);
    shortest = std::min(shortest, length_ratio);
  }
  return longest > max_length_ratio * shortest;
}

// True if the surface of the outline alone is inverted somewhere, or nearly so.
bool is_inverted(const RegionGeometry& geometry, TriangleElement element) {
  constexpr double least = 0.05;
  return !(measure(min_bending_surface(geometry, element)).min_jacobian_ratio >= least);
}

// Moves the polygon's corners until the surface has as little strain as straight sides allow.
void minimize_distortion(const JoinedLines& joined, const DomainInput& task,
                         RegionGeometry& geometry, std::vector<SmoothSegment>& others) {
  constexpr int max_rounds = 3;
  for (int round = 0; round < max_rounds; ++round) {
    std::vector<Vec2> polygon;
    for (const DomainCorner& corner : geometry.corners) polygon.push_back(corner.uv);
    const LeastDistortedPolygon better =
        find_least_distorted_polygon(min_bending_surface(geometry, task.options.element), polygon);
    constexpr double min_improvement = 0.95;
    if (better.expected.rms > min_improvement * better.before.rms) break;
    others.clear();
    geometry = make_polygon_geometry(joined.loops[0], joined.inner, task, &better.polygon, others);
  }
}

// Builds the polygonal domain with its mesh and lines. Returns nullopt if another domain type suits
// the outline better and the user did not choose one.
std::optional<RegionGeometry> polygon_mesh(const JoinedLines& joined, const DomainInput& task,
                                           std::vector<SmoothSegment>& others) {
  const Outline& loop = joined.loops[0];
  const bool automatic = task.options.domain == Domain::Auto;
  RegionGeometry geometry;
  try {
    geometry = make_polygon_geometry(loop, joined.inner, task, nullptr, others);
  } catch (const NoPolygonError&) {
    if (!automatic) throw;
    return std::nullopt;
  }
  // If sides bend strongly and corners hardly turn, the polygon has too little area.
  if (automatic && !task.options.convex && is_distorted(loop, geometry) &&
      is_inverted(geometry, task.options.element))
    return std::nullopt;
  if (task.options.minimize_distortion) minimize_distortion(joined, task, geometry, others);
  return geometry;
}

// Builds domain and mesh for the outline; a projected domain takes all lines. `others`: inner lines
// that are not edge-aligned. If no polygon is good enough, `domain` is changed to another type.
RegionGeometry fit_and_mesh(const JoinedLines& joined, const DomainInput& task, Domain& domain,
                            std::vector<SmoothSegment>& others) {
  const Outline& loop = joined.loops[0];
  if (domain == Domain::Polygon) {
    if (auto geometry = polygon_mesh(joined, task, others)) return *std::move(geometry);
    domain = embedding_domain(loop, task);
  }
  others = joined.inner;
  if (domain == Domain::Annulus) return make_annulus_geometry(loop, joined.loops[1], task);
  if (domain == Domain::Developable) return make_developable_geometry(loop, task);
  return make_projected_geometry(loop, joined.holes, joined.inner, task);
}

// Embeds holes and inner lines on the surface that the outline alone defines.
void embed(const JoinedLines& joined, const std::vector<SmoothSegment>& others,
           const DomainInput& task, Domain domain, RegionGeometry& geometry) {
  if (domain == Domain::Projected || (joined.holes.empty() && others.empty())) return;
  if (domain == Domain::Developable) {
    refine_by_curvature(geometry, task);
    trim_and_collocate(geometry, task);
  }
  const bool sections = domain == Domain::Annulus && task.options.sections;
  const Surface surface = sections ? interpolate_sections(geometry, others, task.options.element)
                                   : min_bending_surface(geometry, task.options.element);
  const auto embed_lines = domain == Domain::Annulus ? embed_on_annulus : embed_on_surface;
  embed_lines(surface, joined.holes, others, task, geometry);
}

// Finds the outline lines that run against their prescribed curves.
void mark_opposite_directions(RegionGeometry& geometry) {
  for (EmbeddedLine& line : geometry.embedded) {
    if (!line.line.prescribed) continue;
    const HermiteCurve& prescribed = line.line.prescribed->curve;
    constexpr double f = 0.25;  // not 0: ends may coincide
    const auto at = [](const HermiteCurve& c, double s) {
      return c.evaluate(c.start() + s * (c.end() - c.start()));
    };
    const Vec3 p = at(line.fitted, f);
    line.opposite_to_prescribed =
        (p - at(prescribed, 1 - f)).norm() < (p - at(prescribed, f)).norm();
  }
}

// Trims the mesh, chooses collocation points, and bisects triangles under large gaps.
void cut_and_refine(RegionGeometry& geometry, const DomainInput& task, const Progress& progress) {
  if (geometry.embedded.empty()) return;
  mark_opposite_directions(geometry);
  refine_by_curvature(geometry, task);
  trim_and_collocate(geometry, task);
  progress.update("meshing", 0.5);
  constexpr int max_rounds = 8;
  for (int round = 0; round < max_rounds; ++round) {
    const Surface shape = min_bending_surface(geometry, task.options.element);
    if (!refine_at_gaps(geometry, shape, 0.5 * task.options.tolerance, task)) break;
    progress.update("meshing", 0.5 + 0.5 * (round + 1) / max_rounds);
  }
}

}  // namespace

RegionLayout::RegionLayout(std::string name, const std::vector<CharacterLine>& lines,
                           const SkinOptions& options, const Progress& progress)
    : name_(std::move(name)), options_(options) {
  require_names(lines, name_);
  const ProgressScope scope(progress);
  progress.update("fitting curves", 0);
  size_ = diagonal_of(lines);
  tolerance_ = options.tolerance > 0 ? options.tolerance : 1e-4 * size_;
  require_tolerance(tolerance_, size_);
  gap_tolerance_ = std::max(tolerance_, 1e-6 * size_);
  DomainInput task = this->task();

  // 1. Split and join.
  const JoinedLines joined = cut_and_join(lines, task);
  progress.update("fitting curves", 0.5);
  // 2. Choose a domain type.
  options_.domain = chosen_domain(joined, task);
  const bool has_no_polygon = options.minimize_distortion && options_.domain != Domain::Polygon;
  progress.update("meshing", 0);
  // 3. Fit and mesh.
  std::vector<SmoothSegment> others;
  geometry_ = fit_and_mesh(joined, task, options_.domain, others);
  // 4. Embed.
  embed(joined, others, task, options_.domain, geometry_);
  // 5. Trim and refine.
  cut_and_refine(geometry_, task, progress);
  progress.update("meshing", 1);
  if (has_no_polygon)
    geometry_.warnings.insert(geometry_.warnings.begin(),
                              "minimize_distortion has no effect: this domain is not a polygon");
}

DomainInput RegionLayout::task() const {
  DomainInput input{options_, size_, gap_tolerance_};
  input.options.tolerance = tolerance_;
  input.options.edge_length = options_.edge_length > 0 ? options_.edge_length : size_ / 20;
  return input;
}

bool RegionLayout::refine(const Surface& shape, double target) {
  return refine_at_gaps(geometry_, shape, target, task());
}

Vec3 RegionLayout::origin() const { return first_point(geometry_); }

ConstraintSet RegionLayout::line_constraints() const {
  return make_line_constraints(geometry_, options_.element);
}

ConstraintSet RegionLayout::corner_constraints() const {
  const ParametricMesh& mesh = *geometry_.mesh;
  if (geometry_.corners.empty())
    throw InputError("face '" + name_ + "' has no corners; boundary = \"corners\" needs some");
  ConstraintSet set(DofMap(mesh).count());
  SurfaceConstraints shape(mesh, options_.element, set);
  const TriangleLocator locator(mesh);
  for (size_t c = 0; c < geometry_.corners.size(); ++c) {
    const Vec2 corner = geometry_.corners[c].uv;
    const std::string name = "corner " + std::to_string(c + 1);
    bool constrained = false;
    for (const EdgeAlignedLine& aligned_line : edge_aligned()) {
      const bool first = mesh.vertices()[aligned_line.vertices.front()] == corner;
      if (constrained || (!first && mesh.vertices()[aligned_line.vertices.back()] != corner))
        continue;
      shape.point(name, first ? aligned_line.vertices.front() : aligned_line.vertices.back(),
                  aligned_line.fitted.evaluate(first ? aligned_line.fitted.start()
                                                     : aligned_line.fitted.end()));
      constrained = true;
    }
    for (const EmbeddedLine& line : embedded()) {
      const Vec3 start = line.pcurve.evaluate(line.pcurve.start());
      if (constrained || line.pcurve.closed() || Vec2(start.x(), start.y()) != corner) continue;
      shape.point(name, locator.locate(corner), line.fitted.evaluate(line.fitted.start()));
      constrained = true;
    }
  }
  return set;
}

SkinnedRegion RegionLayout::region(Points dofs) const {
  SkinnedRegion region{name_,
                       Surface(geometry_.mesh, options_.element, std::move(dofs), geometry_.trim),
                       geometry_.edge_aligned,
                       size_,
                       geometry_.embedded,
                       geometry_.boundary};
  for (EmbeddedLine& line : region.embedded)
    if (!line.line.constrains_surface)
      line.fitted = curve_on_surface(region.surface, line.pcurve, 0.1 * tolerance_);
  return region;
}

// Edits are made on a copy of the geometry, which replaces the original only if nothing was thrown.

namespace {

// True for "rib.1", "rib.2", …: the segments into which line "rib" is split at its corners.
bool is_piece_of(const std::string& name, const std::string& line) {
  if (name.size() < line.size() + 2 || name.compare(0, line.size(), line) != 0) return false;
  return name[line.size()] == '.' &&
         std::all_of(name.begin() + static_cast<long>(line.size()) + 1, name.end(),
                     [](unsigned char c) { return std::isdigit(c); });
}

// The curve of an edge-aligned or embedded line, or null.
template <class Geometry>
auto find_line(Geometry& geometry, const std::string& name)
    -> decltype(&geometry.edge_aligned[0].fitted) {
  for (auto& aligned_line : geometry.edge_aligned)
    if (aligned_line.line.name == name) return &aligned_line.fitted;
  for (auto& line : geometry.embedded)
    if (line.line.name == name) return &line.fitted;
  return nullptr;
}

void erase_embedded(RegionGeometry& geometry, size_t index) {
  geometry.embedded.erase(geometry.embedded.begin() + static_cast<long>(index));
  for (auto& segments : geometry.boundary)
    for (BoundarySegment& piece : segments)
      if (piece.kind == BoundarySegment::Kind::Embedded && piece.index > static_cast<int>(index))
        --piece.index;
}

[[noreturn]] void no_such_line(const std::string& region, const std::string& name,
                               const std::vector<std::string>& names) {
  throw InputError("face '" + region + "' has no curve '" + name + "'" + did_you_mean(name, names));
}

}  // namespace

std::vector<std::string> RegionLayout::line_names() const {
  std::vector<std::string> names;
  for (const EdgeAlignedLine& aligned_line : geometry_.edge_aligned)
    names.push_back(aligned_line.line.name);
  for (const EmbeddedLine& line : geometry_.embedded) names.push_back(line.line.name);
  return names;
}

bool RegionLayout::has_line(const std::string& name) const {
  return find_line(geometry_, name) != nullptr;
}

const HermiteCurve& RegionLayout::line(const std::string& name) const {
  const HermiteCurve* found = find_line(geometry_, name);
  if (!found) no_such_line(name_, name, line_names());
  return *found;
}

bool RegionLayout::refine(const std::vector<char>& marked) {
  if (isize(marked) != mesh()->triangle_count())
    throw InputError("found " + std::to_string(marked.size()) + " refinement marks for " +
                     std::to_string(mesh()->triangle_count()) +
                     " triangles, expected one for each");
  if (std::none_of(marked.begin(), marked.end(), [](char m) { return m != 0; })) return false;
  RegionGeometry geometry = geometry_;
  bisect_marked(geometry, marked);
  if (!geometry.embedded.empty()) trim_and_collocate(geometry, task());
  geometry_ = std::move(geometry);
  return true;
}

void RegionLayout::set_line(const std::string& name, HermiteCurve curve) {
  const CurveMesh &old = line(name).mesh(), &prescribed = curve.mesh();
  if (prescribed.parameters() != old.parameters() || prescribed.closed() != old.closed() ||
      prescribed.corners() != old.corners())
    throw InputError(
        "curve '" + name + "': found " + std::to_string(prescribed.segment_count()) +
        " segments over [" + format_number(prescribed.start()) + ", " +
        format_number(prescribed.end()) +
        "], expected the same nodes and corners as before: " + std::to_string(old.segment_count()) +
        " segments over [" + format_number(old.start()) + ", " + format_number(old.end()) + "]");
  auto input = curve_from_hermite(curve);
  const auto set = [&](auto& entry) {
    if (entry.line.name != name) return;
    entry.line.curve = std::move(input);
    entry.fitted = std::move(curve);
  };
  // Names are unique: the first match takes the curve.
  for (EdgeAlignedLine& aligned_line : geometry_.edge_aligned) set(aligned_line);
  for (EmbeddedLine& embedded : geometry_.embedded) set(embedded);
}

void RegionLayout::add_inner_line(const CharacterLine& line, const Surface& shape) {
  if (line.role != CharacterLine::Role::Inner)
    throw InputError("curve '" + line.name +
                     "' is not an inner curve: outlines and holes cannot be added later");
  if (line.mesh_alignment == CharacterLine::MeshAlignment::EdgeAligned)
    throw InputError("curve '" + line.name +
                     "' has alignment = \"aligned\", but curves that are added later are always "
                     "embedded");
  if (&shape.mesh() != geometry_.mesh.get())
    throw InputError("curve '" + line.name + "': its surface does not have the mesh of face '" +
                     name_ + "'");
  const std::vector<SmoothSegment> segments = split_at_corners(line, options_.corner_angle);
  for (const std::string& other : line_names())
    for (const SmoothSegment& segment : segments)
      if (other == segment.name || other == line.name || is_piece_of(other, line.name))
        throw InputError("two curves have the name '" + other + "'");
  RegionGeometry geometry = geometry_;
  if (geometry.mesh->period() > 0)
    embed_on_annulus(shape, {}, segments, task(), geometry);
  else
    embed_on_surface(shape, {}, segments, task(), geometry);
  trim_and_collocate(geometry, task());
  geometry_ = std::move(geometry);
}

void RegionLayout::remove_inner_line(const std::string& name) {
  const std::vector<char> bounds = boundary_line_flags(geometry_);
  const bool whole = has_line(name);
  RegionGeometry geometry = geometry_;
  bool found = false;
  for (size_t i = geometry_.embedded.size(); i-- > 0;) {
    const std::string& other = geometry_.embedded[i].line.name;
    if (bounds[i] || !(whole ? other == name : is_piece_of(other, name))) continue;
    erase_embedded(geometry, i);
    found = true;
  }
  if (!found && whole)
    throw InputError("curve '" + name +
                     "' cannot be removed: it bounds the face, or the mesh is aligned with it");
  if (!found) no_such_line(name_, name, line_names());
  if (!geometry.embedded.empty()) trim_and_collocate(geometry, task());
  geometry_ = std::move(geometry);
}

namespace {

HermiteCurve at_nodes(const Surface& surface, const TriangleLocator& locator,
                      const HermiteCurve& pcurve) {
  Points dofs(pcurve.mesh().dof_count(), 3);
  for (int i = 0; i < pcurve.node_count(); ++i) {
    const SurfaceJet jet = surface.jet(locator.locate(drop_z(pcurve.position(i))));
    const auto along = [&](const Vec3& c) -> Vec3 { return jet.x_u * c.x() + jet.x_v * c.y(); };
    dofs.row(pcurve.mesh().position_dof(i)) = jet.x;
    dofs.row(pcurve.mesh().slope_in(i)) = along(pcurve.slope_in(i));
    dofs.row(pcurve.mesh().slope_out(i)) = along(pcurve.slope_out(i));
  }
  return {pcurve.mesh(), std::move(dofs)};
}

}  // namespace

HermiteCurve curve_on_surface(const Surface& surface, HermiteCurve& pcurve, double tolerance) {
  constexpr int max_nodes = 4096;
  const TriangleLocator locator(surface.mesh());
  for (;;) {
    HermiteCurve curve = at_nodes(surface, locator, pcurve);
    if (2 * pcurve.node_count() > max_nodes) return curve;
    std::vector<double> further;
    for (int s = 0; s < pcurve.segment_count(); ++s)
      for (const double f : {0.25, 0.5, 0.75}) {
        const CurveMesh::SegmentPoint where{s, f};
        const Vec3 x = surface.position(locator.locate(drop_z(pcurve.evaluate(where))));
        if ((x - curve.evaluate(where)).norm() <= tolerance) continue;
        further.push_back(pcurve.parameters()[static_cast<size_t>(s)] +
                          pcurve.mesh().length(s) / 2);
        break;
      }
    if (further.empty()) return curve;
    pcurve = pcurve.with_nodes(further);
  }
}

}  // namespace batten
