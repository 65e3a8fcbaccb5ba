// SPDX-License-Identifier: MPL-2.0
#include "batten/constraints/shape/shape_constraints.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/elements/hermite_segment.h"
#include "batten/elements/quadrature.h"

namespace batten {
namespace {

Vec3 unit(const std::string& name, const Vec3& v) {
  const double length = v.norm();
  if (!(length > 0) || !std::isfinite(length))
    throw InputError("constraint '" + name + "': found a direction of length " +
                     format_number(length) + ", expected a length above 0");
  return v / length;
}

}  // namespace

CurveConstraints::CurveConstraints(const CurveMesh& mesh, ConstraintSet& set)
    : mesh_(mesh), set_(set) {
  if (set.dof_count() != mesh.dof_count())
    throw InputError("found a constraint set of " + std::to_string(set.dof_count()) +
                     " dofs, expected " + std::to_string(mesh.dof_count()) + " of the curve");
}

void CurveConstraints::uncoupled(const std::string& name, double u, int order, const Vec3& value) {
  const auto at = mesh_.locate(u);
  const auto H = HermiteSegment(mesh_.length(at.segment)).evaluate(at.s, order);
  const auto dof = mesh_.segment_dofs(at.segment);
  std::vector<ConstraintSet::Entry> entries;
  for (int a = 0; a < 4; ++a)
    if (H[a] != 0) entries.push_back({dof[a], H[a]});
  set_.add(name, std::move(entries), value);
}

void CurveConstraints::point(const std::string& name, double u, const Vec3& position) {
  uncoupled(name, u, 0, position);
}

void CurveConstraints::derivative(const std::string& name, double u, const Vec3& derivative) {
  uncoupled(name, u, 1, derivative);
}

void CurveConstraints::zero_curvature(const std::string& name, double u) {
  uncoupled(name, u, 2, Vec3::Zero());
}

void CurveConstraints::direction(const std::string& name, double u, const Vec3& tau) {
  const Vec3 t = unit(name, tau);
  const auto at = mesh_.locate(u);
  const auto H = HermiteSegment(mesh_.length(at.segment)).evaluate(at.s, 1);
  const auto dof = mesh_.segment_dofs(at.segment);
  const Vec3 r = t.unitOrthogonal();
  for (const Vec3& across : {r, Vec3(t.cross(r))}) {
    std::vector<ConstraintSet::CoupledEntry> entries;
    for (int a = 0; a < 4; ++a)
      if (H[a] != 0) entries.push_back({dof[a], H[a] * across});
    set_.add_coupled(name, std::move(entries), 0);
  }
}

void CurveConstraints::in_plane(const std::string& name, const Vec3& through, const Vec3& normal) {
  const Vec3 n = unit(name, normal);
  for (int node = 0; node < mesh_.node_count(); ++node) {
    set_.add_coupled(name, {{mesh_.position_dof(node), n}}, n.dot(through));
    set_.add_coupled(name, {{mesh_.slope_out(node), n}}, 0);
    if (mesh_.is_corner(node)) set_.add_coupled(name, {{mesh_.slope_in(node), n}}, 0);
  }
}

void CurveConstraints::symmetric(const std::string& name, const Vec3& through, const Vec3& normal) {
  const Vec3 n = unit(name, normal);
  const double d = n.dot(through), whole = mesh_.end() - mesh_.start();
  const int count = mesh_.node_count();
  const auto image = [&](int node) {
    return mesh_.closed() ? (count - node) % count : count - 1 - node;
  };
  for (int i = 0; i < count; ++i) {
    const int j = image(i);
    const double mirrored =
        mesh_.closed() && i == 0 ? 0 : whole - (mesh_.parameters()[j] - mesh_.start());
    if (std::abs(mesh_.parameters()[i] - mesh_.start() - mirrored) > 1e-9 * whole ||
        mesh_.is_corner(i) != mesh_.is_corner(j))
      throw InputError("constraint '" + name + "': node " + std::to_string(i) +
                       " of the curve has no mirror image");
  }
  const Mat3 R = Mat3::Identity() - 2 * n * n.transpose();
  // a = sign R b + offset
  const auto pair = [&](int a, int b, double sign, const Vec3& offset) {
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 e = Vec3::Unit(axis);
      set_.add_coupled(name, {{a, e}, {b, -sign * (R * e)}}, e.dot(offset));
    }
  };
  for (int i = 0; i < count; ++i) {
    const int j = image(i);
    if (i < j) {
      pair(mesh_.position_dof(i), mesh_.position_dof(j), 1, 2 * d * n);
      pair(mesh_.slope_out(i), mesh_.slope_in(j), -1, Vec3::Zero());
      if (mesh_.is_corner(i)) pair(mesh_.slope_in(i), mesh_.slope_out(j), -1, Vec3::Zero());
    } else if (i == j) {
      set_.add_coupled(name, {{mesh_.position_dof(i), n}}, d);
      if (mesh_.is_corner(i)) {
        pair(mesh_.slope_in(i), mesh_.slope_out(i), -1, Vec3::Zero());
      } else {
        const Vec3 r = n.unitOrthogonal();
        set_.add_coupled(name, {{mesh_.slope_out(i), r}}, 0);
        set_.add_coupled(name, {{mesh_.slope_out(i), n.cross(r)}}, 0);
      }
    }
  }
}

