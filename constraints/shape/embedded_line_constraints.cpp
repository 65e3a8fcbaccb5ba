#include "batten/constraints/shape/embedded_line_constraints.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "batten/core/errors.h"
#include "batten/core/planar_geometry.h"
#include "batten/elements/quadrature.h"

namespace batten {
namespace {

// The size of a triangle to a line through it: h = √(2 area), but the length of an edge that the
// line runs along: there it meets the dofs of that edge alone, and a longer edge has no more.
double size_along(const TriangleShape& shape, const Vec3& L, const Vec2& direction) {
  constexpr double beside = 0.1, parallel = 0.1;
  double h = std::sqrt(2 * shape.area);
  for (int i = 0; i < 3; ++i) {
    const Vec2 edge = shape.vertex[(i + 2) % 3] - shape.vertex[(i + 1) % 3];
    const double sine = std::abs(cross(edge, direction)) / (edge.norm() * direction.norm());
    if (L[i] < beside && sine < parallel) h = std::max(h, edge.norm());
  }
  return h;
}

}  // namespace

std::vector<double> embedded_point_parameters(const ParametricMesh& mesh,
                                              const TriangleLocator& locator,
                                              const HermiteCurve& pcurve,
                                              const PointSpacing& spacing,
                                              std::vector<double> required) {
  // ∫ ds/h along the line, sampled so finely that every triangle is seen.
  const auto density = [&](double t) {
    const Location where = locator.locate(drop_z(pcurve.evaluate(t)));
    const Vec2 slope = drop_z(pcurve.evaluate(t, 1));
    return slope.norm() / size_along(mesh.shape(where.triangle), where.L, slope);
  };
  required.push_back(pcurve.start());
  required.push_back(pcurve.end());
  std::sort(required.begin(), required.end());
  const double span = pcurve.end() - pcurve.start();
  std::vector<double> breaks;
  for (const double t : required)
    if (t >= pcurve.start() && t <= pcurve.end() &&
        (breaks.empty() || t - breaks.back() > 1e-9 * span))
      breaks.push_back(t);
  if (pcurve.end() - breaks.back() < 1e-9 * span) breaks.back() = pcurve.end();

  std::vector<double> points;
  for (size_t b = 0; b + 1 < breaks.size(); ++b) {
    const double from = breaks[b], to = breaks[b + 1];
    int samples = 16;
    std::vector<double> sum;
    for (;; samples *= 2) {
      sum.assign(1, 0);
      for (int i = 0; i < samples; ++i)
        sum.push_back(sum.back() +
                      density(from + (to - from) * (i + 0.5) / samples) * (to - from) / samples);
      if (samples >= 8 * sum.back() || samples >= 1 << 20) break;
    }
    // A loop needs three points at least to be a loop.
    const int fewest = pcurve.closed() && breaks.size() == 2 ? 6 : 1;
    const int steps =
        std::max(fewest, static_cast<int>(std::ceil(sum.back() / spacing.step - 1e-9)));
    const auto at = [&](double position) {
      const double target = sum.back() * position / steps;
      const auto above = std::upper_bound(sum.begin(), sum.end(), target);
      const auto i = std::clamp<long>(above - sum.begin() - 1, 0, samples - 1);
      const double within = (target - sum[i]) / (sum[i + 1] - sum[i]);
      return from + (to - from) * (static_cast<double>(i) + within) / samples;
    };
    points.push_back(from);
    const bool first = b == 0 && !pcurve.closed(),
               last = b + 2 == breaks.size() && !pcurve.closed();
    for (int k = 0; k < steps; ++k) {
      const bool halved = (first && k < spacing.extra_end_points) ||
                          (last && steps - 1 - k < spacing.extra_end_points);
      if (halved) points.push_back(at(k + 0.5));
      if (k + 1 < steps) points.push_back(at(k + 1));
    }
  }
  if (!pcurve.closed()) points.push_back(pcurve.end());
  return points;
}

EmbeddedLineConstraints::EmbeddedLineConstraints(const ParametricMesh& mesh, TriangleElement kind,
                                                 const TriangleLocator& locator, ConstraintSet& set)
    : mesh_(mesh), kind_(kind), locator_(locator), set_(set), dofs_(mesh) {
  if (set.dof_count() != dofs_.count())
    throw InputError("constraints on " + std::to_string(set.dof_count()) +
                     " dofs for a mesh with " + std::to_string(dofs_.count()));
}

Location EmbeddedLineConstraints::on_mesh(const std::string& name, const Vec2& uv) const {
  const Location where = locator_.locate(uv);
  const TriangleShape shape = mesh_.shape(where.triangle);
  const Vec2 there = shape.point(where.L);
  const double away = (there - mesh_.image_near(uv, there)).norm();
  if (!(away <= 1e-9 * std::sqrt(shape.area)))
    throw InputError("constraint '" + name + "' leaves the mesh at (" + format_number(uv.x()) +
                     ", " + format_number(uv.y()) + ")");
  return where;
}

void EmbeddedLineConstraints::points(const std::string& name, const HermiteCurve& pcurve,
                                     const HermiteCurve& curve,
                                     const std::vector<double>& parameters) {
  for (const double t : parameters) {
    const Location where = on_mesh(name, drop_z(pcurve.evaluate(t)));
    const Vec12 N = C1Triangle(kind_, mesh_.shape(where.triangle)).evaluate(where.L).col(kW);
    const auto dof = dofs_.triangle(mesh_, where.triangle);
    std::vector<ConstraintSet::Entry> entries;
    for (int a = 0; a < 12; ++a)
      if (N[a] != 0) entries.push_back({dof[a], N[a]});
    set_.add(name, std::move(entries), curve.evaluate(t));
  }
}

void EmbeddedLineConstraints::integrate_hats(const HermiteCurve& pcurve,
                                             const std::vector<double>& parameters,
                                             const std::function<void(size_t)>& begin,
                                             const Visit& visit,
                                             const std::function<void()>& end) const {
  static const SegmentRule gauss = gauss_legendre(6);
  const size_t n = parameters.size();
  const double around = pcurve.end() - pcurve.start();
  for (size_t k = 0; k < n; ++k) {
    begin(k);
    double length = 0;
    struct Sample {
      double t, weight;
    };
    std::vector<Sample> samples;
    for (const int side : {-1, 1}) {
      if (!pcurve.closed() && ((k == 0 && side < 0) || (k + 1 == n && side > 0))) continue;
      double other = parameters[(k + n + static_cast<size_t>(side)) % n];
      if (side < 0 && other >= parameters[k]) other -= around;
      if (side > 0 && other <= parameters[k]) other += around;
      for (long g = 0; g < gauss.s.size(); ++g) {
        const double s = gauss.s[g], t = parameters[k] + s * (other - parameters[k]);
        const double ds = gauss.weights[g] * std::abs(other - parameters[k]) *
                          drop_z(pcurve.evaluate(t, 1)).norm();
        samples.push_back({t, (1 - s) * ds});
        length += (1 - s) * ds;
      }
    }
    for (const Sample& sample : samples) {
      const Vec2 d = drop_z(pcurve.evaluate(sample.t, 1)).normalized();
      visit(sample.t, sample.weight / length, Vec2(-d.y(), d.x()),
            locator_.locate(drop_z(pcurve.evaluate(sample.t))));
    }
    end();
  }
}

void EmbeddedLineConstraints::slope(const std::string& name, const HermiteCurve& pcurve,
                                    const std::vector<double>& parameters,
                                    const std::function<Vec3(double)>& g) {
  std::map<int, double> row;
  Vec3 value = Vec3::Zero();
  integrate_hats(
      pcurve, parameters,
      [&](size_t) {
        row.clear();
        value.setZero();
      },
      [&](double t, double weight, const Vec2& nu, const Location& where) {
        const Tabulation N = C1Triangle(kind_, mesh_.shape(where.triangle)).evaluate(where.L);
        const auto dof = dofs_.triangle(mesh_, where.triangle);
        for (int a = 0; a < 12; ++a)
          row[dof[a]] += weight * (nu.x() * N(a, kU) + nu.y() * N(a, kV));
        value += weight * g(t);
      },
      [&] {
        std::vector<ConstraintSet::Entry> entries;
        for (const auto& [dof, coefficient] : row) entries.push_back({dof, coefficient});
        set_.add(name, std::move(entries), value);
      });
}

void EmbeddedLineConstraints::normal(const std::string& name, const HermiteCurve& pcurve,
                                     const std::vector<double>& parameters,
                                     const std::function<Vec3(double)>& n) {
  std::map<int, Vec3> row;
  integrate_hats(
      pcurve, parameters, [&](size_t) { row.clear(); },
      [&](double t, double weight, const Vec2& nu, const Location& where) {
        const Tabulation N = C1Triangle(kind_, mesh_.shape(where.triangle)).evaluate(where.L);
        const auto dof = dofs_.triangle(mesh_, where.triangle);
        const Vec3 direction = n(t);
        for (int a = 0; a < 12; ++a) {
          const double slope = weight * (nu.x() * N(a, kU) + nu.y() * N(a, kV));
          row.try_emplace(dof[a], Vec3::Zero()).first->second += slope * direction;
        }
      },
      [&] {
        std::vector<ConstraintSet::CoupledEntry> entries;
        for (const auto& [dof, coefficient] : row) entries.push_back({dof, coefficient});
        set_.add_coupled(name, std::move(entries), 0);
      });
}

}  // namespace batten
