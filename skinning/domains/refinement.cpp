// Halving triangles where embedded lines need smaller ones.
#include <algorithm>
#include <cmath>

#include "batten/core/plane.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/domains/domain_task.h"
#include "batten/skinning/region/quality.h"

namespace batten {
namespace {

constexpr int kGapSamples = 20;  // between points

// No triangle becomes smaller.
double smallest_size(const DomainTask& task) { return task.edge / task.size / 64; }

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
    if (!any) return;
    halve(parts, marked);
  }
}

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
    for (size_t l = 0; l < gaps.size(); ++l)
      between_points(parts.embedded[l], [&](size_t interval, double t) {
        if (gaps[l][interval] * std::pow(8.0, -0.5 * pass) <= target) return;
        const int triangle = now.locate(flat(parts.embedded[l].image.evaluate(t))).triangle;
        if (local_size(*parts.mesh, triangle) < 1.5 * smallest) return;
        marked[triangle] = 1;
        here = true;
      });
    if (!here) break;
    any = true;
    halve(parts, marked);
  }
  if (!any) return false;
  cut_and_place(parts, task);
  return true;
}

}  // namespace batten
