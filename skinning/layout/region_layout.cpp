#include "batten/skinning/layout/region_layout.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "batten/constraints/constrained_solver.h"
#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/box.h"
#include "batten/core/errors.h"
#include "batten/fem/assembly.h"
#include "batten/fem/dissection.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/domains/domain_task.h"
#include "batten/skinning/domains/hole_cuts.h"
#include "batten/skinning/domains/mesh_size.h"
#include "batten/skinning/domains/polygon_fit.h"
#include "batten/skinning/domains/ring.h"
#include "batten/skinning/domains/ring_sections.h"
#include "batten/skinning/region/flatten.h"
#include "batten/skinning/region/quality.h"
#include "batten/skinning/region/surface_line.h"

namespace batten {
namespace {

using Domain = SkinOptions::Domain;

void require_names(const std::vector<CharacterLine>& lines, const std::string& region) {
  for (size_t i = 0; i < lines.size(); ++i)
    for (size_t j = 0; j < i; ++j)
      if (lines[i].name == lines[j].name)
        throw InputError("two lines have the name '" + lines[i].name + "'");
  if (lines.empty()) throw InputError("region '" + region + "' has no lines");
}

double diagonal_of(const std::vector<CharacterLine>& lines) {
  Box3 box;
  constexpr int samples = 256;
  for (const auto& line : lines) {
    if (!line.curve) throw InputError("line '" + line.name + "' has no curve");
    const InputCurve& input = *line.curve;
    const HermiteCurve* given = line.given ? &line.given->curve : nullptr;
    if (given && given->segment_count() < 1)
      throw InputError("the given curve of line '" + line.name + "' is empty");
    const double a = given ? given->start() : input.start(), b = given ? given->end() : input.end();
    for (int i = 0; i <= samples; ++i) {
      const double t = a + (b - a) * i / samples;
      box.extend(given ? given->evaluate(t) : input.evaluate(t));
    }
  }
  const double size = box.diagonal().norm();
  if (!std::isfinite(size)) throw InputError("a line has a point that is not finite");
  if (!(size > 0)) throw InputError("all lines are one point: they have zero length");
  return size;
}

// The lines of a region, cut at corners and joined into loops.
struct JoinedLines {
  std::vector<Outline> loops, holes;
  std::vector<Stretch> inner;
  std::string to_embed;  // an outline line that has to be embedded
};

JoinedLines cut_and_join(const std::vector<CharacterLine>& lines, const DomainTask& task) {
  using Role = CharacterLine::Role;
  const SkinOptions& options = task.options;
  JoinedLines joined;
  std::vector<Stretch> around, rims;
  for (const CharacterLine& line : lines) {
    auto& kind = line.role == Role::Outline ? around
                 : line.role == Role::Hole  ? rims
                                            : joined.inner;
    for (Stretch& s : cut_at_corners(line, options.corner_angle)) kind.push_back(std::move(s));
  }
  joined.loops =
      make_loops(around, task.size, task.join, options.corner_angle, options.against_first);
  if (!rims.empty()) joined.holes = make_loops(rims, task.size, task.join, options.corner_angle);
  joined.inner = cut_at_holes(joined.inner, joined.holes, task);
  for (const Stretch& s : around)
    if (s.treatment == CharacterLine::Treatment::Embedded) joined.to_embed = s.name;
  return joined;
}

// Whether two lines leave a corner in one direction, or go on in one: no polygon has such a corner.
bool has_cusp(const Outline& loop) {
  constexpr double least_sine = 2e-3;
  return std::any_of(loop.corners.begin(), loop.corners.end(), [&](int c) {
    const Joint joint = joint_at(loop, static_cast<size_t>(c));
    return joint.incoming.cross(joint.outgoing).norm() < least_sine;
  });
}

// The domain of a loop whose lines are embedded.
Domain embedding_domain(const Outline& loop, const DomainTask& task) {
  return projects_simply(loop, task) ? Domain::Plane : Domain::Sheet;
}

Domain automatic_domain(const JoinedLines& joined, const DomainTask& task) {
  const std::vector<Outline>& loops = joined.loops;
  if (loops.size() == 2 && loops[0].corners.empty() && loops[1].corners.empty())
    return Domain::Ring;
  const bool polygon = loops[0].corners.size() >= 3 && joined.to_embed.empty() &&
                       !(loops.size() == 1 && has_cusp(loops[0]));
  return polygon ? Domain::Polygon : embedding_domain(loops[0], task);
}

// What the user asked for, or the best for these loops.
Domain chosen_domain(const JoinedLines& joined, const DomainTask& task) {
  const std::vector<Outline>& loops = joined.loops;
  const Domain domain =
      task.options.domain == Domain::Auto ? automatic_domain(joined, task) : task.options.domain;
  if (!joined.to_embed.empty() && domain != Domain::Plane && domain != Domain::Sheet)
    throw InputError("line '" + joined.to_embed +
                     "' cannot be embedded: outlines of polygons and rings are fitted (a plane "
                     "embeds them)");
  if (loops.size() > 1 && domain != Domain::Ring)
    throw InputError("the outline lines form " + std::to_string(loops.size()) + " loops, with '" +
                     loops[0].pieces[0].stretch.name + "' and '" + loops[1].pieces[0].stretch.name +
                     "' in different ones: lines around a hole have role = \"hole\" (two smooth "
                     "loops without holes are a ring)");
  if (loops.size() != 2 && domain == Domain::Ring)
    throw InputError("a ring needs two loops of outline lines, and there are " +
                     std::to_string(loops.size()));
  return domain;
}

Vec3 first_point(const RegionParts& parts) {
  const HermiteCurve& first =
      parts.runs.empty() ? parts.embedded.front().fitted : parts.runs.front().fitted;
  return first.evaluate(first.start());
}

// The surface of least bending, solved about the first line's start.
Surface plain_surface(const RegionParts& parts, TriangleElement element) {
  const Vec3 origin = first_point(parts);
  const SurfaceAssembler assembler(*parts.mesh, element, parts.trim);
  const int n = assembler.dofs().count();
  VecX ones = VecX::Zero(n);
  for (int v = 0; v < parts.mesh->vertex_count(); ++v) ones[assembler.dofs().vertex(v)] = 1;
  const ConstrainedSolver solver(line_rows(parts, element).moved(ones, origin),
                                 assembler.stiffness(SurfaceStiffness{}),
                                 dissection_order(*parts.mesh));
  return {parts.mesh, element, solver.solve(Points::Zero(n, 3)) + ones * origin.transpose(),
          parts.trim};
}

// Whether the polygon had to give up so much of its sides' lengths or of its corners' angles that
// the surface may turn over. A corner divides the Jacobian by the ratio of its sines, there only: a
// large one is no fold. A small one is: the polygon is straight where lines turn, or turns back.
bool strained(const Outline& loop, const RegionParts& parts) {
  constexpr double degree = std::numbers::pi / 180, least = 1 / 2.1, most = 4, most_length = 1.5;
  double longest = 0, shortest = std::numeric_limits<double>::infinity();
  const size_t n = parts.corners.size();
  for (size_t c = 0; c < n; ++c) {
    const DomainCorner& corner = parts.corners[c];
    const double ratio =
        std::sin(corner.domain_degrees * degree) / std::sin(corner.line_degrees * degree);
    if (!(ratio > least && ratio < most)) return true;
    const double share = (parts.corners[(c + 1) % n].uv - corner.uv).norm() / loop.side_length(c);
    longest = std::max(longest, share);
    shortest = std::min(shortest, share);
  }
  return longest > most_length * shortest;
}

// Whether the surface of the outline alone turns over somewhere, or nearly so.
bool overturned(const RegionParts& parts, TriangleElement element) {
  constexpr double least = 0.05;
  return !(measure(plain_surface(parts, element)).min_jacobian_ratio >= least);
}

// Moves the polygon's corners until the surface is as little strained as straight sides allow.
void settle(const JoinedLines& joined, const DomainTask& task, RegionParts& parts,
            std::vector<Stretch>& others) {
  constexpr int most_rounds = 3;
  for (int round = 0; round < most_rounds; ++round) {
    std::vector<Vec2> polygon;
    for (const DomainCorner& corner : parts.corners) polygon.push_back(corner.uv);
    const Flattened better = flatten(plain_surface(parts, task.options.element), polygon);
    constexpr double worth_it = 0.95;
    if (better.expected.rms > worth_it * better.before.rms) break;
    others.clear();
    parts = polygon_parts(joined.loops[0], joined.inner, task, &better.polygon, others);
  }
}

// The polygon, its mesh and lines; nothing where another domain suits the outline better and the
// user asked for none.
std::optional<RegionParts> polygon_mesh(const JoinedLines& joined, const DomainTask& task,
                                        std::vector<Stretch>& others) {
  const Outline& loop = joined.loops[0];
  const bool automatic = task.options.domain == Domain::Auto;
  RegionParts parts;
  try {
    parts = polygon_parts(loop, joined.inner, task, nullptr, others);
  } catch (const NoPolygon&) {
    if (!automatic) throw;
    return std::nullopt;
  }
  // Sides that bend much while corners hardly turn leave no room in a polygon.
  if (automatic && !task.options.convex && strained(loop, parts) &&
      overturned(parts, task.options.element))
    return std::nullopt;
  if (task.options.settle) settle(joined, task, parts, others);
  return parts;
}

// The outline on its domain, and the mesh; a plane takes all lines. `others`: inner lines that are
// not fitted. Where no polygon is good enough the domain becomes another one.
RegionParts fit_and_mesh(const JoinedLines& joined, const DomainTask& task, Domain& domain,
                         std::vector<Stretch>& others) {
  const Outline& loop = joined.loops[0];
  if (domain == Domain::Polygon) {
    if (auto parts = polygon_mesh(joined, task, others)) return *std::move(parts);
    domain = embedding_domain(loop, task);
  }
  others = joined.inner;
  if (domain == Domain::Ring) return ring_parts(loop, joined.loops[1], task);
  if (domain == Domain::Sheet) return sheet_parts(loop, task);
  return plane_parts(loop, joined.holes, joined.inner, task);
}

// Holes and inner lines, on the surface that the outline alone makes.
void embed(const JoinedLines& joined, const std::vector<Stretch>& others, const DomainTask& task,
           Domain domain, RegionParts& parts) {
  if (domain == Domain::Plane || (joined.holes.empty() && others.empty())) return;
  if (domain == Domain::Sheet) {
    grade_by_curvature(parts, task);
    cut_and_place(parts, task);
  }
  const bool sections = domain == Domain::Ring && task.options.sections;
  const Surface surface = sections ? through_sections(parts, others, task.options.element)
                                   : plain_surface(parts, task.options.element);
  const auto embed_lines = domain == Domain::Ring ? embed_on_ring : embed_on;
  embed_lines(surface, joined.holes, others, task, parts);
}

// Which outlines run against the curve that was given for them.
void note_directions(RegionParts& parts) {
  for (EmbeddedLine& line : parts.embedded) {
    if (!line.line.given) continue;
    const HermiteCurve& given = line.line.given->curve;
    constexpr double f = 0.25;  // ends may be one point
    const auto at = [](const HermiteCurve& c, double s) {
      return c.evaluate(c.start() + s * (c.end() - c.start()));
    };
    const Vec3 p = at(line.fitted, f);
    line.against_given = (p - at(given, 1 - f)).norm() < (p - at(given, f)).norm();
  }
}

// Cuts the mesh, places the points of embedded lines, and halves triangles under their gaps.
void cut_and_refine(RegionParts& parts, const DomainTask& task, const Progress& progress) {
  if (parts.embedded.empty()) return;
  note_directions(parts);
  grade_by_curvature(parts, task);
  cut_and_place(parts, task);
  progress.at("meshing", 0.5);
  constexpr int most_rounds = 8;
  for (int round = 0; round < most_rounds; ++round) {
    const Surface shape = plain_surface(parts, task.options.element);
    if (!refine_at_gaps(parts, shape, 0.5 * task.tolerance, task)) break;
    progress.at("meshing", 0.5 + 0.5 * (round + 1) / most_rounds);
  }
}

}  // namespace

RegionLayout::RegionLayout(std::string name, const std::vector<CharacterLine>& lines,
                           const SkinOptions& options, const Progress& progress)
    : name_(std::move(name)), options_(options) {
  require_names(lines, name_);
  progress.at("fitting lines", 0);
  size_ = diagonal_of(lines);
  tolerance_ = options.tolerance > 0 ? options.tolerance : 1e-4 * size_;
  require_tolerance(tolerance_, size_);
  edge_ = options.edge_length > 0 ? options.edge_length : size_ / 20;
  join_ = std::max(tolerance_, 1e-6 * size_);
  DomainTask task = this->task();
  task.progress = progress;

  // 1. Cut and join.
  const JoinedLines joined = cut_and_join(lines, task);
  progress.at("fitting lines", 0.5);
  // 2. Choose a domain.
  options_.domain = chosen_domain(joined, task);
  const bool unsettled = options.settle && options_.domain != Domain::Polygon;
  progress.at("meshing", 0);
  // 3. Fit and mesh.
  std::vector<Stretch> others;
  parts_ = fit_and_mesh(joined, task, options_.domain, others);
  // 4. Embed.
  embed(joined, others, task, options_.domain, parts_);
  // 5. Cut and refine.
  cut_and_refine(parts_, task, progress);
  progress.at("meshing", 1);
  if (unsettled)
    parts_.warnings.insert(parts_.warnings.begin(),
                           "settle moves the corners of polygons: this domain has none to move");
}

DomainTask RegionLayout::task() const { return {options_, size_, tolerance_, edge_, join_}; }

bool RegionLayout::refine(const Surface& shape, double target) {
  return refine_at_gaps(parts_, shape, target, task());
}

Vec3 RegionLayout::origin() const { return first_point(parts_); }

ConstraintSet RegionLayout::line_constraints() const { return line_rows(parts_, options_.element); }

ConstraintSet RegionLayout::corner_constraints() const {
  const ParametricMesh& mesh = *parts_.mesh;
  if (parts_.corners.empty())
    throw InputError("region '" + name_ + "' has no corners that could hold it");
  ConstraintSet set(DofMap(mesh).count());
  ShapeConstraints shape(mesh, options_.element, set);
  const TriangleLocator locator(mesh);
  for (size_t c = 0; c < parts_.corners.size(); ++c) {
    const Vec2 corner = parts_.corners[c].uv;
    const std::string name = "corner " + std::to_string(c + 1);
    bool held = false;
    for (const LineRun& run : runs()) {
      const bool first = mesh.vertices()[run.vertices.front()] == corner;
      if (held || (!first && mesh.vertices()[run.vertices.back()] != corner)) continue;
      shape.point(name, first ? run.vertices.front() : run.vertices.back(),
                  run.fitted.evaluate(first ? run.fitted.start() : run.fitted.end()));
      held = true;
    }
    for (const EmbeddedLine& line : embedded()) {
      const Vec3 start = line.image.evaluate(line.image.start());
      if (held || line.image.closed() || Vec2(start.x(), start.y()) != corner) continue;
      shape.point(name, locator.locate(corner), line.fitted.evaluate(line.fitted.start()));
      held = true;
    }
  }
  return set;
}

SkinnedRegion RegionLayout::region(Points dofs) const {
  SkinnedRegion region{
      name_,           Surface(parts_.mesh, options_.element, std::move(dofs), parts_.trim),
      parts_.runs,     size_,
      parts_.embedded, parts_.boundary};
  for (EmbeddedLine& line : region.embedded)
    if (!line.line.holds) line.fitted = curve_on(region.surface, line.image, 0.1 * tolerance_);
  return region;
}

}  // namespace batten
