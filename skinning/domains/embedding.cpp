#include <algorithm>
#include <cmath>

#include "batten/constraints/shape/embedded_rows.h"
#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/errors.h"
#include "batten/core/plane.h"
#include "batten/core/words.h"
#include "batten/fem/bisection.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/domains/domain_task.h"
#include "batten/skinning/domains/mesh_size.h"
#include "batten/skinning/region/quality.h"

namespace batten {
namespace {

// Triangles are halved where embedded lines need smaller ones.

constexpr int kGapSamples = 20;  // between points

// No triangle becomes smaller.
double smallest_size(const DomainTask& task) { return task.edge / task.size / 64; }

// Whether the mesh may be halved at the marks: most of them make two triangles of one.
bool may_halve(const RegionParts& parts, const std::vector<char>& marked, const DomainTask& task) {
  const auto more = std::count(marked.begin(), marked.end(), 1);
  return static_cast<double>(parts.mesh->triangle_count() + more) <=
         most_when_halved(task.edge, task.size);
}

void warn_of_coarse_mesh(RegionParts& parts, const DomainTask& task) {
  const std::string warning = "triangles under lines are halved no more once there are " +
                              number(most_when_halved(task.edge, task.size)) +
                              ": lines may be missed by more than " + number(task.tolerance) +
                              " (the tolerance)";
  if (std::find(parts.warnings.begin(), parts.warnings.end(), warning) == parts.warnings.end())
    parts.warnings.push_back(warning);
}

// Visits samples between the points of a line, interval by interval: `visit(interval, t)`.
template <class Visit>
void between_points(const EmbeddedLine& line, const Visit& visit) {
  // Curve nodes and sixteenths too: points may have been left out beside another line.
  std::vector<double> t = line.points;
  t.insert(t.end(), line.image.parameters().begin(), line.image.parameters().end());
  const double start = line.image.start(), span = line.image.end() - start;
  for (int k = 0; k <= 16; ++k) t.push_back(start + span * k / 16);
  std::sort(t.begin(), t.end());
  t.erase(std::unique(t.begin(), t.end(), [&](double a, double b) { return b - a < 1e-9 * span; }),
          t.end());
  for (size_t i = 0; i + 1 < t.size(); ++i)
    for (int k = 0; k <= kGapSamples; ++k)
      visit(i, line.image.mesh().wrapped(t[i] + (t[i + 1] - t[i]) * k / kGapSamples));
}

bool is_embedded(const std::vector<BoundaryPiece>& loop) {
  return std::any_of(loop.begin(), loop.end(), [](const BoundaryPiece& piece) {
    return piece.kind == BoundaryPiece::Kind::Embedded;
  });
}

// The boundary's images; pieces that are runs bound the mesh already when their whole loop is.
DomainLoops trimming_loops(const RegionParts& parts) {
  std::vector<DomainLoops::Loop> loops;
  for (const auto& pieces : parts.boundary) {
    if (!is_embedded(pieces)) continue;
    DomainLoops::Loop loop;
    for (const BoundaryPiece& piece : pieces) loop.push_back(parts.embedded[piece.index].image);
    loops.push_back(std::move(loop));
  }
  return DomainLoops(std::move(loops), is_embedded(parts.boundary[0])
                                           ? DomainLoops::Around::Outside
                                           : DomainLoops::Around::Inside);
}

// The region must be to the left of every boundary line and not to its right.
void require_simple(const RegionParts& parts, const DomainLoops& loops) {
  constexpr double aside = 1e-7;
  constexpr int samples = 8;
  for (const auto& pieces : parts.boundary)
    for (const BoundaryPiece& piece : pieces) {
      if (piece.kind != BoundaryPiece::Kind::Embedded) continue;
      const EmbeddedLine& line = parts.embedded[piece.index];
      for (int s = 0; s < line.image.segment_count(); ++s)
        for (int k = 0; k < samples; ++k) {
          const CurveMesh::Where where{s, (k + 0.5) / samples};
          const Vec2 c = flat(line.image.evaluate(where)),
                     d = flat(line.image.evaluate(where, 1)).normalized();
          const Vec2 left = c + aside * Vec2(-d.y(), d.x()),
                     right = c - aside * Vec2(-d.y(), d.x());
          if (loops.contains(left) && !loops.contains(right)) continue;
          throw InputError("line '" + line.line.name + "' does not bound the region near " +
                           at(line.fitted.evaluate(line.image.mesh().parameters()[s] +
                                                   where.s * line.image.mesh().length(s))) +
                           ": in the flat domain the outline or a hole crosses or touches itself "
                           "or another one, or a hole lies outside of the outline or in another "
                           "hole");
        }
    }
}

double distance_to_run(const ParametricMesh& mesh, const LineRun& run, const Vec2& p) {
  const Vec2 a = mesh.vertices()[run.vertices.front()], d = mesh.displacement(run.vertices);
  const Vec2 q = mesh.image_near(p, a + 0.5 * d);
  const double s = std::clamp((q - a).dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
  return (a + s * d - q).norm();
}

void place_points(RegionParts& parts, const DomainTask& task, const TriangleLocator& locator) {
  const auto always = junctions(parts, task);
  // Two rows at nearly one place would fight: the line that comes first keeps its point.
  // A line comes near itself around a tiny hole, or where junctions crowd.
  constexpr double too_near = 0.25, too_near_itself = 0.2, too_near_run = 0.05;
  std::vector<Vec2> taken;
  for (size_t i = 0; i < parts.embedded.size(); ++i) {
    EmbeddedLine& line = parts.embedded[i];
    line.points.clear();
    if (!line.line.holds) continue;
    const size_t others = taken.size();
    for (const double t : embedded_points(*parts.mesh, locator, line.image, {}, always[i])) {
      const Vec2 c = flat(line.image.evaluate(t));
      const Location on = locator.locate(c);
      const double h = local_size(*parts.mesh, on.triangle);
      bool free =
          domain_distance(*parts.mesh, c, parts.mesh->shape(on.triangle).point(on.L)) <= 1e-9 * h;
      for (size_t k = 0; k < taken.size() && free; ++k)
        free = domain_distance(*parts.mesh, taken[k], c) >
               (k < others ? too_near : too_near_itself) * h;
      for (const LineRun& run : parts.runs)
        free = free && distance_to_run(*parts.mesh, run, c) > too_near_run * h;
      if (!free) continue;
      line.points.push_back(t);
      taken.push_back(c);
    }
  }
}

// The runs on another mesh: `midpoint` of each edge that was halved, `number` of each vertex that
// stayed (-1: it did not); empty when none was, or all did.
void follow_runs(RegionParts& parts, const ParametricMesh& mesh, const std::vector<int>& midpoint,
                 const std::vector<int>& number) {
  for (LineRun& run : parts.runs) {
    std::vector<int> vertices{run.vertices[0]};
    std::vector<double> parameters{run.parameters[0]};
    for (size_t k = 0; k < run.edges.size(); ++k) {
      if (const int m = midpoint.empty() ? -1 : midpoint[run.edges[k]]; m >= 0) {
        vertices.push_back(m);
        parameters.push_back(0.5 * (run.parameters[k] + run.parameters[k + 1]));
      }
      vertices.push_back(run.vertices[k + 1]);
      parameters.push_back(run.parameters[k + 1]);
    }
    for (int& v : vertices) {
      if (!number.empty()) v = number[v];
      if (v < 0)
        throw InputError("a hole reaches beyond line '" + run.line.name +
                         "': it must lie inside of the region");
    }
    run.vertices = vertices;
    run.parameters = parameters;
    run.edges.clear();
    for (size_t k = 0; k + 1 < vertices.size(); ++k) {
      run.edges.push_back(mesh.edge_between(vertices[k], vertices[k + 1]));
      if (run.edges.back() < 0)
        throw InputError("a hole crosses line '" + run.line.name +
                         "': it must lie inside of the region");
    }
  }
}

// Drops what lies outside of the embedded boundary.
void cut(RegionParts& parts) {
  const DomainLoops loops = trimming_loops(parts);
  if (loops.arcs().empty()) return;
  require_simple(parts, loops);
  const Trim whole(*parts.mesh, loops);
  std::vector<int> kept;
  for (int t = 0; t < parts.mesh->triangle_count(); ++t)
    if (whole.side(t) != Trim::Side::Outside) kept.push_back(t);
  // Of holes alone it is not known: a mesh that was cut before has lost what lies in them.
  const bool bounded = loops.around() == DomainLoops::Around::Outside;
  const double expected = loops.area();
  if (bounded && !(std::abs(whole.area() - expected) <= 1e-7 * expected))
    throw NoSolutionError("the cut triangles hold an area of " + number(whole.area()) +
                          " and the " + "outline encloses " + number(expected) +
                          ": the outline leaves the mesh, or runs along an element edge");
  MeshPart part = part_of(*parts.mesh, kept);
  follow_runs(parts, part.mesh, {}, part.vertex);
  parts.mesh = std::make_shared<ParametricMesh>(std::move(part.mesh));
  parts.trim = std::make_shared<Trim>(whole.restricted(kept));
}

void require_inner_lines_inside(const RegionParts& parts, const DomainTask& task,
                                const TriangleLocator& locator) {
  for (const EmbeddedLine& line : parts.embedded) {
    if (line.line.role != CharacterLine::Role::Inner) continue;
    constexpr int samples = 16;
    const double slack = 2 * task.join / task.size + 1e-9;
    const Vec2 ends[2] = {flat(line.image.evaluate(line.image.start())),
                          flat(line.image.evaluate(line.image.end()))};
    for (int s = 0; s < line.image.segment_count(); ++s)
      for (int k = 0; k <= samples; ++k) {
        const CurveMesh::Where where{s, static_cast<double>(k) / samples};
        const Vec2 c = flat(line.image.evaluate(where));
        // Ends on the boundary may lie a hair outside.
        if (std::min((c - ends[0]).norm(), (c - ends[1]).norm()) <= slack) continue;
        const Location on = locator.locate(c);
        const bool inside =
            domain_distance(*parts.mesh, c, parts.mesh->shape(on.triangle).point(on.L)) <= 1e-9 &&
            (!parts.trim || parts.trim->loops().contains(parts.mesh->wrapped(c)));
        if (!inside)
          throw InputError("inner line '" + line.line.name + "' leaves the region near " +
                           at(line.fitted.evaluate(line.image.parameters()[s] +
                                                   where.s * line.image.mesh().length(s))));
      }
  }
}

}  // namespace

void grade_by_curvature(RegionParts& parts, const DomainTask& task) {
  const double smallest = smallest_size(task);
  for (int round = 0; round < 24; ++round) {
    const TriangleLocator locator(*parts.mesh);
    std::vector<char> marked(parts.mesh->triangle_count(), 0);
    bool any = false;
    for (const EmbeddedLine& line : parts.embedded) {
      constexpr int samples = 24;
      for (int s = 0; s < line.image.segment_count(); ++s)
        for (int k = 0; k < samples; ++k) {
          const CurveMesh::Where where{s, (k + 0.5) / samples};
          const Vec2 d = flat(line.image.evaluate(where, 1)),
                     dd = flat(line.image.evaluate(where, 2));
          const double curvature = std::abs(cross(d, dd)) / std::pow(d.norm(), 3);
          const int t = locator.locate(flat(line.image.evaluate(where))).triangle;
          const double h = local_size(*parts.mesh, t);
          if (!(2 * h * curvature > 1) || h < 2 * smallest) continue;
          marked[t] = 1;
          any = true;
        }
    }
    if (!any || !may_halve(parts, marked, task)) return;
    halve(parts, marked);
  }
}

// Of a line that only trims, `fitted` is the surface's own once it has a shape.
double line_gap(const Surface& surface, const EmbeddedLine& line) {
  const TriangleLocator locator(surface.mesh());
  double largest = 0;
  between_points(line, [&](size_t, double t) {
    const double gap =
        (surface.position(locator.locate(flat(line.image.evaluate(t)))) - line.fitted.evaluate(t))
            .norm();
    if (!(gap <= largest) && !std::isnan(largest)) largest = gap;
  });
  return largest;
}

bool refine_at_gaps(RegionParts& parts, const Surface& surface, double target,
                    const DomainTask& task) {
  const double smallest = smallest_size(task);
  const TriangleLocator locator(*parts.mesh);
  std::vector<std::vector<double>> gaps(parts.embedded.size());  // by line and interval
  bool missed = false;
  for (size_t l = 0; l < gaps.size(); ++l) {
    const EmbeddedLine& line = parts.embedded[l];
    if (!line.line.holds) continue;
    between_points(line, [&](size_t interval, double t) {
      if (interval >= gaps[l].size()) gaps[l].resize(interval + 1, 0);
      const Location where = locator.locate(flat(line.image.evaluate(t)));
      const double gap = (surface.position(where) - line.fitted.evaluate(t)).norm();
      gaps[l][interval] = std::max(gaps[l][interval], gap);
      missed = missed || gap > target;
    });
  }
  if (!missed) return false;

  // Two halvings halve the size, and the gap falls to about an eighth.
  bool any = false;
  constexpr int most = 6;
  for (int pass = 0; pass < most; ++pass) {
    const TriangleLocator now(*parts.mesh);
    std::vector<char> marked(parts.mesh->triangle_count(), 0);
    bool here = false;
    for (size_t l = 0; l < gaps.size(); ++l) {
      if (gaps[l].empty()) continue;
      between_points(parts.embedded[l], [&](size_t interval, double t) {
        if (gaps[l][interval] * std::pow(8.0, -0.5 * pass) <= target) return;
        const int triangle = now.locate(flat(parts.embedded[l].image.evaluate(t))).triangle;
        if (local_size(*parts.mesh, triangle) < 1.5 * smallest) return;
        marked[triangle] = 1;
        here = true;
      });
    }
    if (!here) break;
    if (!may_halve(parts, marked, task)) {
      warn_of_coarse_mesh(parts, task);
      break;
    }
    any = true;
    halve(parts, marked);
  }
  if (!any) return false;
  cut_and_place(parts, task);
  return true;
}

std::vector<char> boundary_lines(const RegionParts& parts) {
  std::vector<char> bounds(parts.embedded.size(), 0);
  for (const auto& pieces : parts.boundary)
    for (const BoundaryPiece& piece : pieces)
      if (piece.kind == BoundaryPiece::Kind::Embedded) bounds[piece.index] = 1;
  return bounds;
}

void halve(RegionParts& parts, const std::vector<char>& marked) {
  Bisection halved = bisected(*parts.mesh, marked);
  follow_runs(parts, halved.mesh, halved.midpoint, {});
  parts.mesh = std::make_shared<ParametricMesh>(std::move(halved.mesh));
}

void cut_and_place(RegionParts& parts, const DomainTask& task) {
  cut(parts);
  const TriangleLocator locator(*parts.mesh);
  require_inner_lines_inside(parts, task, locator);
  place_points(parts, task, locator);
}

ConstraintSet line_rows(const RegionParts& parts, TriangleElement element) {
  const ParametricMesh& mesh = *parts.mesh;
  ConstraintSet set(DofMap(mesh).count());
  ShapeConstraints shape(mesh, element, set);
  for (const LineRun& run : parts.runs)
    shape.curve(run.line.name, run.vertices, run.parameters, run.fitted,
                mesh.displacement(run.vertices));
  if (parts.embedded.empty()) return set;
  const TriangleLocator locator(mesh);
  EmbeddedRows rows(mesh, element, locator, set);
  for (const EmbeddedLine& line : parts.embedded)
    rows.points(line.line.name, line.image, line.fitted, line.points);
  return set;
}

}  // namespace batten
