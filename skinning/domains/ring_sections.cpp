#include "batten/skinning/domains/ring_sections.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/index.h"
#include "batten/core/plane.h"
#include "batten/fairing/arc_length.h"
#include "batten/fairing/open_spline.h"
#include "batten/skinning/domains/ring_rim.h"
#include "batten/skinning/region/surface_dofs.h"

namespace batten {
namespace {

constexpr int kSamples = 256;  // around a section
using Section = std::vector<Vec3>;

double wrapped_index(double s) { return fraction_of(s) * kSamples; }

Vec3 at(const Section& section, double s) {
  const double x = wrapped_index(s);
  const int i = std::min(static_cast<int>(x), kSamples - 1);
  const double f = x - i;
  return (1 - f) * section[static_cast<size_t>(i)] +
         f * section[static_cast<size_t>((i + 1) % kSamples)];
}

// A rim at equal steps of u.
Section rim_of(const RegionParts& ring, size_t loop) {
  const ParametricMesh& mesh = *ring.mesh;
  Section section(kSamples, Vec3::Zero());
  for (const BoundaryPiece& piece : ring.boundary[loop]) {
    const LineRun& run = ring.runs[static_cast<size_t>(piece.index)];
    const HermiteCurve image = run_image(mesh, run);
    const double from = image.evaluate(image.start()).x(),
                 to = from + (image.position(image.node_count() - 1) - image.position(0)).x();
    const double span = std::abs(to - from) > 0 ? to - from : mesh.period();
    for (int k = 0; k < kSamples; ++k)
      for (const int around : {-1, 0, 1}) {
        const double f = (mesh.period() * (k / double(kSamples) + around) - from) / span;
        if (f < 0 || f > 1) continue;
        const double p =
            run.parameters.front() + f * (run.parameters.back() - run.parameters.front());
        section[static_cast<size_t>(k)] = run.fitted.evaluate(p);
      }
  }
  return section;
}

Section even_points(const Stretch& line) {
  const ArcLength arc(line.curve);
  Section section;
  for (int k = 0; k < kSamples; ++k)
    section.push_back(line.curve->evaluate(arc.parameter(arc.total() * k / kSamples)));
  return section;
}

// A section from the phase and in the direction in which it is nearest to the one before.
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
  // Between samples: the shift that is best to second order.
  double slope = 0, bend = 0;
  for (int k = 0; k < kSamples; ++k) {
    const Vec3 way = 0.5 * (section[place(phase + direction * k + 1)] -
                            section[place(phase + direction * k - 1)]);
    slope += way.dot(before[static_cast<size_t>(k)] - section[place(phase + direction * k)]);
    bend += way.squaredNorm();
  }
  const double shift = bend > 0 ? std::clamp(slope / bend, -0.5, 0.5) : 0;
  Section result;
  for (int k = 0; k < kSamples; ++k)
    result.push_back(at(section, (phase + shift + direction * k) / kSamples));
  return result;
}

}  // namespace

Surface through_sections(const RegionParts& ring, const std::vector<Stretch>& sections,
                         TriangleElement element) {
  std::vector<Section> row{rim_of(ring, 0)};
  for (const Stretch& section : sections) row.push_back(matched(even_points(section), row.back()));
  row.push_back(rim_of(ring, 1));
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
    Points x(count_of(row), 3);
    for (size_t i = 0; i < row.size(); ++i)
      x.row(static_cast<long>(i)) = at(row[i], uv.x() / mesh.period());
    const HermiteCurve along(t, x, open_spline_slopes(t, x));
    return along.evaluate((uv.y() - low) / (high - low), order);
  };
  Points dofs = interpolated(mesh, [&](const Vec2& uv) {
    const double h = mesh.period() / kSamples;
    SurfaceSlope s{place(uv, 0), {}};
    s.by_uv << (place(uv + Vec2(h, 0), 0) - place(uv - Vec2(h, 0), 0)) / (2 * h),
        place(uv, 1) / (high - low);
    return s;
  });
  return {ring.mesh, element, std::move(dofs), ring.trim};
}

}  // namespace batten
