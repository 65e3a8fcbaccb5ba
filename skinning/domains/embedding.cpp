// SPDX-License-Identifier: MPL-2.0
#include <algorithm>
#include <cmath>

#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fem/refinement.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/domains/domain_input.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {
namespace {

// Local refinement under embedded lines.

constexpr int kGapSamples = 20;  // per interval between collocation points

// Lower limit of triangle sizes in the domain.
double smallest_size(const DomainInput& task) { return task.options.edge_length / task.size / 64; }

// True if the mesh may be bisected at the marks; most marked triangles become two.
bool may_bisect(const RegionGeometry& geometry, const std::vector<char>& marked,
                const DomainInput& task) {
  const auto more = std::count(marked.begin(), marked.end(), 1);
  return static_cast<double>(geometry.mesh->triangle_count() + more) <=
         max_refined_triangles(task.options.edge_length, task.size);
}

void warn_of_coarse_mesh(RegionGeometry& geometry, const DomainInput& task) {
  const std::string warning =
      "the mesh was not refined beyond " +
      format_number(max_refined_triangles(task.options.edge_length, task.size)) +
      " triangles: the surface may miss embedded curves by more than the tolerance " +
      format_number(task.options.tolerance);
  if (std::find(geometry.warnings.begin(), geometry.warnings.end(), warning) ==
      geometry.warnings.end())
    geometry.warnings.push_back(warning);
}

// Samples a line interval by interval, between collocation points, and calls `visit(interval, t)`.
template <class Visit>
void between_points(const EmbeddedLine& line, const Visit& visit) {
  // Nodes and sixteenths of the curve also end intervals, because collocation points may have been
  // left out next to another line.
  std::vector<double> t = line.points;
  t.insert(t.end(), line.pcurve.parameters().begin(), line.pcurve.parameters().end());
  const double start = line.pcurve.start(), span = line.pcurve.end() - start;
  for (int k = 0; k <= 16; ++k) t.push_back(start + span * k / 16);
  std::sort(t.begin(), t.end());
  t.erase(std::unique(t.begin(), t.end(), [&](double a, double b) { return b - a < 1e-9 * span; }),
          t.end());
  for (size_t i = 0; i + 1 < t.size(); ++i)
    for (int k = 0; k <= kGapSamples; ++k)
      visit(i, line.pcurve.mesh().wrapped(t[i] + (t[i + 1] - t[i]) * k / kGapSamples));
}

bool is_embedded(const std::vector<BoundarySegment>& loop) {
  return std::any_of(loop.begin(), loop.end(), [](const BoundarySegment& piece) {
    return piece.kind == BoundarySegment::Kind::Embedded;
  });
}

// Boundary loops that trim the mesh. A loop of edge-aligned lines only bounds the mesh already.
DomainLoops trimming_loops(const RegionGeometry& geometry) {
  std::vector<DomainLoops::Loop> loops;
  for (const auto& segments : geometry.boundary) {
    if (!is_embedded(segments)) continue;
    DomainLoops::Loop loop;
    for (const BoundarySegment& piece : segments)
      loop.push_back(geometry.embedded[piece.index].pcurve);
    loops.push_back(std::move(loop));
  }
  return DomainLoops(std::move(loops), is_embedded(geometry.boundary[0])
                                           ? DomainLoops::Background::Outside
                                           : DomainLoops::Background::Inside);
}

// Throws unless the region is to the left of every embedded boundary line, and not to its right.
void require_simple(const RegionGeometry& geometry, const DomainLoops& loops) {
  constexpr double aside = 1e-7;
  constexpr int samples = 8;
  for (const auto& segments : geometry.boundary)
    for (const BoundarySegment& piece : segments) {
      if (piece.kind != BoundarySegment::Kind::Embedded) continue;
      const EmbeddedLine& line = geometry.embedded[piece.index];
      for (int s = 0; s < line.pcurve.segment_count(); ++s)
        for (int k = 0; k < samples; ++k) {
          const CurveMesh::SegmentPoint where{s, (k + 0.5) / samples};
          const Vec2 c = drop_z(line.pcurve.evaluate(where)),
                     d = drop_z(line.pcurve.evaluate(where, 1)).normalized();
          const Vec2 left = c + aside * Vec2(-d.y(), d.x()),
                     right = c - aside * Vec2(-d.y(), d.x());
          if (loops.contains(left) && !loops.contains(right)) continue;
          throw InputError(
              "curve '" + line.line.name + "' does not bound the face near " +
              format_point(line.fitted.evaluate(line.pcurve.mesh().parameters()[s] +
                                                where.s * line.pcurve.mesh().length(s))) +
              ": in the parameter domain, the outline or a hole intersects or touches itself "
              "or another one, or a hole lies outside of the outline or in another hole");
        }
    }
}

double distance_to_aligned_line(const ParametricMesh& mesh, const EdgeAlignedLine& aligned_line,
                                const Vec2& p) {
  const Vec2 a = mesh.vertices()[aligned_line.vertices.front()],
             d = mesh.chain_vector(aligned_line.vertices);
  const Vec2 q = mesh.image_near(p, a + 0.5 * d);
  const double s = std::clamp((q - a).dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
  return (a + s * d - q).norm();
}

void place_points(RegionGeometry& geometry, const DomainInput& task,
                  const TriangleLocator& locator) {
  const auto always = find_junctions(geometry, task);
  // Two constraints at nearly the same point are ill-conditioned: the line that comes first keeps
  // its point. A line comes near itself around a tiny hole, or where junctions crowd.
  constexpr double too_near = 0.25, too_near_itself = 0.2, too_near_aligned = 0.05;
  std::vector<Vec2> taken;
  for (size_t i = 0; i < geometry.embedded.size(); ++i) {
    EmbeddedLine& line = geometry.embedded[i];
    line.points.clear();
    if (!line.line.constrains_surface) continue;
    const size_t others = taken.size();
    for (const double t :
         embedded_point_parameters(*geometry.mesh, locator, line.pcurve, {}, always[i])) {
      const Vec2 c = drop_z(line.pcurve.evaluate(t));
      const Location on = locator.locate(c);
      const double h = local_size(*geometry.mesh, on.triangle);
      bool free = domain_distance(*geometry.mesh, c,
                                  geometry.mesh->shape(on.triangle).point(on.L)) <= 1e-9 * h;
      for (size_t k = 0; k < taken.size() && free; ++k)
        free = domain_distance(*geometry.mesh, taken[k], c) >
               (k < others ? too_near : too_near_itself) * h;
      for (const EdgeAlignedLine& aligned_line : geometry.edge_aligned)
        free = free &&
               distance_to_aligned_line(*geometry.mesh, aligned_line, c) > too_near_aligned * h;
      if (!free) continue;
      line.points.push_back(t);
      taken.push_back(c);
    }
  }
}

// Transfers edge-aligned lines to another mesh. `midpoint`: new vertex on each bisected edge, or
// empty if none was bisected. `number`: new number of each vertex, -1 if it was dropped, or empty
// if none was.
void update_aligned_lines(RegionGeometry& geometry, const ParametricMesh& mesh,
                          const std::vector<int>& midpoint, const std::vector<int>& number) {
  for (EdgeAlignedLine& aligned_line : geometry.edge_aligned) {
    std::vector<int> vertices{aligned_line.vertices[0]};
    std::vector<double> parameters{aligned_line.parameters[0]};
    for (size_t k = 0; k < aligned_line.edges.size(); ++k) {
      if (const int m = midpoint.empty() ? -1 : midpoint[aligned_line.edges[k]]; m >= 0) {
        vertices.push_back(m);
        parameters.push_back(0.5 * (aligned_line.parameters[k] + aligned_line.parameters[k + 1]));
      }
      vertices.push_back(aligned_line.vertices[k + 1]);
      parameters.push_back(aligned_line.parameters[k + 1]);
    }
    for (int& v : vertices) {
      if (!number.empty()) v = number[v];
      if (v < 0)
        throw InputError("a hole extends beyond curve '" + aligned_line.line.name +
                         "', expected it inside of the face");
    }
    aligned_line.vertices = vertices;
    aligned_line.parameters = parameters;
    aligned_line.edges.clear();
    for (size_t k = 0; k + 1 < vertices.size(); ++k) {
      aligned_line.edges.push_back(mesh.edge_between(vertices[k], vertices[k + 1]));
      if (aligned_line.edges.back() < 0)
        throw InputError("a hole intersects curve '" + aligned_line.line.name +
                         "', expected it inside of the face");
    }
  }
}

// Drops the triangles outside of the embedded boundary.
void cut(RegionGeometry& geometry) {
  const DomainLoops loops = trimming_loops(geometry);
  if (loops.segments().empty()) return;
  require_simple(geometry, loops);
  const Trim whole(*geometry.mesh, loops);
  std::vector<int> kept;
  for (int t = 0; t < geometry.mesh->triangle_count(); ++t)
    if (whole.side(t) != Trim::Side::Outside) kept.push_back(t);
  // Checked only for an embedded outline. With holes alone the expected area is unknown, because a
  // mesh that was trimmed before has lost the triangles inside of them.
  const bool bounded = loops.background() == DomainLoops::Background::Outside;
  const double expected = loops.area();
  if (bounded && !(std::abs(whole.area() - expected) <= 1e-7 * expected))
    throw NoSolutionError("found the area " + format_number(whole.area()) +
                          " of the trimmed mesh, expected the area " + format_number(expected) +
                          " of the outline: it leaves the mesh, or runs along an element edge");
  Submesh part = extract_submesh(*geometry.mesh, kept);
  update_aligned_lines(geometry, part.mesh, {}, part.vertex);
  geometry.mesh = std::make_shared<ParametricMesh>(std::move(part.mesh));
  geometry.trim = std::make_shared<Trim>(whole.restricted(kept));
}

void require_inner_lines_inside(const RegionGeometry& geometry, const DomainInput& task,
                                const TriangleLocator& locator) {
  for (const EmbeddedLine& line : geometry.embedded) {
    if (line.line.role != CharacterLine::Role::Inner) continue;
    constexpr int samples = 16;
    const double slack = 2 * task.gap_tolerance / task.size + 1e-9;
    const Vec2 ends[2] = {drop_z(line.pcurve.evaluate(line.pcurve.start())),
                          drop_z(line.pcurve.evaluate(line.pcurve.end()))};
    for (int s = 0; s < line.pcurve.segment_count(); ++s)
      for (int k = 0; k <= samples; ++k) {
        const CurveMesh::SegmentPoint where{s, static_cast<double>(k) / samples};
        const Vec2 c = drop_z(line.pcurve.evaluate(where));
        // Ends on the boundary may lie slightly outside.
        if (std::min((c - ends[0]).norm(), (c - ends[1]).norm()) <= slack) continue;
        const Location on = locator.locate(c);
        const bool inside =
            domain_distance(*geometry.mesh, c, geometry.mesh->shape(on.triangle).point(on.L)) <=
                1e-9 &&
            (!geometry.trim || geometry.trim->loops().contains(geometry.mesh->wrapped(c)));
        if (!inside)
          throw InputError(
              "inner curve '" + line.line.name + "' leaves the face near " +
              format_point(line.fitted.evaluate(line.pcurve.parameters()[s] +
                                                where.s * line.pcurve.mesh().length(s))));
      }
  }
}

}  // namespace

void refine_by_curvature(RegionGeometry& geometry, const DomainInput& task) {
  const double smallest = smallest_size(task);
  for (int round = 0; round < 24; ++round) {
    const TriangleLocator locator(*geometry.mesh);
    std::vector<char> marked(geometry.mesh->triangle_count(), 0);
    bool any = false;
    for (const EmbeddedLine& line : geometry.embedded) {
      constexpr int samples = 24;
      for (int s = 0; s < line.pcurve.segment_count(); ++s)
        for (int k = 0; k < samples; ++k) {
          const CurveMesh::SegmentPoint where{s, (k + 0.5) / samples};
          const Vec2 d = drop_z(line.pcurve.evaluate(where, 1)),
                     dd = drop_z(line.pcurve.evaluate(where, 2));
          const double curvature = std::abs(cross(d, dd)) / std::pow(d.norm(), 3);
          const int t = locator.locate(drop_z(line.pcurve.evaluate(where))).triangle;
          const double h = local_size(*geometry.mesh, t);
          if (!(2 * h * curvature > 1) || h < 2 * smallest) continue;
          marked[t] = 1;
          any = true;
        }
    }
    if (!any || !may_bisect(geometry, marked, task)) return;
    bisect_marked(geometry, marked);
  }
}

// If a line only trims the surface, `fitted` is a curve on the surface once the region has a shape.
double line_gap(const Surface& surface, const EmbeddedLine& line) {
  const TriangleLocator locator(surface.mesh());
  double largest = 0;
  between_points(line, [&](size_t, double t) {
    const double gap = (surface.position(locator.locate(drop_z(line.pcurve.evaluate(t)))) -
                        line.fitted.evaluate(t))
                           .norm();
    if (!(gap <= largest) && !std::isnan(largest)) largest = gap;
  });
  return largest;
}

bool refine_at_gaps(RegionGeometry& geometry, const Surface& surface, double target,
                    const DomainInput& task) {
  const double smallest = smallest_size(task);
  const TriangleLocator locator(*geometry.mesh);
  std::vector<std::vector<double>> gaps(geometry.embedded.size());  // by line and interval
  bool missed = false;
  for (size_t l = 0; l < gaps.size(); ++l) {
    const EmbeddedLine& line = geometry.embedded[l];
    if (!line.line.constrains_surface) continue;
    between_points(line, [&](size_t interval, double t) {
      if (interval >= gaps[l].size()) gaps[l].resize(interval + 1, 0);
      const Location where = locator.locate(drop_z(line.pcurve.evaluate(t)));
      const double gap = (surface.position(where) - line.fitted.evaluate(t)).norm();
      gaps[l][interval] = std::max(gaps[l][interval], gap);
      missed = missed || gap > target;
    });
  }
  if (!missed) return false;

  // Two bisections halve the size; the gap falls to about an eighth.
  bool any = false;
  constexpr int most = 6;
  for (int pass = 0; pass < most; ++pass) {
    const TriangleLocator now(*geometry.mesh);
    std::vector<char> marked(geometry.mesh->triangle_count(), 0);
    bool here = false;
    for (size_t l = 0; l < gaps.size(); ++l) {
      if (gaps[l].empty()) continue;
      between_points(geometry.embedded[l], [&](size_t interval, double t) {
        if (gaps[l][interval] * std::pow(8.0, -0.5 * pass) <= target) return;
        const int triangle = now.locate(drop_z(geometry.embedded[l].pcurve.evaluate(t))).triangle;
        if (local_size(*geometry.mesh, triangle) < 1.5 * smallest) return;
        marked[triangle] = 1;
        here = true;
      });
    }
    if (!here) break;
    if (!may_bisect(geometry, marked, task)) {
      warn_of_coarse_mesh(geometry, task);
      break;
    }
    any = true;
    bisect_marked(geometry, marked);
  }
  if (!any) return false;
  trim_and_collocate(geometry, task);
  return true;
}

std::vector<char> boundary_line_flags(const RegionGeometry& geometry) {
  std::vector<char> bounds(geometry.embedded.size(), 0);
  for (const auto& segments : geometry.boundary)
    for (const BoundarySegment& piece : segments)
      if (piece.kind == BoundarySegment::Kind::Embedded) bounds[piece.index] = 1;
  return bounds;
}

void bisect_marked(RegionGeometry& geometry, const std::vector<char>& marked) {
  Bisection halved = bisected(*geometry.mesh, marked);
  update_aligned_lines(geometry, halved.mesh, halved.midpoint, {});
  geometry.mesh = std::make_shared<ParametricMesh>(std::move(halved.mesh));
}

void trim_and_collocate(RegionGeometry& geometry, const DomainInput& task) {
  cut(geometry);
  const TriangleLocator locator(*geometry.mesh);
  require_inner_lines_inside(geometry, task, locator);
  place_points(geometry, task, locator);
}

ConstraintSet make_line_constraints(const RegionGeometry& geometry, TriangleElement element) {
  const ParametricMesh& mesh = *geometry.mesh;
  ConstraintSet set(DofMap(mesh).count());
  SurfaceConstraints shape(mesh, element, set);
  for (const EdgeAlignedLine& aligned_line : geometry.edge_aligned)
    shape.curve(aligned_line.line.name, aligned_line.vertices, aligned_line.parameters,
                aligned_line.fitted, mesh.chain_vector(aligned_line.vertices));
  if (geometry.embedded.empty()) return set;
  const TriangleLocator locator(mesh);
  EmbeddedLineConstraints rows(mesh, element, locator, set);
  for (const EmbeddedLine& line : geometry.embedded)
    rows.points(line.line.name, line.pcurve, line.fitted, line.points);
  return set;
}

}  // namespace batten