namespace {

Vec3 unit(const std::string& name, const char* what, const Vec3& v) {
  const double length = v.norm();
  if (!(length > 0) || !std::isfinite(length))
    throw InputError("constraint '" + name + "': the " + what + " is zero or not finite");
  return v / length;
}

}  // namespace

SurfaceConstraints::SurfaceConstraints(const ParametricMesh& mesh, TriangleElement kind,
                                       ConstraintSet& set)
    : mesh_(mesh), kind_(kind), set_(set), dofs_(mesh) {
  if (set.dof_count() != dofs_.count())
    throw InputError("found a constraint set of " + std::to_string(set.dof_count()) +
                     " dofs, expected " + std::to_string(dofs_.count()) + " of the mesh");
}

void SurfaceConstraints::point(const std::string& name, int vertex, const Vec3& position) {
  set_.fix(name, dofs_.vertex(vertex), position);
}

void SurfaceConstraints::point(const std::string& name, const Location& where,
                               const Vec3& position) {
  const Vec12 N = C1Triangle(kind_, mesh_.shape(where.triangle)).evaluate(where.L).col(kW);
  const auto dof = dofs_.triangle(mesh_, where.triangle);
  std::vector<ConstraintSet::Entry> entries;
  for (int a = 0; a < 12; ++a)
    if (N[a] != 0) entries.push_back({dof[a], N[a]});
  set_.add(name, std::move(entries), position);
}

void SurfaceConstraints::tangent(const std::string& name, int vertex, const Vec2& s,
                                 const Vec3& tau) {
  const Vec3 direction = unit(name, "tangent", tau);
  if (!(s.norm() > 0))
    throw InputError("constraint '" + name + "': the parametric direction has length 0");
  const Vec2 p = s.normalized();
  const Vec3 r1 = direction.unitOrthogonal(), r2 = direction.cross(r1);
  for (const Vec3& r : {r1, r2})
    set_.add_coupled(
        name, {{dofs_.vertex(vertex, 1), p.x() * r}, {dofs_.vertex(vertex, 2), p.y() * r}}, 0);
}

void SurfaceConstraints::normal(const std::string& name, int vertex, const Vec3& n) {
  const Vec3 direction = unit(name, "normal", n);
  set_.add_coupled(name, {{dofs_.vertex(vertex, 1), direction}}, 0);
  set_.add_coupled(name, {{dofs_.vertex(vertex, 2), direction}}, 0);
}

void SurfaceConstraints::add_slope_constraint(const std::string& name, const Location& where,
                                              const Vec2& s, const Vec3& r) {
  const Tabulation N = C1Triangle(kind_, mesh_.shape(where.triangle)).evaluate(where.L);
  const auto dof = dofs_.triangle(mesh_, where.triangle);
  std::vector<ConstraintSet::CoupledEntry> entries;
  for (int a = 0; a < 12; ++a)
    if (const double slope = s.x() * N(a, kU) + s.y() * N(a, kV); slope != 0)
      entries.push_back({dof[a], slope * r});
  set_.add_coupled(name, std::move(entries), 0);
}

void SurfaceConstraints::tangent(const std::string& name, const Location& where, const Vec2& s,
                                 const Vec3& tau) {
  const Vec3 direction = unit(name, "tangent", tau);
  if (!(s.norm() > 0))
    throw InputError("constraint '" + name + "': the parametric direction has length 0");
  const Vec3 r1 = direction.unitOrthogonal(), r2 = direction.cross(r1);
  for (const Vec3& r : {r1, r2}) add_slope_constraint(name, where, s.normalized(), r);
}

