// The mesh of a polygon, and the runs of element edges on its strips.
#include <algorithm>
#include <cmath>
#include <map>

#include "batten/core/errors.h"
#include "batten/core/format.h"
#include "batten/core/isize.h"
#include "batten/core/planar_geometry.h"
#include "batten/skinning/domains/mesh_limits.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/domains/polygon_domain.h"

namespace batten {
namespace {

// Exactly the given vertices, in the strip's direction.
void fix_nodes(AlignedSegment& aligned_segment) {
  const HermiteCurve& curve = aligned_segment.line.prescribed->curve;
  const double span = curve.end() - curve.start();
  aligned_segment.nodes.clear();
  for (const double u : aligned_segment.line.prescribed->vertices) {
    const double fraction = (u - curve.start()) / span;
    aligned_segment.nodes.push_back(aligned_segment.flipped ? 1 - fraction : fraction);
  }
  if (aligned_segment.flipped)
    std::reverse(aligned_segment.nodes.begin(), aligned_segment.nodes.end());
}

ParametricMesh delaunay(PolygonDomain& domain) {
  PlanarMeshInput task;
  task.edge_length = round_to_grid(domain.task.edge_length / domain.task.size);
  task.keep_segments = domain.prescribed();
  task.size_field = domain.task.options.size_field;
  task.progress = domain.task.progress;
  // Points that strips share (corners, joints, junctions) are one point.
  std::map<std::pair<long long, long long>, int> known;
  const auto add = [&](const Vec2& p) {
    constexpr double cell = 1e11;
    const std::pair key(std::llround(p.x() * cell), std::llround(p.y() * cell));
    for (long long dx = -1; dx <= 1; ++dx)
      for (long long dy = -1; dy <= 1; ++dy)
        if (const auto it = known.find({key.first + dx, key.second + dy}); it != known.end())
          return it->second;
    task.points.push_back(p);
    return known[key] = isize(task.points) - 1;
  };
  for (const Vec2& corner : domain.polygon) add(corner);
  for (size_t i = 0; i < domain.aligned_segments.size(); ++i) {
    AlignedSegment& s = domain.aligned_segments[i];
    auto& segments = i < domain.outline.segments.size() ? task.outline : task.inner;
    int last = add(s.from);
    if (s.prescribed()) {
      s.points = {last};
      for (size_t k = 1; k < s.nodes.size(); ++k) {
        const int next = add(k + 1 == s.nodes.size() ? s.to : s.at(s.nodes[k]));
        if (next == last || (k > 1 && next == s.points.front()))
          throw InputError("line '" + s.line.name +
                           "' is given with vertices that lie on each other, near " +
                           format_point(s.fitted.evaluate(s.fitted.start())));
        segments.push_back({last, next});
        s.points.push_back(last = next);
      }
      continue;
    }
    for (size_t k = 0; k + 1 < s.nodes.size(); ++k) {
      const double a = s.nodes[k], b = s.nodes[k + 1];
      const int cuts = std::max(
          1,
          static_cast<int>(std::ceil((b - a) * (s.to - s.from).norm() / task.edge_length - 0.2)));
      for (int c = 1; c <= cuts; ++c) {
        const double fraction = a + (b - a) * c / cuts;
        const int next = fraction >= 1 ? add(s.to) : add(s.at(round_to_grid(fraction)));
        if (next == last) continue;
        segments.push_back({last, next});
        last = next;
      }
    }
  }
  return delaunay_mesh(task);
}

bool cut_evenly(const AlignedSegment& s, int refinements) {
  return std::all_of(s.nodes.begin(), s.nodes.end(), [&](double fraction) {
    const double place = std::ldexp(fraction, refinements);
    return std::abs(place - std::round(place)) < 1e-6;
  });
}

ParametricMesh fan(const PolygonDomain& domain) {
  if (domain.prescribed())
    throw InputError("the fan mesher takes no given curves: use mesher = \"delaunay\"");
  PlanarMeshInput task;
  task.points = domain.polygon;
  const int n = isize(domain.polygon);
  double longest = 0;
  for (int i = 0; i < n; ++i) {
    task.outline.push_back({i, (i + 1) % n});
    longest = std::max(longest, (domain.polygon[(i + 1) % n] - domain.polygon[i]).norm());
  }
  if (!domain.aligned_inner.empty())
    throw InputError("the fan mesher takes no inner lines: use mesher = \"delaunay\"");
  if (domain.outline.segments.size() != domain.polygon.size())
    throw InputError("the fan mesher needs one line for each side between corners, and there are " +
                     std::to_string(domain.outline.segments.size()) + " lines for " +
                     std::to_string(n) + " sides: use mesher = \"delaunay\"");
  int refinements = domain.task.options.fan_refinements;
  if (refinements < 0) {
    refinements = 0;
    while (longest > 1.3 * round_to_grid(domain.task.edge_length / domain.task.size) *
                         std::pow(2.0, refinements) &&
           refinements < 9)
      ++refinements;
    for (const AlignedSegment& s : domain.aligned_segments)
      while (!cut_evenly(s, refinements) && refinements < 9) ++refinements;
  }
  for (const AlignedSegment& s : domain.aligned_segments)
    if (!cut_evenly(s, refinements))
      throw InputError("line '" + s.line.name + "' needs nodes that a fan refined " +
                       std::to_string(refinements) +
                       " times does not have: raise the tolerance or the refinements, or use "
                       "mesher = \"delaunay\"");
  return fan_mesh(task, refinements);
}

void find_edges(const ParametricMesh& mesh, EdgeAlignedLine& aligned_line) {
  for (size_t i = 0; i + 1 < aligned_line.vertices.size(); ++i) {
    const int e = mesh.edge_between(aligned_line.vertices[i], aligned_line.vertices[i + 1]);
    if (e < 0)
      throw NoSolutionError("the mesher left line '" + aligned_line.line.name +
                            "' without an edge at (" +
                            format_number(mesh.vertices()[aligned_line.vertices[i]].x()) + ", " +
                            format_number(mesh.vertices()[aligned_line.vertices[i]].y()) + ")");
    aligned_line.edges.push_back(e);
  }
}

}  // namespace

ParametricMesh mesh_polygon(PolygonDomain& domain) {
  double area = 0;
  for (size_t i = 0, n = domain.polygon.size(); i < n; ++i)
    area += 0.5 * cross(domain.polygon[i], domain.polygon[(i + 1) % n]);
  // Equilateral triangles of that edge, or the fan's.
  const bool counted = domain.task.options.mesher == SkinOptions::Mesher::Fan &&
                       domain.task.options.fan_refinements >= 0;
  const double expected =
      counted ? static_cast<double>(domain.polygon.size()) *
                    std::pow(4.0, domain.task.options.fan_refinements)
              : area * domain.task.size * domain.task.size /
                    (std::sqrt(3.0) / 4 * domain.task.edge_length * domain.task.edge_length);
  if (counted && expected > kMaxTriangles)
    throw InputError("a fan refined " + std::to_string(domain.task.options.fan_refinements) +
                     " times has " + format_number(expected) + " triangles; at most " +
                     format_number(kMaxTriangles) + " are allowed");
  require_mesh_size(expected, domain.task.edge_length, domain.task.size, "a region");
  for (AlignedSegment& s : domain.aligned_segments) {
    if (s.prescribed()) {
      fix_nodes(s);
      continue;
    }
    for (const double u : s.fitted.parameters()) s.nodes.push_back(u / s.fitted.end());
    std::sort(s.nodes.begin(), s.nodes.end());
  }
  return domain.task.options.mesher == SkinOptions::Mesher::Fan ? fan(domain) : delaunay(domain);
}

EdgeAlignedLine edge_aligned_line_on(const ParametricMesh& mesh,
                                     const AlignedSegment& aligned_segment) {
  if (aligned_segment.prescribed()) {
    EdgeAlignedLine aligned_line{aligned_segment.line,
                                 aligned_segment.line.prescribed->curve,
                                 aligned_segment.points,
                                 aligned_segment.line.prescribed->vertices,
                                 {}};
    if (aligned_segment.flipped)
      std::reverse(aligned_line.vertices.begin(), aligned_line.vertices.end());
    find_edges(mesh, aligned_line);
    return aligned_line;
  }
  // Vertices on the strip, by their fraction along it.
  const Vec2 d = aligned_segment.to - aligned_segment.from;
  const double length = d.norm();
  std::vector<std::pair<double, int>> on_segment;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const Vec2 p = mesh.vertices()[v] - aligned_segment.from;
    const double fraction = p.dot(d) / (length * length);
    constexpr double near = 1e-11;
    if (std::abs(cross(p, d)) / length < near && fraction > -near && fraction < 1 + near)
      on_segment.emplace_back(std::clamp(fraction, 0.0, 1.0), v);
  }
  std::sort(on_segment.begin(), on_segment.end());
  EdgeAlignedLine aligned_line;
  aligned_line.line = aligned_segment.line;
  aligned_line.fitted =
      aligned_segment.flipped ? aligned_segment.fitted.backwards() : aligned_segment.fitted;
  if (aligned_segment.flipped) {
    std::reverse(on_segment.begin(), on_segment.end());
    for (auto& [fraction, v] : on_segment) fraction = 1 - fraction;
  }
  for (const auto& [fraction, v] : on_segment) {
    aligned_line.vertices.push_back(v);
    aligned_line.parameters.push_back(fraction * aligned_segment.fitted.end());
  }
  find_edges(mesh, aligned_line);
  return aligned_line;
}

}  // namespace batten
