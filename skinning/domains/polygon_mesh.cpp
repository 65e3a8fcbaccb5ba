// The mesh of a polygon, and the runs of element edges on its strips.
#include <algorithm>
#include <cmath>
#include <map>

#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/core/plane.h"
#include "batten/core/words.h"
#include "batten/skinning/domains/mesh_size.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/domains/polygon_plan.h"

namespace batten {
namespace {

// Exactly the given vertices, in the strip's direction.
void fix_nodes(Strip& strip) {
  const HermiteCurve& curve = strip.line.given->curve;
  const double span = curve.end() - curve.start();
  strip.nodes.clear();
  for (const double u : strip.line.given->vertices) {
    const double fraction = (u - curve.start()) / span;
    strip.nodes.push_back(strip.flipped ? 1 - fraction : fraction);
  }
  if (strip.flipped) std::reverse(strip.nodes.begin(), strip.nodes.end());
}

ParametricMesh delaunay(PolygonPlan& plan) {
  MeshTask task;
  task.edge_length = rounded(plan.task.edge / plan.task.size);
  task.keep_segments = plan.given();
  task.sizes = plan.task.options.sizes;
  task.progress = plan.task.progress;
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
    return known[key] = count_of(task.points) - 1;
  };
  for (const Vec2& corner : plan.polygon) add(corner);
  for (size_t i = 0; i < plan.strips.size(); ++i) {
    Strip& s = plan.strips[i];
    auto& segments = i < plan.outline.pieces.size() ? task.outline : task.inner;
    int last = add(s.from);
    if (s.given()) {
      s.points = {last};
      for (size_t k = 1; k < s.nodes.size(); ++k) {
        const int next = add(k + 1 == s.nodes.size() ? s.to : s.at(s.nodes[k]));
        if (next == last || (k > 1 && next == s.points.front()))
          throw InputError("line '" + s.line.name +
                           "' is given with vertices that lie on each other, near " +
                           at(s.fitted.evaluate(s.fitted.start())));
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
        const int next = fraction >= 1 ? add(s.to) : add(s.at(rounded(fraction)));
        if (next == last) continue;
        segments.push_back({last, next});
        last = next;
      }
    }
  }
  return delaunay_mesh(task);
}

bool cut_evenly(const Strip& s, int refinements) {
  return std::all_of(s.nodes.begin(), s.nodes.end(), [&](double fraction) {
    const double place = std::ldexp(fraction, refinements);
    return std::abs(place - std::round(place)) < 1e-6;
  });
}

ParametricMesh fan(const PolygonPlan& plan) {
  if (plan.given())
    throw InputError("the fan mesher takes no given curves: use mesher = \"delaunay\"");
  MeshTask task;
  task.points = plan.polygon;
  const int n = count_of(plan.polygon);
  double longest = 0;
  for (int i = 0; i < n; ++i) {
    task.outline.push_back({i, (i + 1) % n});
    longest = std::max(longest, (plan.polygon[(i + 1) % n] - plan.polygon[i]).norm());
  }
  if (!plan.fitted_inner.empty())
    throw InputError("the fan mesher takes no inner lines: use mesher = \"delaunay\"");
  if (plan.outline.pieces.size() != plan.polygon.size())
    throw InputError("the fan mesher needs one line for each side between corners, and there are " +
                     std::to_string(plan.outline.pieces.size()) + " lines for " +
                     std::to_string(n) + " sides: use mesher = \"delaunay\"");
  int refinements = plan.task.options.fan_refinements;
  if (refinements < 0) {
    refinements = 0;
    while (longest > 1.3 * rounded(plan.task.edge / plan.task.size) * std::pow(2.0, refinements) &&
           refinements < 9)
      ++refinements;
    for (const Strip& s : plan.strips)
      while (!cut_evenly(s, refinements) && refinements < 9) ++refinements;
  }
  for (const Strip& s : plan.strips)
    if (!cut_evenly(s, refinements))
      throw InputError("line '" + s.line.name + "' needs nodes that a fan refined " +
                       std::to_string(refinements) +
                       " times does not have: raise the tolerance or the refinements, or use "
                       "mesher = \"delaunay\"");
  return fan_mesh(task, refinements);
}

void find_edges(const ParametricMesh& mesh, LineRun& run) {
  for (size_t i = 0; i + 1 < run.vertices.size(); ++i) {
    const int e = mesh.edge_between(run.vertices[i], run.vertices[i + 1]);
    if (e < 0)
      throw NoSolutionError("the mesher left line '" + run.line.name + "' without an edge at (" +
                            number(mesh.vertices()[run.vertices[i]].x()) + ", " +
                            number(mesh.vertices()[run.vertices[i]].y()) + ")");
    run.edges.push_back(e);
  }
}

}  // namespace