void SurfaceConstraints::normal(const std::string& name, const Location& where, const Vec3& n) {
  const Vec3 direction = unit(name, "normal", n);
  add_slope_constraint(name, where, Vec2::UnitX(), direction);
  add_slope_constraint(name, where, Vec2::UnitY(), direction);
}

void SurfaceConstraints::curve(const std::string& name, const std::vector<int>& vertices,
                               const std::vector<double>& parameters, const HermiteCurve& curve,
                               const Vec2& direction) {
  if (vertices.size() != parameters.size() || vertices.size() < 2)
    throw InputError("constraint '" + name + "': found " + std::to_string(vertices.size()) +
                     " vertices and " + std::to_string(parameters.size()) +
                     " parameters, expected equal numbers, 2 or more");
  const Vec2 t = direction.normalized();
  const double run = mesh_.chain_vector(vertices).dot(t);
  const double speed = (parameters.back() - parameters.front()) / run;
  const bool around = vertices.front() == vertices.back();
  for (size_t i = 0; i + around < vertices.size(); ++i) {
    const int v = vertices[i];
    set_.fix(name, dofs_.vertex(v), curve.evaluate(parameters[i]));
    set_.add(name, {{dofs_.vertex(v, 1), t.x()}, {dofs_.vertex(v, 2), t.y()}},
             speed * curve.evaluate(parameters[i], 1));
  }
}

void SurfaceConstraints::constant_normal(const std::string& name, const std::vector<int>& edges,
                                         const Vec3& n) {
  const Vec3 direction = unit(name, "normal", n);
  for (const int e : edges) {
    const auto& edge = mesh_.edges()[e];
    set_.add_coupled(
        name, {{dofs_.vertex(edge.high), direction}, {dofs_.vertex(edge.low), -direction}}, 0);
    for (const int v : {edge.low, edge.high}) normal(name, v, n);
    set_.add_coupled(name, {{dofs_.edge(e), direction}}, 0);
  }
}

void SurfaceConstraints::varying_normal(const std::string& name, const std::vector<int>& edges,
                                        const std::function<Vec3(int, double)>& n,
                                        bool edge_curve_is_fixed) {
  for (const int e : edges) {
    const auto& edge = mesh_.edges()[e];
    const Vec2 t = mesh_.edge_tangent(e), nu = mesh_.edge_normal(e);
    const double length = mesh_.edge_length(e);
    for (const auto& [v, s] : {std::pair(edge.low, 0.0), std::pair(edge.high, 1.0)}) {
      const Vec3 direction = unit(name, "normal", n(e, s));
      for (const Vec2& d : edge_curve_is_fixed ? std::vector<Vec2>{nu} : std::vector<Vec2>{nu, t})
        set_.add_coupled(
            name,
            {{dofs_.vertex(v, 1), d.x() * direction}, {dofs_.vertex(v, 2), d.y() * direction}}, 0);
    }
    const Vec3 middle = unit(name, "normal", n(e, 0.5));
    set_.add_coupled(name, {{dofs_.edge(e), middle}}, 0);
    if (edge_curve_is_fixed) continue;
    // Tangential derivative at the midpoint of the cubic: 3/2 (w_b - w_a)/length -
    // (w_t,a + w_t,b)/4.
    std::vector<ConstraintSet::CoupledEntry> row = {
        {dofs_.vertex(edge.high), 1.5 / length * middle},
        {dofs_.vertex(edge.low), -1.5 / length * middle}};
    for (const int v : {edge.low, edge.high})
      for (int d = 0; d < 2; ++d) row.push_back({dofs_.vertex(v, 1 + d), -0.25 * t[d] * middle});
    set_.add_coupled(name, std::move(row), 0);
  }
}

namespace {

// Element size along a curve: h = √(2 area), or the length of an edge that the curve runs along. In
// that case the curve only involves the dofs of this edge, and a longer edge has no more of them.
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
  // ∫ ds/h along the curve, sampled finely enough to see every triangle.
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
    // A closed curve needs at least three points.
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
    throw InputError("found a constraint set of " + std::to_string(set.dof_count()) +
                     " dofs, expected " + std::to_string(dofs_.count()) + " of the mesh");
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
