#include "batten/skinning/domains/surface_interpolation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/fairing/curves/input_curve.h"
#include "batten/skinning/domains/annulus_domain.h"

namespace batten {

Points interpolate_surface(const ParametricMesh& mesh,
                           const std::function<FirstOrderJet(const Vec2& uv)>& surface,
                           Points* edge_midpoints) {
  if (edge_midpoints) edge_midpoints->resize(mesh.edge_count(), 3);
  const DofMap map(mesh);
  Points q(map.count(), 3);
  parallel_for_each<16>(mesh.vertex_count(), [&](int v) {
    const FirstOrderJet s = surface(mesh.vertices()[v]);
    q.row(map.vertex(v)) = s.x;
    q.row(map.vertex(v, 1)) = s.gradient.col(0);
    q.row(map.vertex(v, 2)) = s.gradient.col(1);
  });
  parallel_for_each<16>(mesh.edge_count(), [&](int e) {
    const auto& edge = mesh.edges()[e];
    const auto& corner = mesh.shape(edge.triangle[0]).vertex;
    const int i = edge.local[0];
    const Vec2 middle = (corner[(i + 1) % 3] + corner[(i + 2) % 3]) / 2;
    const FirstOrderJet s = surface(middle);
    q.row(map.edge(e)) = s.gradient * mesh.edge_normal(e);
    if (edge_midpoints) edge_midpoints->row(e) = s.x;
  });
  return q;
}

namespace {

constexpr int kSamples = 256;  // around a section
using Section = std::vector<Vec3>;

double wrapped_index(double s) { return fractional_part(s) * kSamples; }

Vec3 at(const Section& section, double s) {
  const double x = wrapped_index(s);
  const int i = std::min(static_cast<int>(x), kSamples - 1);
  const double f = x - i;
  return (1 - f) * section[static_cast<size_t>(i)] +
         f * section[static_cast<size_t>((i + 1) % kSamples)];
}

// A boundary circle sampled at equal steps of u.
Section circle_samples(const RegionGeometry& ring, size_t loop) {
  const ParametricMesh& mesh = *ring.mesh;
  Section section(kSamples, Vec3::Zero());
  for (const BoundarySegment& piece : ring.boundary[loop]) {
    const EdgeAlignedLine& aligned_line = ring.edge_aligned[static_cast<size_t>(piece.index)];
    const HermiteCurve pcurve = edge_aligned_pcurve(mesh, aligned_line);
    const double from = pcurve.evaluate(pcurve.start()).x(),
                 to = from + (pcurve.position(pcurve.node_count() - 1) - pcurve.position(0)).x();
    const double span = std::abs(to - from) > 0 ? to - from : mesh.period();
    for (int k = 0; k < kSamples; ++k)
      for (const int around : {-1, 0, 1}) {
        const double f = (mesh.period() * (k / double(kSamples) + around) - from) / span;
        if (f < 0 || f > 1) continue;
        const double p = aligned_line.parameters.front() +
                         f * (aligned_line.parameters.back() - aligned_line.parameters.front());
        section[static_cast<size_t>(k)] = aligned_line.fitted.evaluate(p);
      }
  }
  return section;
}

Section even_points(const SmoothSegment& line) {
  const ArcLength arc(line.curve);
  Section section;
  for (int k = 0; k < kSamples; ++k)
    section.push_back(line.curve->evaluate(arc.parameter(arc.total() * k / kSamples)));
  return section;
}

// A section resampled from the start point and in the direction that make it nearest to `before`.
Section matched(const Section& section, const Section& before) {
  double least = std::numeric_limits<double>::infinity();
  int phase = 0, direction = 1;
  const auto place = [](int k) {
    return static_cast<size_t>((k % kSamples + kSamples) % kSamples);
  };
  for (const int d : {1, -1})
    for (int p = 0; p < kSamples; ++p) {
      double sum = 0;
      for (int k = 0; k < kSamples; k += 4)
        sum += (section[place(p + d * k)] - before[static_cast<size_t>(k)]).squaredNorm();
      if (sum < least) least = sum, phase = p, direction = d;
    }
  // Shift between samples, from one Gauss-Newton step.
  double slope = 0, bend = 0;
  for (int k = 0; k < kSamples; ++k) {
    const Vec3 tangent = 0.5 * (section[place(phase + direction * k + 1)] -
                                section[place(phase + direction * k - 1)]);
    slope += tangent.dot(before[static_cast<size_t>(k)] - section[place(phase + direction * k)]);
    bend += tangent.squaredNorm();
  }
  const double shift = bend > 0 ? std::clamp(slope / bend, -0.5, 0.5) : 0;
  Section result;
  for (int k = 0; k < kSamples; ++k)
    result.push_back(at(section, (phase + shift + direction * k) / kSamples));
  return result;
}

}  // namespace

Surface interpolate_sections(const RegionGeometry& ring, const std::vector<SmoothSegment>& sections,
                             TriangleElement element) {
  std::vector<Section> row{circle_samples(ring, 0)};
  for (const SmoothSegment& section : sections)
    row.push_back(matched(even_points(section), row.back()));
  row.push_back(circle_samples(ring, 1));
  std::vector<double> t{0};
  for (size_t i = 1; i < row.size(); ++i) {
    double distance = 0;
    for (int k = 0; k < kSamples; ++k)
      distance += (row[i][static_cast<size_t>(k)] - row[i - 1][static_cast<size_t>(k)]).norm();
    t.push_back(t.back() + distance);
  }
  for (double& x : t) x /= t.back();
  const ParametricMesh& mesh = *ring.mesh;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vec2& p : mesh.vertices()) low = std::min(low, p.y()), high = std::max(high, p.y());
  const auto place = [&](const Vec2& uv, int order) {
    Points x(isize(row), 3);
    for (size_t i = 0; i < row.size(); ++i)
      x.row(static_cast<long>(i)) = at(row[i], uv.x() / mesh.period());
    const HermiteCurve along(t, x, not_a_knot_slopes(t, x));
    return along.evaluate((uv.y() - low) / (high - low), order);
  };
  Points dofs = interpolate_surface(mesh, [&](const Vec2& uv) {
    const double h = mesh.period() / kSamples;
    FirstOrderJet s{place(uv, 0), {}};
    s.gradient << (place(uv + Vec2(h, 0), 0) - place(uv - Vec2(h, 0), 0)) / (2 * h),
        place(uv, 1) / (high - low);
    return s;
  });
  return {ring.mesh, element, std::move(dofs), ring.trim};
}

}  // namespace batten
