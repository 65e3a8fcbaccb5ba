#include <algorithm>
#include <cmath>

#include "batten/constraints/shape/embedded_rows.h"
#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/errors.h"
#include "batten/core/plane.h"
#include "batten/core/words.h"
#include "batten/fem/bisection.h"
#include "batten/skinning/domains/domain_task.h"

namespace batten {
namespace {

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
