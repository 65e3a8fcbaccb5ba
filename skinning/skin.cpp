#include "batten/skinning/skin.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "batten/constraints/affine_reduction.h"
#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/errors.h"
#include "batten/fem/dissection.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/flatten.h"
#include "batten/skinning/region_parts.h"
#include "batten/skinning/ring.h"

namespace batten {
namespace {

double diagonal_of(const std::vector<CharacterLine>& lines) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Vec3 low = Vec3::Constant(infinity), high = -low;
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
      const Vec3 p = given ? given->evaluate(t) : input.evaluate(t);
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  const double size = (high - low).norm();
  if (!std::isfinite(size)) throw InputError("a line has a point that is not finite");
  if (!(size > 0)) throw InputError("all lines are one point: they have zero length");
  return size;
}

// The shape of least bending, solved about the first line's start.
Points plain_shape(const RegionParts& parts, TriangleElement element, const Vec3& origin) {
  const SurfaceAssembler assembler(*parts.mesh, element, parts.trim);
  VecX ones = VecX::Zero(assembler.dofs().count());
  for (int v = 0; v < parts.mesh->vertex_count(); ++v) ones[assembler.dofs().vertex(v)] = 1;
  const ConstrainedSolver solver(line_rows(parts, element).moved(ones, origin),
                                 assembler.stiffness(SurfaceStiffness{}),
                                 dissection_order(*parts.mesh));
  return solver.solve(Points::Zero(assembler.dofs().count(), 3)) + ones * origin.transpose();
}

// Whether two lines leave a corner in one direction, or go on in one: no polygon has such a corner.
bool has_cusp(const Outline& loop) {
  constexpr double least_sine = 2e-3;
  return std::any_of(loop.corners.begin(), loop.corners.end(), [&](int c) {
    const Joint joint = joint_at(loop, static_cast<size_t>(c));
    return joint.incoming.cross(joint.outgoing).norm() < least_sine;
  });
}

// Whether the polygon had to give up much of its sides' lengths or of its corners' angles.
bool strained(const Outline& loop, const RegionParts& parts) {
  constexpr double degree = std::numbers::pi / 180, most = 2.1, most_length = 1.5;
  double longest = 0, shortest = std::numeric_limits<double>::infinity();
  const size_t n = parts.corners.size();
  for (size_t c = 0; c < n; ++c) {
    const DomainCorner& corner = parts.corners[c];
    const double ratio =
        std::sin(corner.domain_degrees * degree) / std::sin(corner.line_degrees * degree);
    if (!(ratio < most && ratio > 1 / most)) return true;
    double length = 0;
    size_t p = static_cast<size_t>(loop.corners[c]);
    do {
      length += loop.pieces[p].length;
      p = (p + 1) % loop.pieces.size();
    } while (!loop.is_corner(p));
    const double share = (parts.corners[(c + 1) % n].uv - corner.uv).norm() / length;
    longest = std::max(longest, share);
    shortest = std::min(shortest, share);
  }
  return longest > most_length * shortest;
}

// Whether the surface of the outline alone turns over somewhere, or nearly so.
bool overturned(const RegionParts& parts, TriangleElement element, const Points& dofs) {
  constexpr double least = 0.05;
  SkinnedRegion region{"", Surface(parts.mesh, element, dofs, parts.trim), {}};
  return !(measure(region).min_jacobian_ratio >= least);
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

Vec3 first_point(const RegionParts& parts) {
  const HermiteCurve& first =
      parts.runs.empty() ? parts.embedded.front().fitted : parts.runs.front().fitted;
  return first.evaluate(first.start());
}

}  // namespace

RegionLayout::RegionLayout(std::string name, const std::vector<CharacterLine>& lines,
                           const SkinOptions& options, const Progress& progress)
    : name_(std::move(name)), options_(options) {
  for (size_t i = 0; i < lines.size(); ++i)
    for (size_t j = 0; j < i; ++j)
      if (lines[i].name == lines[j].name)
        throw InputError("two lines have the name '" + lines[i].name + "'");
  if (lines.empty()) throw InputError("region '" + name_ + "' has no lines");
  progress.at("fitting lines", 0);
  size_ = diagonal_of(lines);
  tolerance_ = options.tolerance > 0 ? options.tolerance : 1e-4 * size_;
  edge_ = options.edge_length > 0 ? options.edge_length : size_ / 20;
  join_ = std::max(tolerance_, 1e-6 * size_);
  const DomainTask task = this->task();

  using Role = CharacterLine::Role;
  std::vector<Stretch> around, rims, inner;
  for (const CharacterLine& line : lines) {
    auto& kind = line.role == Role::Outline ? around : line.role == Role::Hole ? rims : inner;
    for (Stretch& s : cut_at_corners(line, options.corner_angle)) kind.push_back(std::move(s));
  }
  const std::vector<Outline> loops =
      make_loops(around, size_, join_, options.corner_angle, options.against_first);
  const std::vector<Outline> holes =
      rims.empty() ? std::vector<Outline>() : make_loops(rims, size_, join_, options.corner_angle);
  progress.at("fitting lines", 0.5);

  using Domain = SkinOptions::Domain;
  Domain& domain = options_.domain;
  const bool two_smooth = loops.size() == 2 && loops[0].corners.empty() && loops[1].corners.empty();
  std::string to_embed;  // an outline line that has to be embedded
  for (const Stretch& s : around)
    if (s.treatment == CharacterLine::Treatment::Embedded) to_embed = s.name;
  const bool automatic = domain == Domain::Auto;
  const auto embedding = [&] {
    return projects_simply(loops[0], task) ? Domain::Plane : Domain::Sheet;
  };
  if (automatic)
    domain = two_smooth                                         ? Domain::Ring
             : loops[0].corners.size() >= 3 && to_embed.empty() ? Domain::Polygon
                                                                : embedding();
  if (automatic && domain == Domain::Polygon && loops.size() == 1 && has_cusp(loops[0]))
    domain = embedding();
  if (!to_embed.empty() && domain != Domain::Plane && domain != Domain::Sheet)
    throw InputError("line '" + to_embed +
                     "' cannot be embedded: outlines of polygons and rings are fitted (a plane "
                     "embeds them)");
  if (options_.settle && domain != Domain::Polygon)
    parts_.warnings.push_back("settle moves the corners of polygons: this domain has none to move");
  const std::vector<std::string> warnings = parts_.warnings;
  if (loops.size() > 1 && domain != Domain::Ring)
    throw InputError("the outline lines form " + std::to_string(loops.size()) + " loops, with '" +
                     loops[0].pieces[0].stretch.name + "' and '" + loops[1].pieces[0].stretch.name +
                     "' in different ones: lines around a hole have role = \"hole\" (two smooth "
                     "loops without holes are a ring)");
  progress.at("meshing", 0);
  std::vector<Stretch> others;
  if (domain == Domain::Ring) {
    if (loops.size() != 2)
      throw InputError("a ring needs two loops of outline lines, and there are " +
                       std::to_string(loops.size()));
    parts_ = ring_parts(loops[0], loops[1], task);
    if (!holes.empty() || !inner.empty())
      embed_on_ring(Surface(parts_.mesh, options_.element,
                            plain_shape(parts_, options_.element, first_point(parts_))),
                    holes, inner, task, parts_);
  }
  if (domain == Domain::Polygon) {
    try {
      parts_ = polygon_parts(loops[0], inner, task, nullptr, others);
      // Sides that bend much while corners hardly turn leave no room in a polygon.
      if (automatic && strained(loops[0], parts_) &&
          overturned(parts_, options_.element,
                     plain_shape(parts_, options_.element, first_point(parts_))))
        domain = embedding();
    } catch (const NoPolygon&) {
      if (!automatic) throw;
      domain = embedding();
    }
    if (domain != Domain::Polygon) parts_ = {};
  }
  if (domain == Domain::Polygon) {
    constexpr int most_settlings = 3;
    for (int round = 0; options_.settle && round < most_settlings; ++round) {
      std::vector<Vec2> polygon;
      for (const DomainCorner& corner : parts_.corners) polygon.push_back(corner.uv);
      const Flattened better =
          flatten(Surface(parts_.mesh, options_.element,
                          plain_shape(parts_, options_.element, first_point(parts_))),
                  polygon);
      constexpr double worth_it = 0.95;
      if (better.expected.rms > worth_it * better.before.rms) break;
      others.clear();
      parts_ = polygon_parts(loops[0], inner, task, &better.polygon, others);
    }
    if (!holes.empty() || !others.empty()) {
      const Surface surface(parts_.mesh, options_.element,
                            plain_shape(parts_, options_.element, first_point(parts_)));
      embed_on(surface, holes, others, task, parts_);
    }
  } else if (domain == Domain::Plane) {
    parts_ = plane_parts(loops[0], holes, inner, task);
  } else if (domain == Domain::Sheet) {
    parts_ = sheet_parts(loops[0], task);
    if (!holes.empty() || !inner.empty()) {
      grade_by_curvature(parts_, task);
      cut_and_place(parts_, task);
      const Surface surface(parts_.mesh, options_.element,
                            plain_shape(parts_, options_.element, first_point(parts_)),
                            parts_.trim);
      embed_on(surface, holes, inner, task, parts_);
    }
  }
  parts_.warnings.insert(parts_.warnings.begin(), warnings.begin(), warnings.end());
  if (parts_.embedded.empty()) {
    progress.at("meshing", 1);
    return;
  }
  note_directions(parts_);
  grade_by_curvature(parts_, task);
  cut_and_place(parts_, task);
  progress.at("meshing", 0.5);
  constexpr int most_rounds = 8;
  for (int round = 0; round < most_rounds; ++round) {
    const Surface shape(parts_.mesh, options_.element,
                        plain_shape(parts_, options_.element, first_point(parts_)), parts_.trim);
    if (!refine(shape, 0.5 * tolerance_)) break;
    progress.at("meshing", 0.5 + 0.5 * (round + 1) / most_rounds);
  }
  progress.at("meshing", 1);
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
  return {name_,           Surface(parts_.mesh, options_.element, std::move(dofs), parts_.trim),
          parts_.runs,     size_,
          parts_.embedded, parts_.boundary};
}

}  // namespace batten