ParametricMesh mesh_polygon(PolygonPlan& plan) {
  double area = 0;
  for (size_t i = 0, n = plan.polygon.size(); i < n; ++i)
    area += 0.5 * cross(plan.polygon[i], plan.polygon[(i + 1) % n]);
  // Equilateral triangles of that edge, or the fan's.
  const bool counted = plan.task.options.mesher == SkinOptions::Mesher::Fan &&
                       plan.task.options.fan_refinements >= 0;
  const double expected = counted ? static_cast<double>(plan.polygon.size()) *
                                        std::pow(4.0, plan.task.options.fan_refinements)
                                  : area * plan.task.size * plan.task.size /
                                        (std::sqrt(3.0) / 4 * plan.task.edge * plan.task.edge);
  if (counted && expected > most_triangles)
    throw InputError("a fan refined " + std::to_string(plan.task.options.fan_refinements) +
                     " times has " + number(expected) + " triangles; at most " +
                     number(most_triangles) + " are allowed");
  require_mesh_size(expected, plan.task.edge, plan.task.size, "a region");
  for (Strip& s : plan.strips) {
    if (s.given()) {
      fix_nodes(s);
      continue;
    }
    for (const double u : s.fitted.parameters()) s.nodes.push_back(u / s.fitted.end());
    std::sort(s.nodes.begin(), s.nodes.end());
  }
  return plan.task.options.mesher == SkinOptions::Mesher::Fan ? fan(plan) : delaunay(plan);
}

LineRun run_on(const ParametricMesh& mesh, const Strip& strip) {
  if (strip.given()) {
    LineRun run{strip.line, strip.line.given->curve, strip.points, strip.line.given->vertices, {}};
    if (strip.flipped) std::reverse(run.vertices.begin(), run.vertices.end());
    find_edges(mesh, run);
    return run;
  }
  // Vertices on the strip, by their fraction along it.
  const Vec2 d = strip.to - strip.from;
  const double length = d.norm();
  std::vector<std::pair<double, int>> on_strip;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const Vec2 p = mesh.vertices()[v] - strip.from;
    const double fraction = p.dot(d) / (length * length);
    constexpr double near = 1e-11;
    if (std::abs(cross(p, d)) / length < near && fraction > -near && fraction < 1 + near)
      on_strip.emplace_back(std::clamp(fraction, 0.0, 1.0), v);
  }
  std::sort(on_strip.begin(), on_strip.end());
  LineRun run;
  run.line = strip.line;
  run.fitted = strip.flipped ? strip.fitted.backwards() : strip.fitted;
  if (strip.flipped) {
    std::reverse(on_strip.begin(), on_strip.end());
    for (auto& [fraction, v] : on_strip) fraction = 1 - fraction;
  }
  for (const auto& [fraction, v] : on_strip) {
    run.vertices.push_back(v);
    run.parameters.push_back(fraction * strip.fitted.end());
  }
  find_edges(mesh, run);
  return run;
}

}  // namespace batten
